//! Encodes values as frames and bytes, with counters that advance from message to message.

use super::message::Encoded;
use super::{EncodeError, Layout};
use crate::protection::{Own, Sent};
use wire::can::CanFrame;

/// Encodes the messages of one sender: fills in counters and checksums, and keeps the counters.
#[derive(Debug, Clone)]
pub struct Encoder {
    layout: Layout,
    /// One per message.
    sent: Vec<Sent>,
}

impl Encoder {
    /// An encoder that has sent nothing yet.
    pub fn new(layout: Layout) -> Self {
        Self { sent: vec![Sent::default(); layout.messages().len()], layout }
    }

    /// The layout that it encodes.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Resets the counters, like a device that loses power.
    pub fn reset(&mut self) {
        self.sent.fill(Sent::default());
    }

    /// The first eight bytes of the result of [`encode`](Self::encode), the first lowest, if that is a frame without
    /// counter and checksum: [`plain_frame`](Self::plain_frame) makes the frame. `None` for other results and errors.
    #[inline]
    pub(crate) fn plain_word(&self, message: usize, values: &[f64]) -> Option<u64> {
        self.layout.plain_writer(message)?.word(values)
    }

    /// The frame of a message with these first bytes.
    #[inline]
    pub(crate) fn plain_frame(&self, message: usize, word: u64) -> Option<CanFrame> {
        Some(self.layout.plain_writer(message)?.frame(word))
    }

    /// The message with these values, one per signal and in its unit. Counter and checksum are computed instead of
    /// using their values, except for signals that `is_own` accepts by position. The counter advances in that case
    /// too.
    ///
    /// # Errors
    /// As [`Layout::encode`]; the counter then stays unchanged.
    pub fn encode(
        &mut self,
        message: usize,
        values: &[f64],
        is_own: impl Fn(usize) -> bool,
    ) -> Result<Encoded, EncodeError> {
        let found = self.layout.messages().get(message);
        let found = found.ok_or(EncodeError::NoMessage(message))?;
        let Some(protected) = &found.protected else { return self.layout.encoded(message, values) };
        let own = Own {
            counter: protected.counter.is_some_and(&is_own),
            checksum: protected.checksum.is_some_and(&is_own),
        };
        found.encode(values, Some((&mut self.sent[message], own)))
    }
}
