//! Counters and checksums in messages, as in vehicles: the sender fills them in, the receiver checks them.
//!
//! This module does not know signals: a counter and a checksum are bits of a message.

mod catalogue;
mod counter;
mod e2e;
mod sum;
#[cfg(test)]
mod tests;

pub(crate) use catalogue::Checksum;
pub(crate) use counter::Counter;
pub(crate) use e2e::{DataId, E2e, PROFILE_1_COUNTER_MAX};
pub(crate) use sum::FrameSum;

use crate::bits::BitField;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Protection {
    pub(crate) counter: Option<Counter>,
    pub(crate) seal: Option<Seal>,
}

/// A checksum, and what it covers beside the message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Seal {
    /// In a signal.
    Sum(FrameSum),
    E2e(E2e),
}

/// A receiver's verdict on a protected message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Checksum and counter are right. The first message, without a preceding counter, counts as right too.
    Ok,
    /// The checksum is right, and this many messages were lost before this one.
    Lost(u64),
    /// The checksum and the counter are right, and all messages missing before this one, this many, came with a wrong
    /// checksum. To a receiver they are lost; the sender's counter went on as it should.
    LostToDamage(u64),
    /// The checksum is right, and the counter equals that of the preceding message.
    Repeated,
    /// The checksum is right, and more messages are missing than allowed: this many.
    WrongSequence(u64),
    /// The checksum is right, and the counter has an impossible number.
    WrongCounter,
    /// The checksum, the data id or the length is wrong.
    WrongChecksum,
}

impl Verdict {
    /// True if a receiver uses the message.
    pub const fn is_sound(self) -> bool {
        matches!(self, Self::Ok | Self::Lost(_) | Self::LostToDamage(_))
    }
}

/// Protection signals with a value of their own, which stays unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Own {
    pub(crate) counter: bool,
    pub(crate) checksum: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sent {
    /// The counter in the last message.
    last: Option<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Received {
    /// The counter in the last message with a correct checksum.
    last: Option<u64>,
    /// Number of messages since then.
    damaged: u64,
}

impl Received {
    /// A message arrived whose counter says nothing, as its checksum is wrong.
    pub(crate) const fn damage(&mut self) {
        self.damaged += 1;
    }
}

impl Protection {
    /// Fills in the next counter number and the checksum in the bytes of a message. The counter also advances in a
    /// message with a number of its own, so that only that message is out of sequence.
    pub(crate) fn protect(&self, data: &mut [u8], sent: &mut Sent, own: Own) {
        if let Some(counter) = &self.counter {
            let number = sent.last.map_or(counter.first, |last| counter.next(last));
            sent.last = Some(number);
            if !own.counter {
                counter.field.set(data, number);
            }
        }
        if let Some(Seal::E2e(e2e)) = &self.seal {
            e2e.prepare(data);
        }
        if let (Some((field, sum)), false) = (self.sum(data), own.checksum) {
            field.set(data, sum);
        }
    }

    /// What both state and not alike.
    pub(crate) fn contradicts(&self, other: &Self) -> Option<&'static str> {
        let sent = |counter: &Counter| (counter.field, counter.step, counter.greatest);
        let counters = self.counter.as_ref().zip(other.counter.as_ref());
        if counters.is_some_and(|(one, two)| sent(one) != sent(two)) {
            return Some("counter");
        }
        let seals = self.seal.as_ref().zip(other.seal.as_ref());
        seals.is_some_and(|(one, two)| one != two).then_some("checksum")
    }

    pub(crate) fn reseal(&self, data: &mut [u8]) {
        if let Some((field, sum)) = self.sum(data) {
            field.set(data, sum);
        }
    }

    /// Writes a checksum with every bit inverted.
    pub(crate) fn spoil(&self, data: &mut [u8]) {
        if let Some((field, sum)) = self.sum(data) {
            field.set(data, !sum);
        }
    }

    pub(crate) fn check(&self, data: &[u8], received: &mut Received) -> Verdict {
        let is_whole = match &self.seal {
            Some(Seal::E2e(e2e)) => e2e.is_prepared(data),
            Some(Seal::Sum(_)) | None => true,
        };
        if !is_whole || self.sum(data).is_some_and(|(field, sum)| field.get(data) != sum) {
            received.damage();
            return Verdict::WrongChecksum;
        }
        let damaged = std::mem::take(&mut received.damaged);
        let Some(counter) = &self.counter else { return Verdict::Ok };
        let number = counter.field.get(data);
        let verdict = counter.judge(received.last, number);
        // Also after a gap that is too long: otherwise no later message would be accepted.
        if verdict != Verdict::WrongCounter {
            received.last = Some(number);
        }
        match verdict {
            Verdict::Lost(missing) if missing <= damaged => Verdict::LostToDamage(missing),
            verdict => verdict,
        }
    }

    fn sum(&self, data: &[u8]) -> Option<(BitField, u64)> {
        match self.seal.as_ref()? {
            Seal::Sum(sum) => Some((sum.field, sum.of(data))),
            Seal::E2e(e2e) => {
                let number = self.counter.map_or(0, |counter| counter.field.get(data));
                Some((e2e.crc_field(data.len())?, e2e.crc(data, number)))
            }
        }
    }
}
