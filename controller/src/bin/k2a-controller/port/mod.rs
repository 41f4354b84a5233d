//! Ports: opened once at start, read and written without blocking, opened again when they vanish.
//!
//! Each port is a task. What it hears goes into one bounded queue for all ports, stamped on arrival;
//! when that is full the task waits, and what overflows does so in the operating system. What it is to
//! say waits in a bounded queue of its own; what finds no room is dropped and counted.

mod backoff;
mod can;
mod serial;
mod slcan;

pub(crate) use can::CanPort;
pub(crate) use serial::SerialPort;
pub(crate) use slcan::{SETTINGS as SLCAN_SETTINGS, SlcanPort};

use crate::clock::Clock;
use crate::outlet::is_worth_telling;
use backoff::Backoff;
use controller::Port;
use std::fmt;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tracing::{debug, error, info, warn};
use wire::can::CanFrame;
use wire::time::Timestamp;

/// Things heard that wait for the loop.
pub(crate) const HEARD_MAX: usize = 256;
/// Units that wait for a port: more than the controller ever has under way, and few enough that a
/// velocity which waited here is not old.
const OUTGOING_MAX: usize = 16;

/// What a port tells the loop.
#[derive(Debug)]
pub(crate) enum Heard {
    /// Serial bytes.
    Bytes(Port, Vec<u8>),
    /// A CAN frame of the base.
    Frame(CanFrame),
    /// The port vanished and did not come back in time.
    GivenUp(Port),
}

/// A kind of port.
pub(crate) trait Medium: Send + Sync + 'static {
    /// The open port.
    type Link: Send + 'static;
    /// What is sent at once.
    type Unit: Send + fmt::Debug + 'static;

    /// Whose port it is.
    fn port(&self) -> Port;

    /// The name that the user gave it.
    fn name(&self) -> &str;

    /// Opens it. May block for as long as the driver does.
    fn open(&self) -> Result<Self::Link, PortError>;

    /// What has to be sent again after the port vanished, since the device may have lost power.
    fn greeting(&self) -> Option<Self::Unit>;

    /// Passes on what is heard and sends what is outgoing until the link breaks; tells why it did.
    fn converse(
        &self,
        link: Self::Link,
        ears: &Ears,
        outgoing: &mut mpsc::Receiver<Self::Unit>,
    ) -> impl Future<Output = io::Error> + Send;
}

/// Where a port puts what it hears and what it could not send.
#[derive(Debug, Clone)]
pub(crate) struct Ears {
    heard: HeardSender,
    dropped: Arc<AtomicU64>,
    port: Port,
    clock: Clock,
}

impl Ears {
    /// Passes on what was heard now.
    pub(crate) async fn hear(&self, heard: Heard) {
        // The loop has ended; so will this task.
        let _ = self.heard.send((self.clock.now(), heard)).await;
    }

    /// Counts one unit that was not sent.
    pub(crate) fn drop_unit(&self, cause: &str) {
        count_dropped(&self.dropped, self.port, cause);
    }
}

fn count_dropped(dropped: &AtomicU64, port: Port, cause: &str) {
    let count = dropped.fetch_add(1, Ordering::Relaxed) + 1;
    if is_worth_telling(count) {
        warn!(count, "{} port: not sent: {cause}", role(port));
    }
}

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

    /// All has been handed to the port.
    pub(crate) fn is_empty(&self) -> bool {
        self.queue.capacity() == self.queue.max_capacity()
    }

    /// Units that were not sent.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

/// Where all ports put what they hear.
pub(crate) type HeardSender = mpsc::Sender<(Timestamp, Heard)>;

/// Opens a port and keeps it open from then on. Called within the runtime.
///
/// # Errors
/// When it cannot be opened now.
pub(crate) fn spawn<M: Medium>(
    medium: M,
    heard: HeardSender,
    clock: Clock,
) -> Result<Outgoing<M::Unit>, PortError> {
    let link = medium.open()?;
    let (queue, outgoing) = mpsc::channel(OUTGOING_MAX);
    let dropped = Arc::<AtomicU64>::default();
    let port = medium.port();
    let ears = Ears { heard, dropped: Arc::clone(&dropped), port, clock };
    info!("{} port {} is open", role(port), medium.name());
    tokio::spawn(keep_open(Arc::new(medium), link, ears, outgoing, queue.downgrade()));
    Ok(Outgoing { port, queue, dropped })
}

async fn keep_open<M: Medium>(
    medium: Arc<M>,
    first: M::Link,
    ears: Ears,
    mut outgoing: mpsc::Receiver<M::Unit>,
    queue: mpsc::WeakSender<M::Unit>,
) {
    let (role, name) = (role(medium.port()), medium.name());
    let mut backoff = Backoff::default();
    let mut link = first;
    loop {
        let opened = ears.clock.now();
        let cause = medium.converse(link, &ears, &mut outgoing).await;
        backoff.note_life(ears.clock.now() - opened);
        warn!("{role} port {name} is gone: {cause}; trying to open it again");
        link = loop {
            let Some(delay) = backoff.next() else {
                error!("{role} port {name} did not come back");
                return ears.hear(Heard::GivenUp(medium.port())).await;
            };
            tokio::time::sleep(delay).await;
            let opener = Arc::clone(&medium);
            match tokio::task::spawn_blocking(move || opener.open()).await {
                Ok(Ok(link)) => break link,
                Ok(Err(cause)) => debug!("{cause}"),
                Err(cause) => debug!("{role} port {name}: {cause}"),
            }
        };
        // What waited for the port is older than its absence.
        while outgoing.try_recv().is_ok() {
            ears.drop_unit("the port was gone");
        }
        if let (Some(greeting), Some(queue)) = (medium.greeting(), queue.upgrade()) {
            // The queue has just been emptied.
            let _ = queue.try_send(greeting);
        }
        info!("{role} port {name} is open again");
    }
}

/// What a port is called in messages.
pub(crate) const fn role(port: Port) -> &'static str {
    match port {
        Port::Gyro => "gyro",
        Port::Base => "base",
    }
}

/// A port that could not be opened: which, why, and what to look at.
#[derive(Debug)]
pub(crate) struct PortError {
    port: Port,
    name: String,
    cause: String,
    advice: String,
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { port, name, cause, advice } = self;
        write!(f, "cannot open {} port {name}: {cause}; {advice}", role(*port))
    }
}

impl std::error::Error for PortError {}
