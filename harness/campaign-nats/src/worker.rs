//! A worker: takes cases from a server, carries them out, and reports the results.

use super::carry::{Hands, Maker};
use super::connect::{News, Server, Tell};
use super::error::NatsError;
use super::lease::{Holder, Lease};
use super::message::Place;
use super::room::Room;
use super::take::take;
use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;
use tokio::select;
use tokio::sync::{Mutex, Semaphore, mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};

/// Interval at which the request to stop is checked.
pub(super) const LISTEN: Duration = Duration::from_millis(100);
/// Interval of progress notices.
const TELL: Duration = Duration::from_secs(10);
/// Threads in addition to those of the cases: for name resolution and for unpacking packages.
const THREADS_BESIDE: usize = 2;

#[derive(Debug, Clone)]
pub struct WorkerSettings {
    pub place: Place,
    pub threads: NonZeroUsize,
    pub holder: Holder,
    /// Its version; it carries out only cases of the same version.
    pub version: String,
    /// How long it waits for a bench that another worker holds.
    pub patience: Duration,
}

/// Works until `stop` returns true or a case is interrupted. Cases under way are finished and reported unless their
/// executor interrupts them; the others are handed back. Returns how many it has carried out.
///
/// # Errors
///
/// When the server is unreachable at the start, another worker holds or takes over the bench, or a campaign has another
/// version. A server that becomes unreachable later is waited for.
pub fn work(
    server: &Server,
    settings: &WorkerSettings,
    maker: Maker,
    tell: Arc<dyn Fn(&News) + Send + Sync>,
    stop: impl Fn() -> bool,
) -> Result<u64, NatsError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(settings.threads.get() + THREADS_BESIDE)
        .build()
        .map_err(NatsError::Start)?;
    runtime.block_on(until_stopped(server, settings, maker, &tell, stop))
}

async fn until_stopped(
    server: &Server,
    settings: &WorkerSettings,
    maker: Maker,
    tell: &Tell,
    stop: impl Fn() -> bool,
) -> Result<u64, NatsError> {
    let room = Room::new(server.connect(tell).await?);
    room.furnish().await?;
    room.cases(&settings.place, &settings.version).await?;
    let lease = match &settings.place {
        Place::Virtual => None,
        Place::Bench(name) => {
            let (what, key) = (format!("the bench {name}"), format!("bench.{name}"));
            let WorkerSettings { holder, patience, .. } = settings;
            let lease = Lease::take(&room, &what, &key, holder, *patience, tell).await?;
            tell(&News::Holds(what));
            Some(lease)
        }
    };
    let (say_stop, mut stopping) = watch::channel(false);
    let (refuse, mut refused) = mpsc::channel(1);
    let hands = Arc::new(Hands {
        room: room.clone(),
        place: settings.place.clone(),
        version: settings.version.clone(),
        holder: settings.holder.clone(),
        maker,
        tell: Arc::clone(tell),
        running: Semaphore::new(settings.threads.get()),
        lease: lease.as_ref().map(|lease| lease.standing.clone()),
        stopping: say_stop,
        refused: refuse,
        packages: Mutex::new(VecDeque::new()),
        done: AtomicU64::new(0),
        unreported: AtomicUsize::new(0),
    });
    let slots = Arc::new(Semaphore::new(settings.slots()));
    let queue = (settings.place.clone(), settings.version.clone());
    let (send, mut taken) = mpsc::channel(1);
    let taking = tokio::spawn(take(room, queue, slots, send));
    let mut cases = JoinSet::new();
    let (mut listen, mut progress) = (interval(LISTEN), interval(TELL));
    progress.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut told = 0;
    let ended = loop {
        select! {
            _ = listen.tick() => if stop() { break Ok(()) },
            Some(error) = refused.recv() => break Err(error),
            error = lost(lease.as_ref()) => break Err(error),
            _ = stopping.wait_for(|stopping| *stopping) => break Ok(()),
            Some(one) = taken.recv() => {
                cases.spawn(Arc::clone(&hands).carry_out(one));
            }
            Some(_) = cases.join_next() => {}
            _ = progress.tick() => {
                let done = hands.done.load(Ordering::Relaxed);
                if std::mem::replace(&mut told, done) != done {
                    tell(&News::CarriedOut(done));
                }
            }
        }
    };
    hands.stopping.send_replace(true);
    // Cases that were taken but not begun are handed back too.
    while let Ok(one) = taken.try_recv() {
        cases.spawn(Arc::clone(&hands).carry_out(one));
    }
    taking.abort();
    while !cases.is_empty() {
        let unreported = hands.unreported.load(Ordering::Relaxed);
        if unreported > 0 && !hands.room.link.up.borrow().now {
            tell(&News::Unreported(unreported));
        }
        let all = async { while cases.join_next().await.is_some() {} };
        let _ = tokio::time::timeout(TELL, all).await;
    }
    if let Some(lease) = lease {
        lease.release().await;
    }
    // Sends the last messages before the connection is closed.
    let _ = tokio::time::timeout(LISTEN, hands.room.link.client.flush()).await;
    ended.map(|()| hands.done.load(Ordering::Relaxed))
}

async fn lost(lease: Option<&Lease>) -> NatsError {
    match lease {
        Some(lease) => lease.lost().await,
        None => std::future::pending().await,
    }
}

impl WorkerSettings {
    /// Number of cases held at a time: the running ones, and in virtual time as many waiting ones, so that no thread
    /// waits for the server. On a bench a queue would gain nothing.
    fn slots(&self) -> usize {
        match self.place {
            Place::Virtual => 2 * self.threads.get(),
            Place::Bench(_) => self.threads.get(),
        }
    }
}
