//! The storage of campaigns on a server: two streams, a bucket of leases and an object store. Messages are sent until the
//! server has them; an unreachable one is waited for.

use super::connect::Link;
use super::error::NatsError;
use super::message::{CASES, FORMAT, LEASES, OBJECTS, Place, RESULTS, results_subject};
use async_nats::HeaderMap;
use async_nats::jetstream::consumer::{AckPolicy, PullConsumer, pull};
use async_nats::jetstream::context::{
    CreateStreamErrorKind, GetStreamErrorKind, PublishError, PublishErrorKind,
};
use async_nats::jetstream::kv;
use async_nats::jetstream::message::PublishMessage;
use async_nats::jetstream::object_store::{self, ObjectStore};
use async_nats::jetstream::publish::PublishAck;
use async_nats::jetstream::stream::{
    Config, DiscardPolicy, LastRawMessageErrorKind, RetentionPolicy, StorageType, Stream,
};
use async_nats::jetstream::{self, Context};
use std::time::Duration;
use tokio::io::AsyncReadExt as _;

/// How long a lease outlives its holder.
pub(super) const LEASE: Duration = Duration::from_secs(10);
/// Pause between two attempts.
pub(super) const PAUSE: Duration = Duration::from_millis(300);
/// Time after which the case of a silent worker goes to another worker.
pub(super) const ACK_WAIT: Duration = Duration::from_secs(5);
/// Interval at which a worker extends its lease on a case.
pub(super) const STILL_AT_IT: Duration = Duration::from_millis(1_500);
/// Time after which a result that the coordinator has not stored is delivered again.
const RESULT_WAIT: Duration = Duration::from_secs(5);
const ANSWER: Duration = Duration::from_secs(3);
/// How long message names are remembered, so that no message is on a stream twice. Assumption: messages are sent again
/// within this time after the server was unreachable.
const REMEMBERED: Duration = Duration::from_secs(3_600);
/// How long unfetched messages are kept. Assumption: a campaign that is not resumed for this long is abandoned.
const KEPT: Duration = Duration::from_secs(7 * 24 * 3_600);
/// How long packages and failing cases are kept.
const OBJECTS_KEPT: Duration = Duration::from_secs(90 * 24 * 3_600);
const PACKAGE_BYTES_MAX: usize = 16 << 20;
/// The most cases or results that are delivered and not acknowledged.
const OPEN_MAX: i64 = 100_000;

#[derive(Debug, Clone)]
pub(super) struct Letter {
    pub(super) subject: String,
    /// A message sent again under the same name is on the stream only once.
    pub(super) name: String,
    pub(super) headers: HeaderMap,
    pub(super) body: Vec<u8>,
}

/// The storage of campaigns on a server.
#[derive(Clone)]
pub(super) struct Room {
    pub(super) link: Link,
    pub(super) context: Context,
}

impl Room {
    pub(super) fn new(link: Link) -> Self {
        let mut context = jetstream::new(link.client.clone());
        context.set_timeout(ANSWER);
        Self { link, context }
    }

    /// Creates what does not exist yet.
    ///
    /// # Errors
    ///
    /// When something exists in another version, or the server has no streams.
    pub(super) async fn furnish(&self) -> Result<(), NatsError> {
        for (name, subjects) in [(CASES, "hil.cases.>"), (RESULTS, "hil.results.>")] {
            self.stream(Config {
                subjects: vec![subjects.to_owned()],
                retention: RetentionPolicy::WorkQueue,
                duplicate_window: REMEMBERED,
                max_age: KEPT,
                ..ours(name)
            })
            .await?;
        }
        // Servers before 2.10 reject the configuration of `create_key_value`.
        self.stream(Config {
            subjects: vec![format!("$KV.{LEASES}.>")],
            max_messages_per_subject: 1,
            max_age: LEASE,
            // The server accepts at most the maximum age.
            duplicate_window: LEASE,
            discard: DiscardPolicy::New,
            allow_rollup: true,
            deny_delete: true,
            ..ours(&format!("KV_{LEASES}"))
        })
        .await?;
        self.objects().await.map(|_| ())
    }

    async fn stream(&self, wanted: Config) -> Result<Stream, NatsError> {
        let name = wanted.name.clone();
        let what = || format!("make the stream {name}");
        let found = match self.context.get_stream(&name).await {
            Ok(found) => found,
            Err(error) if is_missing(error.kind()) => {
                match self.context.create_stream(&wanted).await {
                    Ok(made) => made,
                    Err(error) if error.kind() == CreateStreamErrorKind::JetStreamUnavailable => {
                        return Err(self.no_jetstream(&error));
                    }
                    // A worker and a campaign that start together both make it; the server refuses the later one.
                    Err(error) => match self.context.get_stream(&name).await {
                        Ok(found) => found,
                        Err(_) => return Err(NatsError::server(what(), error)),
                    },
                }
            }
            Err(error) => {
                return Err(self
                    .unavailable(&error)
                    .unwrap_or_else(|| NatsError::server(what(), error)));
            }
        };
        let description = found.cached_info().config.description.clone().unwrap_or_default();
        if Some(&description) == wanted.description.as_ref() {
            return Ok(found);
        }
        Err(NatsError::OtherFormat { stream: name, found: description })
    }

    fn unavailable(
        &self,
        error: &async_nats::jetstream::context::GetStreamError,
    ) -> Option<NatsError> {
        let text = error.to_string();
        // Without JetStream its subjects have no responders.
        let says = text.contains("not enabled")
            || text.contains("unavailable")
            || text.contains("no responders");
        says.then(|| self.no_jetstream(error))
    }

    fn no_jetstream(&self, cause: &dyn std::fmt::Display) -> NatsError {
        NatsError::NoJetStream { server: self.link.server.clone(), cause: cause.to_string() }
    }

    /// Sends a message until it is on the stream. Returns its number there, or `None` if it was there before.
    ///
    /// # Errors
    ///
    /// When the server will never accept it.
    pub(super) async fn send(&self, letter: &Letter) -> Result<Option<u64>, NatsError> {
        loop {
            self.link.there().await;
            match self.send_once(letter).await {
                Ok(ack) => return Ok((!ack.duplicate).then_some(ack.sequence)),
                Err(error) if error.kind() == PublishErrorKind::MaxPayloadExceeded => {
                    return Err(NatsError::server(format!("send {}", letter.subject), error));
                }
                // The server lost its data and gets it again.
                Err(error) if error.kind() == PublishErrorKind::StreamNotFound => {
                    match self.furnish().await {
                        Err(error @ NatsError::OtherFormat { .. }) => return Err(error),
                        furnished => tracing::debug!("{error}: furnished again: {furnished:?}"),
                    }
                }
                Err(error) => tracing::debug!("{} is sent again: {error}", letter.subject),
            }
            tokio::time::sleep(PAUSE).await;
        }
    }

    async fn send_once(&self, letter: &Letter) -> Result<PublishAck, PublishError> {
        let message = PublishMessage::build()
            .headers(letter.headers.clone())
            .message_id(&letter.name)
            .payload(letter.body.clone().into());
        self.context.send_publish(letter.subject.clone(), message).await?.await
    }

    /// The consumer from which all workers of a version at a place take cases.
    pub(super) async fn cases(
        &self,
        place: &Place,
        version: &str,
    ) -> Result<PullConsumer, NatsError> {
        self.consumer(CASES, place.consumer(version), place.cases(version), ACK_WAIT).await
    }

    /// Whether there is a message under this subject. Repeats the query until the server answers.
    pub(super) async fn holds(&self, stream: &str, subject: &str) -> bool {
        loop {
            self.link.there().await;
            if let Ok(stream) = self.context.get_stream_no_info(stream).await {
                match stream.get_last_raw_message_by_subject(subject).await {
                    Ok(_) => return true,
                    Err(error) if error.kind() == LastRawMessageErrorKind::NoMessageFound => {
                        return false;
                    }
                    Err(error) => tracing::debug!("{subject}: {error}"),
                }
            }
            tokio::time::sleep(PAUSE).await;
        }
    }

    /// The consumer from which the coordinator of a campaign takes results.
    pub(super) async fn results(&self, campaign: &str) -> Result<PullConsumer, NatsError> {
        let name = results_consumer(campaign);
        self.consumer(RESULTS, name, results_subject(campaign), RESULT_WAIT).await
    }

    async fn consumer(
        &self,
        stream: &str,
        name: String,
        subject: String,
        ack_wait: Duration,
    ) -> Result<PullConsumer, NatsError> {
        let config = pull::Config {
            durable_name: Some(name.clone()),
            ack_policy: AckPolicy::Explicit,
            ack_wait,
            max_ack_pending: OPEN_MAX,
            filter_subject: subject,
            // Consumers of old builds are removed after the same time as their messages.
            inactive_threshold: KEPT,
            ..pull::Config::default()
        };
        let made = self.context.create_consumer_on_stream(config, stream).await;
        made.map_err(|error| NatsError::server(format!("make the consumer {name}"), error))
    }

    pub(super) async fn leases(&self) -> Result<kv::Store, NatsError> {
        let bucket = self.context.get_key_value(LEASES).await;
        bucket.map_err(|error| NatsError::server("open the bucket of leases", error))
    }

    async fn objects(&self) -> Result<ObjectStore, NatsError> {
        if let Ok(store) = self.context.get_object_store(OBJECTS).await {
            return Ok(store);
        }
        let config = object_store::Config {
            bucket: OBJECTS.to_owned(),
            max_age: OBJECTS_KEPT,
            storage: StorageType::File,
            num_replicas: 1,
            ..object_store::Config::default()
        };
        let made = self.context.create_object_store(config).await;
        made.map_err(|error| NatsError::server("make the object store", error))
    }

    /// Stores an object, unless the same content is stored already.
    pub(super) async fn put(&self, name: &str, bytes: &[u8]) -> Result<(), NatsError> {
        let store = self.objects().await?;
        if let Ok(found) = self.get(name).await
            && found == bytes
        {
            return Ok(());
        }
        let put = store.put(name, &mut &bytes[..]).await;
        put.map(|_| ()).map_err(|error| NatsError::server(format!("store {name}"), error))
    }

    pub(super) async fn get(&self, name: &str) -> Result<Vec<u8>, NatsError> {
        let failed =
            |cause: &dyn std::fmt::Display| NatsError::server(format!("fetch {name}"), cause);
        let store = self.objects().await?;
        let object = store.get(name).await.map_err(|error| failed(&error))?;
        if object.info().size > PACKAGE_BYTES_MAX {
            return Err(failed(&format!("it has more than {PACKAGE_BYTES_MAX} bytes")));
        }
        let mut bytes = Vec::new();
        let mut object = object.take(PACKAGE_BYTES_MAX as u64);
        object.read_to_end(&mut bytes).await.map_err(|error| failed(&error))?;
        Ok(bytes)
    }

    /// Removes the waiting cases of a campaign; those that workers have taken are still carried out.
    pub(super) async fn withdraw(&self, place: &Place, campaign: &str) -> Result<(), NatsError> {
        self.purge(CASES, place.campaign(campaign)).await
    }

    /// Removes everything of a campaign from the streams.
    pub(super) async fn clear(&self, place: &Place, campaign: &str) -> Result<(), NatsError> {
        self.withdraw(place, campaign).await?;
        self.purge(RESULTS, results_subject(campaign)).await?;
        let name = results_consumer(campaign);
        // It may not exist.
        let _ = self.context.delete_consumer_from_stream(name, RESULTS).await;
        Ok(())
    }

    /// Removes a result that nobody waits for. One that stays goes with its age.
    pub(super) async fn take_back(&self, sequence: u64) {
        if let Ok(results) = self.context.get_stream_no_info(RESULTS).await {
            // The end of the campaign may have removed it.
            let _ = results.delete_message(sequence).await;
        }
    }

    async fn purge(&self, stream: &str, subject: String) -> Result<(), NatsError> {
        let failed = |error: &dyn std::fmt::Display| NatsError::server("clear the streams", error);
        let stream = self.context.get_stream_no_info(stream).await.map_err(|e| failed(&e))?;
        stream.purge().filter(subject).await.map_err(|error| failed(&error))?;
        Ok(())
    }
}

fn results_consumer(campaign: &str) -> String {
    format!("campaign-{campaign}")
}

fn ours(name: &str) -> Config {
    Config {
        name: name.to_owned(),
        description: Some(format!("hil, message format {FORMAT}")),
        storage: StorageType::File,
        num_replicas: 1,
        ..Config::default()
    }
}

fn is_missing(kind: GetStreamErrorKind) -> bool {
    matches!(kind, GetStreamErrorKind::JetStream(error)
        if error.error_code() == async_nats::jetstream::ErrorCode::STREAM_NOT_FOUND)
}
