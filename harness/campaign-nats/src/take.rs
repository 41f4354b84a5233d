//! Takes cases from the queue of a worker's place, as many as it has slots for.

use super::error::NatsError;
use super::message::Place;
use super::room::{PAUSE, Room};
use async_nats::jetstream::Message;
use async_nats::jetstream::consumer::PullConsumer;
use async_nats::jetstream::consumer::pull::Batch;
use futures_util::StreamExt as _;
use std::sync::Arc;
use std::time::Duration;
use tokio::select;
use tokio::sync::mpsc::Sender;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::sleep;

/// How long one request for cases stays open at the server.
const REQUEST: Duration = Duration::from_secs(5);

/// A case, and the slot that it occupies until it is reported.
pub(super) type Taken = (Message, OwnedSemaphorePermit);

/// Place and version of the cases to take.
pub(super) type Queue = (Place, String);

enum Ended {
    /// Ended normally; there may be more cases.
    Served,
    /// The connection or the consumer is gone.
    Broken,
    /// The worker takes no more cases.
    Unwanted,
}

/// Takes cases as long as the worker accepts them.
pub(super) async fn take(room: Room, queue: Queue, slots: Arc<Semaphore>, taken: Sender<Taken>) {
    let mut known: Option<PullConsumer> = None;
    loop {
        room.link.there().await;
        let Ok(first) = Arc::clone(&slots).acquire_owned().await else { return };
        let mut permits = vec![first];
        while let Ok(more) = Arc::clone(&slots).try_acquire_owned() {
            permits.push(more);
        }
        let times = room.link.up.borrow().times;
        let ended = match request(&room, &queue, &mut known, permits.len()).await {
            Ok(batch) => receive(&room, batch, permits, times, &taken).await,
            Err(error) => {
                tracing::debug!("{error}");
                drop(permits);
                Ended::Broken
            }
        };
        match ended {
            Ended::Served => {}
            Ended::Unwanted => return,
            Ended::Broken => {
                known = None;
                sleep(PAUSE).await;
            }
        }
    }
}

async fn request(
    room: &Room,
    (place, version): &Queue,
    known: &mut Option<PullConsumer>,
    count: usize,
) -> Result<Batch, NatsError> {
    if known.is_none() {
        // The server may have lost its data, or be a different one.
        room.furnish().await?;
        *known = Some(room.cases(place, version).await?);
    }
    let Some(consumer) = known else { return Err(NatsError::server("ask for cases", "no queue")) };
    let batch = consumer.batch().max_messages(count).expires(REQUEST).messages().await;
    batch.map_err(|error| NatsError::server("ask for cases", error))
}

/// Passes on arriving cases. A request over a lost connection is lost too.
async fn receive(
    room: &Room,
    mut batch: Batch,
    mut permits: Vec<OwnedSemaphorePermit>,
    times: u64,
    taken: &Sender<Taken>,
) -> Ended {
    loop {
        let next = select! {
            next = batch.next() => next,
            _ = room.link.connected_since(times) => return Ended::Broken,
            () = taken.closed() => return Ended::Unwanted,
        };
        match (next, permits.pop()) {
            (Some(Ok(message)), Some(permit)) => {
                if taken.send((message, permit)).await.is_err() {
                    return Ended::Unwanted;
                }
            }
            (Some(Err(error)), _) => {
                tracing::debug!("a request for cases ended: {error}");
                return Ended::Broken;
            }
            _ => return Ended::Served,
        }
    }
}
