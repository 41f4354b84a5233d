//! Results as they arrive at the coordinator.

use super::room::{PAUSE, Room};
use async_nats::jetstream::Message;
use futures_util::StreamExt as _;
use std::time::Duration;
use tokio::select;
use tokio::sync::mpsc::Sender;
use tokio::time::sleep;

/// A server that says nothing for twice as long is asked again.
const HEARTBEAT: Duration = Duration::from_secs(2);
/// How long one request for results waits at the server.
const REQUEST: Duration = Duration::from_secs(10);
/// Results that are sent at a time.
const BATCH: usize = 64;

/// Hands on the results of a campaign until nobody wants them; a server that is away is waited for.
pub(super) async fn receive(room: Room, campaign: String, arrived: Sender<Message>) {
    while !arrived.is_closed() {
        room.link.there().await;
        let times = room.link.up.borrow().times;
        select! {
            () = stream(&room, &campaign, &arrived) => {}
            // What was asked for over a connection that is gone does not come.
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
