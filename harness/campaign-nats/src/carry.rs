//! A worker carries out one job: its lease on it is extended meanwhile, and it is acknowledged when it is reported.

use super::connect::{News, Tell};
use super::error::NatsError;
use super::job::{Done, Job};
use super::lease::{Holder, Standing};
use super::maker::{Maker, Stopping};
use super::message::{Came, Place, Report, Said, id_of, result_subject};
use super::package::Package;
use super::publish::Letter;
use super::room::{PAUSE, Room, STILL_AT_IT};
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

/// How a case ended that was handed out again and again and never came back: it ends whoever carries it out.
pub(super) const WORKER_LOST: &str = "worker_lost";
/// So often a case is handed out. Assumption: a worker that is stopped or refused and a server that restarts hand one
/// back now and then, but not so often.
pub(super) const HANDED_OUT_MAX: i64 = 8;
/// Packages that are kept ready.
const PACKAGES_MAX: usize = 8;
/// Attempts to fetch a package from a server that is there.
const FETCHES_MAX: usize = 5;
/// How long a worker that is to end tries to hand back what it had begun. Assumption: some answers of a server that is
/// there; one that is away hands it out again by itself.
const HAND_BACK: Duration = Duration::from_secs(5);
/// Attempts to acknowledge a case that is reported; without, it is carried out once more and counted once.
const ACKS_MAX: usize = 3;

type Ready = Arc<dyn Executor + Send + Sync>;

/// What all cases of a worker share.
pub(super) struct Hands {
    pub(super) room: Room,
    pub(super) place: Place,
    pub(super) version: String,
    pub(super) holder: Holder,
    pub(super) maker: Maker,
    pub(super) tell: Tell,
    /// One for each case that may run at a time.
    pub(super) running: Semaphore,
    /// The lease on the bench, where there is one.
    pub(super) lease: Option<watch::Receiver<Standing>>,
    /// Nothing more begins.
    pub(super) stopping: watch::Sender<bool>,
    /// Who is told of a campaign of another version.
    pub(super) refused: Sender<NatsError>,
    pub(super) packages: Mutex<VecDeque<(String, Result<Ready, String>)>>,
    pub(super) done: AtomicU64,
    /// Results that the server does not have yet.
    pub(super) unreported: AtomicUsize,
}

/// How a job ended here.
enum Ended {
    /// There is something to report.
    Came(Came),
    /// Nothing more was to begin.
    NotBegun,
    /// It was begun and broken off: somebody wants an end, or the bench did not come up.
    BrokenOff,
}

impl Hands {
    /// Carries out one case and reports it. Its room is free again afterwards.
    pub(super) async fn carry_out(self: Arc<Self>, (message, _room): Taken) {
        let said = match Said::of(message.headers.as_ref(), &self.version) {
            Ok(said) => said,
            Err(other) => {
                // Another worker gets it.
                let _ = message.ack_with(AckKind::Nak(None)).await;
                let (theirs, campaign) = (other.version, other.campaign);
                let ours = self.version.clone();
                // It is told once.
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
                    // What kept this one from its end keeps the next: nothing more begins here.
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
                    // A server that is away does not count the time.
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

    /// Hands back what was begun, as if it had never been handed out: a bench that does not come up and a worker that is
    /// asked to end say nothing of the case, however often.
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
        // It is on the stream once more before it goes.
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
            return Ended::Came(Came::Done(Done::of(CaseResult::ended(WORKER_LOST))));
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
            Ok(done) => Ended::Came(Came::Done(done)),
            Err(_) => Ended::NotBegun,
        }
    }

    /// A processor is free, and the bench is ours beyond doubt.
    async fn may_begin(&self) -> Option<tokio::sync::SemaphorePermit<'_>> {
        let running = self.running.acquire().await.ok();
        if let Some(lease) = &self.lease {
            let _ = lease.clone().wait_for(|standing| *standing == Standing::Held).await;
        }
        running
    }

    /// Who carries out the cases of a package, made when it is first asked for.
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
        let (maker, place) = (Arc::clone(&self.maker), self.place.clone());
        let stopping = Stopping(self.stopping.subscribe());
        let made = tokio::task::spawn_blocking(move || maker(&package, &place, stopping)).await;
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
        // What is carried out is what the name says.
        if package.id() == id { Ok(package) } else { Err(format!("package {id} is not whole")) }
    }

    async fn report(&self, said: &Said, message: &Message, came: Came) -> Result<(), NatsError> {
        let id = id_of(&message.subject);
        let report = Report { worker: self.holder.to_string(), came };
        let letter = Letter {
            subject: result_subject(&said.campaign, id),
            // Carried out twice it is reported once.
            name: name_of(message).to_owned(),
            headers: said.headers(),
            body: serde_json::to_vec(&report).unwrap_or_default(),
        };
        self.room.send(&letter).await.map(|_| ())
    }
}

/// Between a job's name and the number of the message that was handed back.
const BACK: &str = ".back-";

/// The name under which a job was sent; without one, that of the job.
fn name_of(message: &Message) -> &str {
    let name = message.headers.as_ref().and_then(|headers| headers.get(NATS_MESSAGE_ID));
    name.map_or(id_of(&message.subject), |name| name.as_str())
}

/// Where a package lies in the object store.
pub(super) fn package_object(id: &str) -> String {
    format!("packages/{id}.json")
}
