//! Sends messages until the server has them; waits for an unreachable server.

use super::error::NatsError;
use super::room::{PAUSE, Room};
use async_nats::HeaderMap;
use async_nats::jetstream::context::{PublishError, PublishErrorKind};
use async_nats::jetstream::message::PublishMessage;
use async_nats::jetstream::publish::PublishAck;

#[derive(Debug, Clone)]
pub(super) struct Letter {
    pub(super) subject: String,
    /// A message sent again under the same name is on the stream only once.
    pub(super) name: String,
    pub(super) headers: HeaderMap,
    pub(super) body: Vec<u8>,
}

impl Room {
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
}
