//! Values to frames and bytes, with counters that go on from one message to the next.

use super::{EncodeError, Layout};
use crate::protection::{Own, Sent};
use crate::transport::InParts;
use wire::can::{CanFrame, DATA_BYTES_MAX};
use wire::device::Transmit;

/// A message that is ready to be sent.
#[derive(Debug, Clone, PartialEq)]
pub enum Encoded {
    /// At once.
    Whole(Transmit),
    /// By a [`Transport`](crate::transport::Transport).
    InParts(InParts),
}

impl Encoded {
    /// What is sent at once; `None` where it goes in parts.
    pub fn whole(self) -> Option<Transmit> {
        match self {
            Self::Whole(what) => Some(what),
            Self::InParts(_) => None,
        }
    }
}

/// Encodes the messages of one sender: puts in counters and checksums, and remembers how far the counters are.
#[derive(Debug, Clone)]
pub struct Encoder {
    layout: Layout,
    /// One a message.
    sent: Vec<Sent>,
}

impl Encoder {
    /// Of somebody who has sent nothing yet.
    pub fn new(layout: Layout) -> Self {
        Self { sent: vec![Sent::default(); layout.messages().len()], layout }
    }

    /// What it encodes.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The counters begin again, as those of a device do that loses its power.
    pub fn reset(&mut self) {
        self.sent.fill(Sent::default());
    }

    /// The first bytes of what [`encode`](Self::encode) makes of it, where that is a frame without counter and checksum:
    /// [`plain_frame`](Self::plain_frame) is the frame. `None` where it is something else or an error.
    #[inline]
    pub(crate) fn first_bytes(
        &self,
        message: usize,
        values: &[f64],
    ) -> Option<[u8; DATA_BYTES_MAX]> {
        self.layout.plain_writer(message)?.first_bytes(values)
    }

    /// The frame of a message with these first bytes.
    #[inline]
    pub(crate) fn plain_frame(
        &self,
        message: usize,
        first: [u8; DATA_BYTES_MAX],
    ) -> Option<CanFrame> {
        Some(self.layout.plain_writer(message)?.frame(first))
    }

    /// The message with these values, one a signal and in its unit. Its counter and its checksum are what they have to be,
    /// and not their values: but for those that `is_own` says yes to, by their places among the signals. The counter goes
    /// on then too.
    ///
    /// # Errors
    /// As [`Layout::encode`]; the counter stays where it is.
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
