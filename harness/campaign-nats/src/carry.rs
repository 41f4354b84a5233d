//! Carries out one job of a worker: extends its lease meanwhile, reports the result, then acknowledges the job.

use super::connect::{News, Tell};
use super::error::NatsError;
use super::job::{Done, Job};
use super::lease::{Holder, Standing};
use super::message::{CASES, Came, Place, Report, Said, id_of, result_subject};
use super::package::Package;
use super::room::{Letter, PAUSE, Room, STILL_AT_IT};
use super::take::Taken;
use async_nats::header::NATS_MESSAGE_ID;
use async_nats::jetstream::{AckKind, Message};
use campaign::CaseResult;
use campaign::Executor;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;
use tokio::select;
use tokio::sync::mpsc::Sender;
use tokio::sync::{Mutex, Semaphore, watch};
use tokio::time::{interval, sleep, timeout};

/// Outcome of a case that was handed out repeatedly without a result: it brings down every worker.
pub(super) const WORKER_LOST: &str = "worker_lost";
/// The most times that a case is handed out. Assumption: stopped or rejected workers and server restarts return a case
/// now and then, but not this often.
pub(super) const HANDED_OUT_MAX: i64 = 8;
/// Number of packages kept ready.
const PACKAGES_MAX: usize = 8;
/// The most attempts to fetch a package from a reachable server.
const FETCHES_MAX: usize = 5;
/// How long a worker that is to end tries to hand back a case it has begun. Assumption: a few answers of a reachable
/// server; an unreachable one hands the case out again by itself.
const HAND_BACK: Duration = Duration::from_secs(5);
/// The most attempts to acknowledge a reported case; without acknowledgement it is carried out again but counted once.
const ACKS_MAX: usize = 3;

type Ready = Arc<dyn Executor + Send + Sync>;

/// Makes the executor for the cases of a package, and returns it with the name of its plan, or the reason why that is
/// impossible. An interrupted case (see [`CaseResult::is_given_up`](campaign::CaseResult::is_given_up)) is
/// handed back, and the worker ends.
pub type Maker = Arc<
    dyn Fn(&Package, Stopping) -> Result<(String, Arc<dyn Executor + Send + Sync>), String>
        + Send
        + Sync,
>;

/// Tells whether the worker is to end, on request or because it lost the bench. Short work is still finished; work of
/// minutes is interrupted.
#[derive(Debug, Clone)]
pub struct Stopping(pub(super) watch::Receiver<bool>);

impl Stopping {
    pub fn is_so(&self) -> bool {
        *self.0.borrow()
    }
}

/// State shared by all cases of a worker.
pub(super) struct Hands {
    pub(super) room: Room,
    pub(super) place: Place,
    pub(super) version: String,
    pub(super) holder: Holder,
    pub(super) maker: Maker,
    pub(super) tell: Tell,
    /// One permit for each case that may run in parallel.
    pub(super) running: Semaphore,
    pub(super) lease: Option<watch::Receiver<Standing>>,
    /// Whether no further case may begin.
    pub(super) stopping: watch::Sender<bool>,
    /// Receives the error when a campaign has another version.
    pub(super) refused: Sender<NatsError>,
    pub(super) packages: Mutex<VecDeque<(String, Result<Ready, String>)>>,
    pub(super) done: AtomicU64,
    /// Number of results that the server has not received yet.
    pub(super) unreported: AtomicUsize,
}

/// How a job ended in this worker.
enum Ended {
    /// With a result to report.
    Came(Came),
    /// Not begun, because the worker is stopping.
    NotBegun,
    /// Begun and interrupted: the worker is to end, or the bench did not start.
    BrokenOff,
}

impl Hands {
    /// Carries out one case and reports it. Its slot is free again afterwards.
    pub(super) async fn carry_out(self: Arc<Self>, (message, _room): Taken) {
        let said = match Said::of(message.headers.as_ref(), &self.version) {
            Ok(said) => said,
            Err(other) => {
                // Another worker gets it.
                let _ = message.ack_with(AckKind::Nak(None)).await;
                let (theirs, campaign) = (other.version, other.campaign);
                let ours = self.version.clone();
                // One error is enough.
                let _ = self.refused.try_send(NatsError::OtherVersion { ours, theirs, campaign });
                return;
            }
        };
        let work = async {
            let came = match self.came_of(&said, &message).await {
                Ended::Came(came) => came,
                Ended::NotBegun => {
                    let _ = message.ack_with(AckKind::Nak(None)).await;
                    return None;
                }
                Ended::BrokenOff => {
                    // The cause of the interruption also affects the next case, so nothing more begins here.
                    self.stopping.send_replace(true);
                    self.put_back(&said, &message).await;
                    return None;
                }
            };
            self.unreported.fetch_add(1, Ordering::Relaxed);
            let sent = self.report(&said, &message, came).await;
            self.unreported.fetch_sub(1, Ordering::Relaxed);
            Some(sent)
        };
        let mut still = interval(STILL_AT_IT);
        tokio::pin!(work);
        let done = loop {
            select! {
                done = &mut work => break done,
                _ = still.tick() => {
                    // May fail: an unreachable server does not count the time.
                    let _ = message.ack_with(AckKind::Progress).await;
                }
            }
        };
        match done {
            None => {}
            Some(Ok(())) => {
                self.done.fetch_add(1, Ordering::Relaxed);
                self.acknowledge(&message).await;
            }
            Some(Err(error)) => tracing::warn!("{error}"),
        }
    }

    async fn acknowledge(&self, message: &Message) {
        for _ in 0..ACKS_MAX {
            self.room.link.there().await;
            if message.double_ack().await.is_ok() {
                break;
            }
        }
    }

    /// Hands back a case as if it had never been handed out. A bench that does not start, or a worker that is to end,
    /// says nothing about the case, however often that occurs.
    async fn put_back(&self, said: &Said, message: &Message) {
        let Ok(sequence) = message.info().map(|info| info.stream_sequence) else { return };
        let name = name_of(message);
        let first = name.split_once(BACK).map_or(name, |(first, _)| first);
        let letter = Letter {
            subject: message.subject.to_string(),
            name: format!("{first}{BACK}{sequence}"),
            headers: said.headers(),
            body: message.payload.to_vec(),
        };
        // Puts it on the stream again before removing it.
        let put_back = async {
            if self.room.send(&letter).await.is_ok() {
                self.acknowledge(message).await;
            }
        };
        let _ = timeout(HAND_BACK, put_back).await;
    }

    async fn came_of(&self, said: &Said, message: &Message) -> Ended {
        let times = message.info().map_or(1, |info| info.delivered);
        if times > HANDED_OUT_MAX {
            let case = id_of(&message.subject).to_owned();
            (self.tell)(&News::GivenUp { case, times: HANDED_OUT_MAX });
            return Ended::Came(Came::Done(Box::new(Done::of(CaseResult::ended(WORKER_LOST)))));
        }
        let executor = match self.executor(said).await {
            Ok(executor) => executor,
            Err(cause) => return Ended::Came(Came::Refused(cause)),
        };
        let job: Job = match serde_json::from_slice(&message.payload) {
            Ok(job) => job,
            Err(error) => {
                return Ended::Came(Came::Refused(format!("its case cannot be read: {error}")));
            }
        };
        let mut stopping = self.stopping.subscribe();
        let _running = select! {
            biased;
            _ = stopping.wait_for(|stopping| *stopping) => return Ended::NotBegun,
            running = self.may_begin() => running,
        };
        let carried_out = tokio::task::spawn_blocking(move || job.carry_out(&*executor)).await;
        match carried_out {
            Ok(done) if done.result.is_given_up() => Ended::BrokenOff,
            Ok(done) => Ended::Came(Came::Done(Box::new(done))),
            Err(_) => Ended::NotBegun,
        }
    }

    /// Waits until a processor is free and the worker certainly holds the bench.
    async fn may_begin(&self) -> Option<tokio::sync::SemaphorePermit<'_>> {
        let running = self.running.acquire().await.ok();
        if let Some(lease) = &self.lease {
            let _ = lease.clone().wait_for(|standing| *standing == Standing::Held).await;
        }
        running
    }

    /// The executor for the cases of a package, made on first use.
    async fn executor(&self, said: &Said) -> Result<Ready, String> {
        let mut packages = self.packages.lock().await;
        if let Some((_, ready)) = packages.iter().find(|(id, _)| *id == said.package) {
            return ready.clone();
        }
        let ready = self.unpacked(said).await;
        if let Err(cause) = &ready {
            let (campaign, cause) = (said.campaign.clone(), cause.clone());
            (self.tell)(&News::Declines { campaign, cause });
        }
        if packages.len() == PACKAGES_MAX {
            packages.pop_front();
        }
        packages.push_back((said.package.clone(), ready.clone()));
        ready
    }

    async fn unpacked(&self, said: &Said) -> Result<Ready, String> {
        let package = self.package(&said.package).await?;
        let (maker, stopping) = (Arc::clone(&self.maker), Stopping(self.stopping.subscribe()));
        let made = tokio::task::spawn_blocking(move || maker(&package, stopping)).await;
        let (plan, ready) = made.map_err(|error| error.to_string())??;
        (self.tell)(&News::Campaign { campaign: said.campaign.clone(), plan });
        Ok(ready)
    }

    async fn package(&self, id: &str) -> Result<Package, String> {
        let mut fetches = 0;
        let bytes = loop {
            self.room.link.there().await;
            fetches += 1;
            match self.room.get(&package_object(id)).await {
                Ok(bytes) => break bytes,
                Err(error) if fetches == FETCHES_MAX => return Err(error.to_string()),
                Err(error) => tracing::debug!("{error}"),
            }
            sleep(PAUSE).await;
        };
        let package = Package::of_json(&bytes).map_err(|error| error.to_string())?;
        // The content must match the name.
        if package.id() == id { Ok(package) } else { Err(format!("package {id} is not whole")) }
    }

    async fn report(&self, said: &Said, message: &Message, came: Came) -> Result<(), NatsError> {
        let id = id_of(&message.subject);
        let report = Report { worker: self.holder.to_string(), came };
        let letter = Letter {
            subject: result_subject(&said.campaign, id),
            // If it is carried out twice, it is reported once.
            name: name_of(message).to_owned(),
            headers: said.headers(),
            body: serde_json::to_vec(&report).unwrap_or_default(),
        };
        let Some(sequence) = self.room.send(&letter).await? else { return Ok(()) };
        // Where a case is carried out twice, the other result may have ended the campaign. The end removes the cases
        // before the results, so a result whose case is still there is removed with the others. A bench keeps it: its
        // cases are also withdrawn when the campaign stops, and it resumes with the result.
        let is_over =
            matches!(self.place, Place::Virtual) && !self.room.holds(CASES, &message.subject).await;
        if is_over {
            self.room.take_back(sequence).await;
        }
        Ok(())
    }
}

/// Separates a job's name from the number of the message that was handed back.
const BACK: &str = ".back-";

/// The name under which a job was sent; without one, the job's own name.
fn name_of(message: &Message) -> &str {
    let name = message.headers.as_ref().and_then(|headers| headers.get(NATS_MESSAGE_ID));
    name.map_or(id_of(&message.subject), |name| name.as_str())
}

pub(super) fn package_object(id: &str) -> String {
    format!("packages/{id}.json")
}
