//! Ports: opened once at start, read and written without blocking, reopened when they vanish.
//!
//! Each port is a task. What it receives goes into one bounded queue for all ports, stamped on arrival; when the queue
//! is full the task waits, and any overflow happens in the operating system. What it sends waits in a bounded queue of
//! its own; what finds no room is dropped and counted.

use crate::arguments::PortPlace;
use crate::outlet::is_worth_telling;
use controller::Port;
use live::world::Clock;
use ports::{AnyPort, ByteEvent, BytePort, FrameEvent, FramePort, PortError, PortLost};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tracing::{error, info, warn};
use wire::can::BitRates;
use wire::device::Transmit;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Received items that wait for the loop.
pub(crate) const HEARD_MAX: usize = 256;
/// Units that wait for a port: more than the controller ever has pending, and few enough that a velocity which waited
/// here is not old.
const OUTGOING_MAX: usize = 16;

#[derive(Debug)]
pub(crate) enum Heard {
    Unit(Port, Transmit),
    /// The port vanished and did not come back in time.
    GivenUp(Port),
}

/// Common queue of received items of all ports.
pub(crate) type HeardSender = mpsc::Sender<(Timestamp, Heard)>;

/// The loop's end of a port's outgoing queue.
#[derive(Debug)]
pub(crate) struct Outgoing {
    port: Port,
    queue: mpsc::Sender<Transmit>,
    dropped: Arc<AtomicU64>,
}

impl Outgoing {
    /// Queues `unit`; never blocks.
    pub(crate) fn send(&self, unit: Transmit) {
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

/// Opens the port of a device and keeps it open. The device receives `greeting` whenever it comes back, since it may
/// have lost power. Must be called within the runtime.
///
/// # Errors
/// When the port cannot be opened now.
pub(crate) async fn open(
    port: Port,
    PortPlace { name, spec, settings }: PortPlace,
    greeting: Option<Packet>,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing, OpenError> {
    let opened = if spec.carries_frames() {
        FramePort::open(&spec, BitRates::USUAL).await.map(AnyPort::Frames)
    } else {
        BytePort::open(&spec, settings).map(|port| AnyPort::Bytes(Box::new(port)))
    };
    let opened = match opened {
        Ok(opened) => opened,
        Err(error) => return Err(OpenError { port, name, error }),
    };
    info!("{} port {name} is open", role(port));
    let (queue, outgoing) = mpsc::channel(OUTGOING_MAX);
    let dropped = Arc::<AtomicU64>::default();
    let task = Task { port, name, open: opened, greeting, heard, clock, dropped: dropped.clone() };
    tokio::spawn(task.keep_open(outgoing));
    Ok(Outgoing { port, queue, dropped })
}

struct Task {
    port: Port,
    name: String,
    open: AnyPort,
    greeting: Option<Packet>,
    heard: HeardSender,
    clock: Clock,
    dropped: Arc<AtomicU64>,
}

impl Task {
    async fn keep_open(mut self, mut outgoing: mpsc::Receiver<Transmit>) {
        let role = role(self.port);
        loop {
            let lost = tokio::select! {
                received = receive(&mut self.open, role) => match received {
                    Ok(Some(what)) => {
                        self.tell(Heard::Unit(self.port, what)).await;
                        continue;
                    }
                    Ok(None) => continue,
                    Err(lost) => lost,
                },
                Some(unit) = outgoing.recv() => {
                    self.send(&unit);
                    continue;
                }
            };
            let name = &self.name;
            warn!("{role} port {name} is gone: {lost}; trying to open it again");
            if let Err(error) = self.open.reopen().await {
                error!("{role} port {name} did not come back: {error}");
                return self.tell(Heard::GivenUp(self.port)).await;
            }
            // Units that waited for the port are older than its absence.
            while outgoing.try_recv().is_ok() {
                count_dropped(&self.dropped, self.port, "the port was gone");
            }
            if let Some(greeting) = self.greeting {
                self.send(&Transmit::Bytes(greeting));
            }
            info!("{role} port {} is open again", self.name);
        }
    }

    async fn tell(&self, what: Heard) {
        // If the receiver is gone, the loop has ended; this task will end too.
        let _ = self.heard.send((self.clock.now(), what)).await;
    }

    /// Hands a unit to the port without waiting.
    fn send(&mut self, unit: &Transmit) {
        let is_sent = match (unit, &mut self.open) {
            (Transmit::Bytes(packet), AnyPort::Bytes(open)) => {
                open.send(packet.as_slice()) == packet.len()
            }
            (Transmit::Frame(frame), AnyPort::Frames(open)) => {
                let lost = open.counters().overrun_frames;
                open.send(self.clock.now(), frame);
                open.counters().overrun_frames == lost
            }
            // The controller's transport matches its port.
            _ => true,
        };
        if !is_sent {
            count_dropped(&self.dropped, self.port, "the port takes no more");
        }
    }
}

/// Waits for the next item; `None` if it is irrelevant to the controller. Cancel-safe.
async fn receive(open: &mut AnyPort, role: &str) -> Result<Option<Transmit>, PortLost> {
    match open {
        AnyPort::Bytes(open) => Ok(match open.receive().await? {
            ByteEvent::Bytes(packet) => Some(Transmit::Bytes(packet)),
            ByteEvent::Break => None,
        }),
        AnyPort::Frames(open) => {
            match open.receive().await? {
                FrameEvent::Frame(frame) => return Ok(Some(Transmit::Frame(frame))),
                FrameEvent::Bus(_) => {}
                FrameEvent::Down => warn!("{role} port: its interface is down"),
                FrameEvent::Up => info!("{role} port: its interface is up"),
            }
            Ok(None)
        }
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
