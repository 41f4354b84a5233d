//! Receives results in the coordinator.

use super::room::{PAUSE, Room};
use async_nats::jetstream::Message;
use futures_util::StreamExt as _;
use std::time::Duration;
use tokio::select;
use tokio::sync::mpsc::Sender;
use tokio::time::sleep;

/// After twice this time without a message the server is asked again.
const HEARTBEAT: Duration = Duration::from_secs(2);
/// How long one request for results stays open at the server.
const REQUEST: Duration = Duration::from_secs(10);
/// Number of results per request.
const BATCH: usize = 64;

/// Passes on the results of a campaign until the receiver is closed; waits for an unreachable server.
pub(super) async fn receive(room: Room, campaign: String, arrived: Sender<Message>) {
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

async fn stream(room: &Room, campaign: &str, arrived: &Sender<Message>) {
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
