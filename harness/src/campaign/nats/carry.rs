//! A worker carries out one case: its lease on it is extended meanwhile, and it is acknowledged when it is reported.

use super::connect::{News, Tell};
use super::error::NatsError;
use super::lease::{Holder, Standing};
use super::message::{Came, Place, Report, Said, id_of, result_subject};
use super::package::Package;
use super::publish::{Letter, PAUSE};
use super::room::{Room, STILL_AT_IT};
use super::take::Taken;
use super::worker::Maker;
use crate::campaign::case::{Case, CaseResult};
use crate::campaign::executor::Executor;
use crate::campaign::run::guarded;
use async_nats::header::NATS_MESSAGE_ID;
use async_nats::jetstream::{AckKind, Message};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use tokio::select;
use tokio::sync::mpsc::Sender;
use tokio::sync::{Mutex, Semaphore, watch};
use tokio::time::{interval, sleep};

/// How a case ended that was handed out again and again and never came back: it ends whoever carries it out.
pub(super) const WORKER_LOST: &str = "worker_lost";
/// So often a case is handed out. Assumption: a worker that is stopped or refused and a server that restarts hand one
/// back now and then, but not so often.
pub(super) const HANDED_OUT_MAX: i64 = 8;
/// Packages that are kept ready.
const PACKAGES_MAX: usize = 8;
/// Attempts to fetch a package from a server that is there.
const FETCHES_MAX: usize = 5;
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
    pub(super) stopping: watch::Receiver<bool>,
    /// Who is told of a campaign of another version.
    pub(super) refused: Sender<NatsError>,
    pub(super) packages: Mutex<VecDeque<(String, Result<Ready, String>)>>,
    pub(super) done: AtomicU64,
    /// Results that the server does not have yet.
    pub(super) unreported: AtomicUsize,
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
            let came = self.came_of(&said, &message).await?;
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
            None => {
                let _ = message.ack_with(AckKind::Nak(None)).await;
            }
            Some(Ok(())) => {
                self.done.fetch_add(1, Ordering::Relaxed);
                for _ in 0..ACKS_MAX {
                    self.room.link.there().await;
                    if message.double_ack().await.is_ok() {
                        break;
                    }
                }
            }
            Some(Err(error)) => tracing::warn!("{error}"),
        }
    }

    /// None where it was not begun, because nothing more is to begin.
    async fn came_of(&self, said: &Said, message: &Message) -> Option<Came> {
        let times = message.info().map_or(1, |info| info.delivered);
        if times > HANDED_OUT_MAX {
            let case = id_of(&message.subject).to_owned();
            (self.tell)(&News::GivenUp { case, times: HANDED_OUT_MAX });
            return Some(Came::Result(CaseResult::ended(WORKER_LOST)));
        }
        let executor = match self.executor(said).await {
            Ok(executor) => executor,
            Err(cause) => return Some(Came::Refused(cause)),
        };
        let case: Case = match serde_json::from_slice(&message.payload) {
            Ok(case) => case,
            Err(error) => return Some(Came::Refused(format!("its case cannot be read: {error}"))),
        };
        let mut stopping = self.stopping.clone();
        let _running = select! {
            biased;
            _ = stopping.wait_for(|stopping| *stopping) => return None,
            running = self.may_begin() => running,
        };
        let carried_out = move || guarded(&*executor, &case);
        tokio::task::spawn_blocking(carried_out).await.ok().map(Came::Result)
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
        if packages.len() == PACKAGES_MAX {
            packages.pop_front();
        }
        packages.push_back((said.package.clone(), ready.clone()));
        ready
    }

    async fn unpacked(&self, said: &Said) -> Result<Ready, String> {
        let package = self.package(&said.package).await?;
        let (maker, place) = (Arc::clone(&self.maker), self.place.clone());
        let made = tokio::task::spawn_blocking(move || maker(&package, &place)).await;
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
        let name = message.headers.as_ref().and_then(|headers| headers.get(NATS_MESSAGE_ID));
        let report = Report { worker: self.holder.to_string(), came };
        let letter = Letter {
            subject: result_subject(&said.campaign, id),
            // Carried out twice it is reported once.
            name: name.map_or(id, |name| name.as_str()).to_owned(),
            headers: said.headers(),
            body: serde_json::to_vec(&report).unwrap_or_default(),
        };
        self.room.send(&letter).await.map(|_| ())
    }
}

/// Where a package lies in the object store.
pub(super) fn package_object(id: &str) -> String {
    format!("packages/{id}.json")
}
