//! A message being received in several frames.

use super::{BYTES_MAX, Channel, FLOW_CONTROL, OVERFLOW, Received};
use wire::time::Timestamp;

#[derive(Debug, Clone)]
pub(super) struct Coming {
    data: Vec<u8>,
    length: usize,
    /// Sequence number of the next frame.
    number: u8,
    /// Frames until the next flow control; 0 if none follows.
    in_block: u8,
    /// Time of the next flow control, and of giving up.
    pub(super) answer_at: Timestamp,
    pub(super) due: Timestamp,
}

impl Channel {
    /// Takes a first frame: the announced length and the first bytes.
    pub(super) fn begin_coming(
        &mut self,
        now: Timestamp,
        length: usize,
        data: &[u8],
    ) -> Option<Received> {
        // A length of zero announces one of 32 bits.
        if length == 0 || length > BYTES_MAX {
            self.push(self.id(), &[FLOW_CONTROL << 4 | OVERFLOW, 0, 0]);
            self.fail("the announced message is too long");
            return None;
        }
        // What would fit into a single frame is ignored (9.6.3.2). In one of at most eight bytes, that has room for one more.
        let single = if data.len() < 8 { data.len() + 1 } else { data.len() };
        if length <= single {
            return None;
        }
        let mut whole = Vec::with_capacity(length);
        whole.extend_from_slice(data);
        self.coming = Some(Coming {
            data: whole,
            length,
            number: 1,
            in_block: self.settings.block_size,
            answer_at: now + self.slowness.flow_control,
            due: Timestamp::MAX,
        });
        self.wake(now);
        None
    }

    pub(super) fn consecutive(
        &mut self,
        now: Timestamp,
        number: u8,
        data: &[u8],
    ) -> Option<Received> {
        let coming = self.coming.as_mut()?;
        if number != coming.number {
            self.end_coming("a consecutive frame out of sequence");
            return None;
        }
        let left = coming.length - coming.data.len();
        coming.data.extend_from_slice(&data[..left.min(data.len())]);
        coming.number = (number + 1) & 0xF;
        if coming.data.len() == coming.length {
            let data = std::mem::take(&mut coming.data);
            self.coming = None;
            return Some(Received { data, functional: false });
        }
        coming.due = now + self.settings.n_cr;
        if coming.in_block > 0 {
            coming.in_block -= 1;
            if coming.in_block == 0 {
                coming.in_block = self.settings.block_size;
                coming.answer_at = now + self.slowness.flow_control;
                coming.due = Timestamp::MAX;
                self.wake(now);
            }
        }
        None
    }

    /// Another message takes the place of the one in progress (9.8.3): its sender may have begun again.
    pub(super) fn begin_anew(&mut self) {
        self.failures += u64::from(self.coming.take().is_some());
    }

    pub(super) fn end_coming(&mut self, why: &'static str) {
        if self.coming.take().is_some() {
            self.fail(why);
        }
    }
}
