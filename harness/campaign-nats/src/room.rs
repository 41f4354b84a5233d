//! What a server holds for campaigns: two streams, a bucket of leases and an object store.

use super::connect::Link;
use super::error::NatsError;
use super::message::{CASES, FORMAT, LEASES, OBJECTS, Place, RESULTS, results_subject};
use async_nats::jetstream::consumer::{AckPolicy, PullConsumer, pull};
use async_nats::jetstream::context::{CreateStreamErrorKind, GetStreamErrorKind};
use async_nats::jetstream::kv;
use async_nats::jetstream::object_store::{self, ObjectStore};
use async_nats::jetstream::stream::{
    Config, DiscardPolicy, LastRawMessageErrorKind, RetentionPolicy, StorageType, Stream,
};
use async_nats::jetstream::{self, Context};
use std::time::Duration;
use tokio::io::AsyncReadExt as _;

/// How long a lease outlives its holder.
pub(super) const LEASE: Duration = Duration::from_secs(10);
/// Between two attempts.
pub(super) const PAUSE: Duration = Duration::from_millis(300);
/// How long a case belongs to a worker that says nothing: it is another's then.
pub(super) const ACK_WAIT: Duration = Duration::from_secs(5);
/// How often a worker says that it is still at it.
pub(super) const STILL_AT_IT: Duration = Duration::from_millis(1_500);
/// How long a result belongs to a coordinator that has not kept it.
const RESULT_WAIT: Duration = Duration::from_secs(5);
/// How long an answer of the server may take.
const ANSWER: Duration = Duration::from_secs(3);
/// How long a name of a message is remembered, so that nothing is on a stream twice. Assumption: whoever sends again
/// after a server was away does so within it.
const REMEMBERED: Duration = Duration::from_secs(3_600);
/// How long what nobody fetches is kept. Assumption: a campaign that nobody resumes for so long is forgotten.
const KEPT: Duration = Duration::from_secs(7 * 24 * 3_600);
/// Packages and failing cases are kept for so long.
const OBJECTS_KEPT: Duration = Duration::from_secs(90 * 24 * 3_600);
/// The most bytes that a package has.
const PACKAGE_BYTES_MAX: usize = 16 << 20;
/// Cases or results that are handed out and not acknowledged, at most.
const OPEN_MAX: i64 = 100_000;

/// The server's room for campaigns.
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

    /// Makes what is not there yet.
    ///
    /// # Errors
    ///
    /// When it is there and of another version, or the server keeps no streams.
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
        // What `create_key_value` asks for is refused by servers before 2.10.
        self.stream(Config {
            subjects: vec![format!("$KV.{LEASES}.>")],
            max_messages_per_subject: 1,
            max_age: LEASE,
            // The server wants no more than the age.
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
                    Err(error) => return Err(NatsError::server(what(), error)),
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
        // Without JetStream nobody answers on its subjects.
        let says = text.contains("not enabled")
            || text.contains("unavailable")
            || text.contains("no responders");
        says.then(|| self.no_jetstream(error))
    }

    fn no_jetstream(&self, cause: &dyn std::fmt::Display) -> NatsError {
        NatsError::NoJetStream { server: self.link.server.clone(), cause: cause.to_string() }
    }

    /// From which all workers of a version at a place take cases.
    pub(super) async fn cases(
        &self,
        place: &Place,
        version: &str,
    ) -> Result<PullConsumer, NatsError> {
        self.consumer(CASES, place.consumer(version), place.cases(version), ACK_WAIT).await
    }

    /// Is there a message under this subject? Asked until the server says so.
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

    /// From which the coordinator of a campaign takes results.
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
            // Builds come and go; what waits for one is kept no longer either.
            inactive_threshold: KEPT,
            ..pull::Config::default()
        };
        let made = self.context.create_consumer_on_stream(config, stream).await;
        made.map_err(|error| NatsError::server(format!("make the consumer {name}"), error))
    }

    /// Where leases are.
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

    /// Puts an object there, unless it is there as it is.
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

    /// An object.
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

    /// No case of a campaign waits any longer; those that somebody has are carried out.
    pub(super) async fn withdraw(&self, place: &Place, campaign: &str) -> Result<(), NatsError> {
        self.purge(CASES, place.campaign(campaign)).await
    }

    /// Nothing of a campaign is left on the streams.
    pub(super) async fn clear(&self, place: &Place, campaign: &str) -> Result<(), NatsError> {
        self.withdraw(place, campaign).await?;
        self.purge(RESULTS, results_subject(campaign)).await?;
        let name = results_consumer(campaign);
        // One that is not there needs no removal.
        let _ = self.context.delete_consumer_from_stream(name, RESULTS).await;
        Ok(())
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
