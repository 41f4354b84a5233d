//! Ports: opened once at start, read and written without blocking, reopened when they vanish.
//!
//! Each port is a task. What it receives goes into one bounded queue for all ports, stamped on arrival; when the queue
//! is full the task waits, and any overflow happens in the operating system. What it sends waits in a bounded queue of
//! its own; what finds no room is dropped and counted.

use crate::arguments::SerialPlace;
use crate::clock::Clock;
use crate::outlet::is_worth_telling;
use controller::Port;
use ports::spec::{SerialDevice, SerialOptions, SerialSpec};
use ports::{ByteEvent, BytePort, FrameEvent, FramePort, PortError, PortLost, PortSpec};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tracing::{error, info, warn};
use wire::can::BitRates;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Received items that wait for the loop.
pub(crate) const HEARD_MAX: usize = 256;
/// Units that wait for a port: more than the controller ever has pending, and few enough that a velocity which waited
/// here is not old.
const OUTGOING_MAX: usize = 16;

/// An event from a port to the loop.
#[derive(Debug)]
pub(crate) enum Heard {
    Bytes(Port, Packet),
    Frame(CanFrame),
    /// The port vanished and did not come back in time.
    GivenUp(Port),
}

/// Common queue of received items of all ports.
pub(crate) type HeardSender = mpsc::Sender<(Timestamp, Heard)>;

/// The loop's end of a port's outgoing queue.
#[derive(Debug)]
pub(crate) struct Outgoing<Unit> {
    port: Port,
    queue: mpsc::Sender<Unit>,
    dropped: Arc<AtomicU64>,
}

impl<Unit> Outgoing<Unit> {
    /// Queues `unit`; never blocks.
    pub(crate) fn send(&self, unit: Unit) {
        if self.queue.try_send(unit).is_err() {
            count_dropped(&self.dropped, self.port, "the port takes no more");
        }
    }

    /// Whether everything has been handed to the port.
    pub(crate) fn is_empty(&self) -> bool {
        self.queue.capacity() == self.queue.max_capacity()
    }

    /// Number of units that were not sent.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

fn count_dropped(dropped: &AtomicU64, port: Port, cause: &str) {
    let count = dropped.fetch_add(1, Ordering::Relaxed) + 1;
    if is_worth_telling(count) {
        warn!(count, "{} port: not sent: {cause}", role(port));
    }
}

/// What a port carries: bytes or frames.
trait Medium: Send + 'static {
    /// What is sent in one operation.
    type Unit: Send + fmt::Debug + 'static;

    /// Waits for the next item; `None` if it is irrelevant to the controller. Cancel-safe.
    fn receive(
        &mut self,
        port: Port,
    ) -> impl Future<Output = Result<Option<Heard>, PortLost>> + Send;

    /// Hands `unit` to the port without waiting; `false` if there was no room.
    fn send(&mut self, now: Timestamp, unit: &Self::Unit) -> bool;

    /// Waits until a lost port is back.
    fn reopen(&mut self) -> impl Future<Output = Result<(), PortError>> + Send;
}

impl Medium for BytePort {
    type Unit = Packet;

    async fn receive(&mut self, port: Port) -> Result<Option<Heard>, PortLost> {
        Ok(match Self::receive(self).await? {
            ByteEvent::Bytes(packet) => Some(Heard::Bytes(port, packet)),
            ByteEvent::Break => None,
        })
    }

    fn send(&mut self, _: Timestamp, packet: &Packet) -> bool {
        Self::send(self, packet.as_slice()) == packet.len()
    }

    async fn reopen(&mut self) -> Result<(), PortError> {
        Self::reopen(self).await
    }
}

impl Medium for FramePort {
    type Unit = CanFrame;

    async fn receive(&mut self, port: Port) -> Result<Option<Heard>, PortLost> {
        Ok(match Self::receive(self).await? {
            FrameEvent::Frame(frame) => Some(Heard::Frame(frame)),
            FrameEvent::Bus(_) => None,
            FrameEvent::Down => {
                warn!("{} port: its interface is down", role(port));
                None
            }
            FrameEvent::Up => {
                info!("{} port: its interface is up", role(port));
                None
            }
        })
    }

    fn send(&mut self, now: Timestamp, frame: &CanFrame) -> bool {
        let lost = self.counters().overrun_frames;
        Self::send(self, now, frame);
        self.counters().overrun_frames == lost
    }

    async fn reopen(&mut self) -> Result<(), PortError> {
        Self::reopen(self).await
    }
}

/// Opens the serial port of a device and keeps it open. The device receives `greeting` whenever it comes back, since it
/// may have lost power. Must be called within the runtime.
///
/// # Errors
/// When the port cannot be opened now.
pub(crate) fn serial(
    port: Port,
    place: SerialPlace,
    greeting: Option<Packet>,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing<Packet>, OpenError> {
    let SerialPlace { path, settings } = place;
    let spec = PortSpec::Serial(at(&path, SerialOptions::default()));
    match BytePort::open(&spec, settings) {
        Ok(open) => Ok(spawn(Task { port, name: path, greeting, heard, clock }, open)),
        Err(error) => Err(OpenError { port, name: path, error }),
    }
}

/// Opens the base's CAN interface and keeps it open.
///
/// # Errors
/// When the interface cannot be opened now.
pub(crate) async fn can(
    interface: String,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing<CanFrame>, OpenError> {
    let spec = PortSpec::Can { interface: interface.clone() };
    frames(interface, spec, heard, clock).await
}

/// Opens the base's CAN adapter on a serial port and keeps it open.
///
/// # Errors
/// When the adapter cannot be opened now.
pub(crate) async fn slcan(
    place: SerialPlace,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing<CanFrame>, OpenError> {
    let baud = Some(place.settings.baud);
    let serial = at(&place.path, SerialOptions { baud, ..SerialOptions::default() });
    frames(place.path, PortSpec::Slcan { serial, bitrate: None }, heard, clock).await
}

async fn frames(
    name: String,
    spec: PortSpec,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing<CanFrame>, OpenError> {
    let port = Port::Base;
    match FramePort::open(&spec, BitRates::USUAL).await {
        Ok(open) => Ok(spawn(Task { port, name, greeting: None, heard, clock }, open)),
        Err(error) => Err(OpenError { port, name, error }),
    }
}

fn at(path: &str, options: SerialOptions) -> SerialSpec {
    SerialSpec { device: SerialDevice::Path(path.to_owned()), options }
}

struct Task<Unit> {
    port: Port,
    name: String,
    greeting: Option<Unit>,
    heard: HeardSender,
    clock: Clock,
}

fn spawn<M: Medium>(task: Task<M::Unit>, open: M) -> Outgoing<M::Unit> {
    let (queue, outgoing) = mpsc::channel(OUTGOING_MAX);
    let (port, dropped) = (task.port, Arc::<AtomicU64>::default());
    info!("{} port {} is open", role(port), task.name);
    tokio::spawn(keep_open(task, open, outgoing, Arc::clone(&dropped)));
    Outgoing { port, queue, dropped }
}

async fn keep_open<M: Medium>(
    task: Task<M::Unit>,
    mut open: M,
    mut outgoing: mpsc::Receiver<M::Unit>,
    dropped: Arc<AtomicU64>,
) {
    let Task { port, name, greeting, heard, clock } = task;
    let role = role(port);
    // If the receiver is gone, the loop has ended; this task will end too.
    let tell = async |what| {
        let _ = heard.send((clock.now(), what)).await;
    };
    loop {
        let lost = tokio::select! {
            received = open.receive(port) => match received {
                Ok(Some(what)) => {
                    tell(what).await;
                    continue;
                }
                Ok(None) => continue,
                Err(lost) => lost,
            },
            Some(unit) = outgoing.recv() => {
                if !open.send(clock.now(), &unit) {
                    count_dropped(&dropped, port, "the port takes no more");
                }
                continue;
            }
        };
        warn!("{role} port {name} is gone: {lost}; trying to open it again");
        if let Err(error) = open.reopen().await {
            error!("{role} port {name} did not come back: {error}");
            return tell(Heard::GivenUp(port)).await;
        }
        // Units that waited for the port are older than its absence.
        while outgoing.try_recv().is_ok() {
            count_dropped(&dropped, port, "the port was gone");
        }
        if let Some(greeting) = &greeting {
            open.send(clock.now(), greeting);
        }
        info!("{role} port {name} is open again");
    }
}

pub(crate) const fn role(port: Port) -> &'static str {
    match port {
        Port::Gyro => "gyro",
        Port::Base => "base",
    }
}

/// A port that could not be opened: which one, why, and what to check.
#[derive(Debug)]
pub(crate) struct OpenError {
    port: Port,
    name: String,
    error: PortError,
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { port, name, error } = self;
        write!(f, "cannot open {} port {name}: {error}", role(*port))?;
        match miette::Diagnostic::help(error) {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for OpenError {}
