//! The coordinator's side: an executor whose cases are carried out by other machines.

use super::carry::package_object;
use super::connect::{News, Server, Tell};
use super::desk::{Ask, Desk, StoredFile};
use super::error::NatsError;
use super::job::{Done, Job};
use super::lease::{Holder, Lease};
use super::message::{Place, Said};
use super::package::Package;
use super::room::{LEASE, Room};
use campaign::Executor;
use campaign::Repeated;
use campaign::WINDOW;
use campaign::{Case, CaseId, CaseResult, Course};
use record::outcome::Outcome;
use std::sync::{Arc, Mutex, PoisonError, mpsc as std_mpsc};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};

/// Requests that can wait for the connection's thread: for each case of the window, its execution and its storage.
const ASKS: usize = 2 * WINDOW as usize;

/// Settings of a campaign over a server.
#[derive(Debug, Clone)]
pub struct RemoteSettings {
    /// The text that determines its cases, as in its journal. The same campaign gets the same name again.
    pub what: String,
    pub place: Place,
    /// The process that runs it.
    pub holder: Holder,
}

/// Has cases carried out by the workers of a server. `E` decides which cases are possible.
#[derive(Debug)]
pub struct Remote<E> {
    local: E,
    package: String,
    campaign: String,
    asks: Option<mpsc::Sender<Ask>>,
    failure: Arc<Mutex<Option<NatsError>>>,
    thread: Option<JoinHandle<()>>,
}

impl<E: Executor> Remote<E> {
    /// Opens a campaign on `server` and uploads what its workers need. Once `stop` returns true, cases are given up as
    /// interrupted.
    ///
    /// # Errors
    ///
    /// When the server is unreachable or of another version, or another process runs the same campaign.
    pub fn open(
        server: &Server,
        package: &Package,
        settings: RemoteSettings,
        local: E,
        tell: Arc<dyn Fn(&News) + Send + Sync>,
        stop: impl Fn() -> bool + Send + 'static,
    ) -> Result<Self, NatsError> {
        let package_id = package.id();
        let campaign = CaseId::of(&[crate::VERSION, &settings.what, &package_id]).to_string();
        let said = Said {
            version: crate::VERSION.to_owned(),
            campaign: campaign.clone(),
            package: package_id.clone(),
            lease: 0,
        };
        let (asks, asked) = mpsc::channel(ASKS);
        let (opened, is_open) = std_mpsc::channel();
        let failure = Arc::default();
        let opening =
            Opening { server: server.clone(), package: package.to_json(), settings, said, tell };
        let failed = Arc::clone(&failure);
        let go = move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let runtime = match runtime {
                Ok(runtime) => runtime,
                Err(error) => return drop(opened.send(Err(NatsError::Start(error)))),
            };
            runtime.block_on(async {
                match opening.open(failed).await {
                    Ok(desk) => {
                        // The caller of `open` waits for it.
                        let _ = opened.send(Ok(()));
                        desk.serve(asked, stop).await;
                    }
                    Err(error) => drop(opened.send(Err(error))),
                }
            });
        };
        let thread = thread::Builder::new().name("nats".to_owned()).spawn(go);
        let thread = Some(thread.map_err(NatsError::Start)?);
        match is_open.recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(error),
            Err(_) => return Err(NatsError::server("open the campaign", "its thread ended")),
        }
        Ok(Self { local, package: package_id, campaign, asks: Some(asks), failure, thread })
    }

    /// The local executor, which decides which cases are possible.
    pub const fn local(&self) -> &E {
        &self.local
    }

    pub fn campaign(&self) -> &str {
        &self.campaign
    }

    /// The error for which cases are given up without a request to stop.
    pub fn failure(&self) -> Option<NatsError> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Ends the campaign: stores `files` on the server and removes everything else of it.
    ///
    /// # Errors
    ///
    /// When the server does not accept them.
    pub fn finish(&self, files: Vec<StoredFile>) -> Result<(), NatsError> {
        let (answer, answered) = oneshot::channel();
        self.ask(Ask::Finish { files, answer });
        match answered.blocking_recv() {
            Ok(finished) => finished,
            Err(_) => Err(NatsError::server("finish the campaign", "it was interrupted")),
        }
    }

    /// Has the job carried out and waits for its result, without limit.
    fn done(&self, job: &Job) -> Done {
        let (answer, answered) = oneshot::channel();
        let (id, body) = (job.id(&self.package), job.body());
        self.ask(Ask::Execute { id, body, answer });
        answered.blocking_recv().unwrap_or_else(|_| Done::given_up())
    }

    /// Has a job carried out whose result is not needed again.
    fn done_once(&self, job: &Job) -> Done {
        let done = self.done(job);
        self.ask(Ask::Kept(job.id(&self.package)));
        done
    }

    fn ask(&self, ask: Ask) {
        if let Some(asks) = &self.asks {
            // If the thread has ended, no answer will come.
            let _ = asks.blocking_send(ask);
        }
    }
}

impl<E: Executor> Executor for Remote<E> {
    fn execute(&self, case: &Case) -> CaseResult {
        self.done(&Job::Case(case.clone())).result
    }

    fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
        let Done { result, course, .. } = self.done_once(&Job::WithoutFaults { seed });
        (course.unwrap_or_default(), result)
    }

    fn confirm(&self, case: &Case, property: &str) -> Result<Repeated, Outcome> {
        let job = Job::Confirm { case: case.clone(), property: property.to_owned() };
        let Done { shown, result, .. } = self.done_once(&job);
        let is_given_up = result.is_given_up();
        shown.ok_or(if is_given_up { Outcome::Aborted } else { Outcome::Error })
    }

    fn kept(&self, case: &Case) {
        self.ask(Ask::Kept(Job::Case(case.clone()).id(&self.package)));
    }

    fn takes(&self, case: &Case) -> bool {
        self.local.takes(case)
    }
}

impl<E> Drop for Remote<E> {
    fn drop(&mut self) {
        self.asks = None;
        if let Some(thread) = self.thread.take() {
            // The thread reports its own errors.
            let _ = thread.join();
        }
    }
}

struct Opening {
    server: Server,
    package: String,
    settings: RemoteSettings,
    said: Said,
    tell: Tell,
}

impl Opening {
    async fn open(self, failure: Arc<Mutex<Option<NatsError>>>) -> Result<Desk, NatsError> {
        let Self { server, package, settings, mut said, tell } = self;
        let room = Room::new(server.connect(&tell).await?);
        room.furnish().await?;
        let (what, key) = ("this campaign", format!("campaign.{}", said.campaign));
        // Waits for the lease of a coordinator that was just killed.
        let patience = LEASE + Duration::from_secs(2);
        let lease = Lease::take(&room, what, &key, &settings.holder, patience, &tell).await?;
        said.lease = lease.number;
        room.put(&package_object(&said.package), package.as_bytes()).await?;
        room.cases(&settings.place, &said.version).await?;
        Ok(Desk::new(room, said, settings.place, lease, tell, failure))
    }
}
