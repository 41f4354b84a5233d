//! The coordinator's thread: hands out cases, takes the results, and waits for an unreachable server.

use super::connect::{News, Tell};
use super::error::NatsError;
use super::job::Done;
use super::lease::Lease;
use super::message::{CASES, Place, RESULTS, Said, id_of, result_subject};
use super::room::{Letter, PAUSE, Room};
use super::tray::{Read, Tray};
use super::worker::LISTEN;
use async_nats::jetstream::Message;
use campaign::WINDOW;
use futures_util::StreamExt as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::select;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::{interval, sleep, timeout};

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    pub name: String,
    pub text: String,
}

/// After this time without a result, a notice tells what the campaign waits for.
const SILENCE: Duration = Duration::from_secs(10);
/// Time limit for withdrawing cases that a bench has not begun.
const WITHDRAW: Duration = Duration::from_secs(1);
/// The most attempts to store files on a reachable server.
const FINISHES_MAX: usize = 5;

/// After twice this time without a message the server is asked again.
const HEARTBEAT: Duration = Duration::from_secs(2);
/// How long one request for results stays open at the server.
const REQUEST: Duration = Duration::from_secs(10);
/// Number of results per request.
const BATCH: usize = 64;

#[derive(Debug)]
pub(super) enum Ask {
    Execute {
        id: String,
        body: Vec<u8>,
        answer: oneshot::Sender<Done>,
    },
    /// The result of the job with this name has been stored.
    Kept(String),
    Finish {
        files: Vec<StoredFile>,
        answer: oneshot::Sender<Result<(), NatsError>>,
    },
}

/// Hands out cases and receives results.
pub(super) struct Desk {
    room: Room,
    said: Said,
    place: Place,
    lease: Lease,
    tell: Tell,
    tray: Tray,
    /// Number of cases that were sent again under another name.
    again: Arc<AtomicU64>,
    failure: Arc<Mutex<Option<NatsError>>>,
    /// Whether no more cases are carried out.
    is_over: bool,
}

impl Desk {
    pub(super) fn new(
        room: Room,
        said: Said,
        place: Place,
        lease: Lease,
        tell: Tell,
        failure: Arc<Mutex<Option<NatsError>>>,
    ) -> Self {
        let (tray, again) = (Tray::default(), Arc::default());
        Self { room, said, place, lease, tell, tray, again, failure, is_over: false }
    }

    /// Runs until the campaign drops its end of the channel.
    pub(super) async fn serve(mut self, mut asked: mpsc::Receiver<Ask>, stop: impl Fn() -> bool) {
        let (send, mut arrived) = mpsc::channel(WINDOW as usize);
        let campaign = self.said.campaign.clone();
        let receiving = tokio::spawn(receive(self.room.clone(), campaign, send));
        let (trouble, mut troubles) = mpsc::channel(1);
        let mut listen = interval(LISTEN);
        let mut connected = self.room.link.up.borrow().times;
        let mut silent = Duration::ZERO;
        loop {
            select! {
                ask = asked.recv() => match ask {
                    Some(Ask::Execute { id, body, answer }) => self.execute(id, body, answer, &trouble),
                    Some(Ask::Kept(id)) => {
                        for message in self.tray.kept(&id) {
                            // If the acknowledgement is lost, the message comes again and is ignored.
                            let _ = message.ack().await;
                        }
                    }
                    Some(Ask::Finish { files, answer }) => {
                        let finished = self.finish(&files, &stop).await;
                        let _ = answer.send(finished);
                    }
                    None => break,
                },
                Some(message) = arrived.recv() => {
                    silent = Duration::ZERO;
                    self.arrived(message, &trouble).await;
                }
                Some(error) = troubles.recv() => self.fail(error),
                error = self.lease.lost(), if !self.is_over => self.fail(error),
                times = self.room.link.connected_since(connected) => {
                    connected = times;
                    self.hand_out_again(&trouble);
                }
                _ = listen.tick() => {
                    if !self.is_over && stop() {
                        self.give_up();
                        self.withdraw().await;
                    }
                    silent = if self.tray.asked.is_empty() { Duration::ZERO } else { silent + LISTEN };
                    if silent >= SILENCE {
                        silent = Duration::ZERO;
                        self.tell_who_is_waited_for();
                    }
                }
            }
        }
        receiving.abort();
        let Self { lease, room, .. } = self;
        lease.release().await;
        let _ = timeout(LISTEN, room.link.client.flush()).await;
    }

    fn execute(
        &mut self,
        id: String,
        body: Vec<u8>,
        answer: oneshot::Sender<Done>,
        trouble: &mpsc::Sender<NatsError>,
    ) {
        if self.is_over {
            let _ = answer.send(Done::given_up());
            return;
        }
        if let Some(answer) = self.tray.ask(&id, answer) {
            let handing_out = reported(trouble, self.handing_out(&id, &body).go());
            self.tray.out(id, body, handing_out, answer);
        }
    }

    async fn arrived(&mut self, message: Message, trouble: &mpsc::Sender<NatsError>) {
        let (message, error) = match self.tray.arrived(message) {
            Read::Taken => return,
            Read::Refused { message, worker, cause } => {
                (message, NatsError::Refused { worker, cause })
            }
            Read::Unreadable { message, cause } => {
                let case = id_of(&message.subject).to_owned();
                (message, NatsError::Unreadable { case, cause })
            }
        };
        // The message is not needed again.
        let _ = message.ack().await;
        let said = Said::of(message.headers.as_ref(), &self.said.version);
        if said.as_ref() == Ok(&self.said) {
            return self.fail(error);
        }
        // The message is from an earlier attempt; since then the worker may have been repaired or have ended.
        tracing::debug!("of an earlier attempt: {error}");
        let id = id_of(&message.subject);
        if let Some(body) = self.tray.asked.get(id).map(|asked| asked.body.clone()) {
            let handing_out = reported(trouble, self.handing_out(id, &body).go());
            if let Some(asked) = self.tray.asked.get_mut(id) {
                std::mem::replace(&mut asked.handing_out, handing_out).abort();
            }
        }
    }

    /// Hands out all cases again after a reconnection, because the server may have lost them.
    fn hand_out_again(&mut self, trouble: &mpsc::Sender<NatsError>) {
        let mut asked = std::mem::take(&mut self.tray.asked);
        for (id, asked) in &mut asked {
            asked.handing_out.abort();
            let handing_out = self.handing_out(id, &asked.body);
            asked.handing_out = reported(trouble, async move {
                if handing_out.is_on_its_way().await { Ok(()) } else { handing_out.go().await }
            });
        }
        self.tray.asked = asked;
    }

    fn handing_out(&self, id: &str, body: &[u8]) -> HandingOut {
        HandingOut {
            room: self.room.clone(),
            letter: Letter {
                subject: self.place.case(&self.said.version, &self.said.campaign, id),
                name: format!("{}.{id}", self.said.campaign),
                headers: self.said.headers(),
                body: body.to_vec(),
            },
            result: result_subject(&self.said.campaign, id),
            lease: self.said.lease,
            again: Arc::clone(&self.again),
        }
    }

    fn tell_who_is_waited_for(&self) {
        if !self.room.link.up.borrow().now {
            return (self.tell)(&News::Away);
        }
        let (room, place, tell) = (self.room.clone(), self.place.clone(), Arc::clone(&self.tell));
        let version = self.said.version.clone();
        tokio::spawn(async move {
            if let Ok(consumer) = room.cases(&place, &version).await {
                let info = consumer.cached_info();
                let (queued, taken) = (info.num_pending, info.num_ack_pending as u64);
                // A run in real time takes long, and a worker is busy with it.
                if taken > 0 && matches!(place, Place::Bench(_)) {
                    return;
                }
                tell(&News::Waiting { place, queued, taken, idle: info.num_waiting as u64 });
            }
        });
    }

    async fn finish(
        &self,
        files: &[StoredFile],
        stop: &impl Fn() -> bool,
    ) -> Result<(), NatsError> {
        let stopped = async {
            while !stop() {
                sleep(LISTEN).await;
            }
        };
        select! {
            finished = self.leave(files) => finished,
            () = stopped => Err(NatsError::server("finish the campaign", "it was interrupted")),
        }
    }

    async fn leave(&self, files: &[StoredFile]) -> Result<(), NatsError> {
        let campaign = &self.said.campaign;
        let mut tries = 0;
        loop {
            self.room.link.there().await;
            tries += 1;
            let left = async {
                for file in files {
                    let name = format!("campaigns/{campaign}/{}", file.name);
                    self.room.put(&name, file.text.as_bytes()).await?;
                }
                self.room.clear(&self.place, campaign).await
            };
            match left.await {
                Err(error) if tries == FINISHES_MAX => return Err(error),
                Err(error) => tracing::debug!("{error}"),
                Ok(()) => return Ok(()),
            }
            sleep(PAUSE).await;
        }
    }

    fn fail(&mut self, error: NatsError) {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        self.give_up();
    }

    /// A bench must not work for a stopped campaign. In virtual time waiting cases are useful when the campaign
    /// resumes.
    async fn withdraw(&self) {
        if matches!(self.place, Place::Bench(_)) {
            // If the server is unreachable, at most one case remains.
            let withdrawn = self.room.withdraw(&self.place, &self.said.campaign);
            let _ = timeout(WITHDRAW, withdrawn).await;
        }
    }

    fn give_up(&mut self) {
        self.is_over = true;
        self.tray.give_up();
    }
}

/// Runs `work` in the background and reports its error.
fn reported(
    trouble: &mpsc::Sender<NatsError>,
    work: impl Future<Output = Result<(), NatsError>> + Send + 'static,
) -> JoinHandle<()> {
    let trouble = trouble.clone();
    tokio::spawn(async move {
        if let Err(error) = work.await {
            // One error is enough.
            let _ = trouble.try_send(error);
        }
    })
}

/// A case being sent to the stream.
struct HandingOut {
    room: Room,
    letter: Letter,
    result: String,
    lease: u64,
    again: Arc<AtomicU64>,
}

impl HandingOut {
    /// Sends it to the stream. If it was there before, it is sent again only if neither the case nor its result is
    /// left.
    async fn go(mut self) -> Result<(), NatsError> {
        let name = self.letter.name.clone();
        while self.room.send(&self.letter).await?.is_none() && !self.is_on_its_way().await {
            let count = self.again.fetch_add(1, Ordering::Relaxed);
            // No other case sent again has this name: the lease and the count are its own.
            self.letter.name = format!("{name}.{}-{count}", self.lease);
        }
        Ok(())
    }

    /// A worker reports before it acknowledges, so with this order of queries one of the two is found.
    async fn is_on_its_way(&self) -> bool {
        let Self { room, letter, result, .. } = self;
        room.holds(CASES, &letter.subject).await || room.holds(RESULTS, result).await
    }
}

/// Passes on the results of a campaign until the receiver is closed; waits for an unreachable server.
async fn receive(room: Room, campaign: String, arrived: mpsc::Sender<Message>) {
    while !arrived.is_closed() {
        room.link.there().await;
        let times = room.link.up.borrow().times;
        select! {
            () = stream(&room, &campaign, &arrived) => {}
            // Requests made over a lost connection are not answered.
            _ = room.link.connected_since(times) => {}
            () = arrived.closed() => return,
        }
        sleep(PAUSE).await;
    }
}

async fn stream(room: &Room, campaign: &str, arrived: &mpsc::Sender<Message>) {
    let consumer = match room.results(campaign).await {
        Ok(consumer) => consumer,
        Err(error) => return tracing::debug!("{error}"),
    };
    let messages = consumer.stream().max_messages_per_batch(BATCH).expires(REQUEST);
    let mut messages = match messages.heartbeat(HEARTBEAT).messages().await {
        Ok(messages) => messages,
        Err(error) => return tracing::debug!("no results: {error}"),
    };
    while let Some(next) = messages.next().await {
        match next {
            Ok(message) => {
                if arrived.send(message).await.is_err() {
                    return;
                }
            }
            Err(error) => return tracing::debug!("results end: {error}"),
        }
    }
}
