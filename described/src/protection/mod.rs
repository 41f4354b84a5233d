//! Counters and checksums in messages, as vehicles have them: put in by who sends, judged by who receives.
//!
//! Nothing here knows of signals: a counter and a checksum are bits of a message.

mod catalogue;
mod counter;
mod e2e;
mod sum;
mod table;
#[cfg(test)]
mod tests;

pub(crate) use catalogue::Checksum;
pub(crate) use counter::Counter;
pub(crate) use e2e::{DataId, E2e, PROFILE_1_COUNTER_MAX};
pub(crate) use sum::FrameSum;
pub use table::ProtectionTable;
pub(crate) use table::{ChecksumTable, CounterTable, E2eTable, Profile};

/// What protects a message.
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
    /// As AUTOSAR has it.
    E2e(E2e),
}

/// What a receiver of a protected message finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Checksum and counter are right. The first message has no counter before it, and that is right too.
    Ok,
    /// The checksum is right, and so many messages before this one did not come.
    Lost(u64),
    /// The checksum is right, and the counter that of the message before.
    Repeated,
    /// The checksum is right, and more messages are missing than are allowed: so many.
    WrongSequence(u64),
    /// The checksum is right, and the counter a number that it never has.
    WrongCounter,
    /// The checksum is another, or the data id, or the length.
    WrongChecksum,
}

impl Verdict {
    /// A receiver uses the message.
    pub const fn is_sound(self) -> bool {
        matches!(self, Self::Ok | Self::Lost(_))
    }
}

/// Which protecting signals have a value of their own, that stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Own {
    pub(crate) counter: bool,
    pub(crate) checksum: bool,
}

/// What the sender of a message remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sent {
    /// The number of the counter in the last message.
    last: Option<u64>,
}

/// What the receiver of a message remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Received {
    /// The number of the counter in the last message whose checksum was right.
    last: Option<u64>,
}

impl Protection {
    /// Puts the next number of the counter and the checksum into the bytes of a message. The counter goes on in a message
    /// that has a number of its own too, so that it alone is out of line.
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

    /// Puts the checksum of the bytes as they are into them.
    pub(crate) fn reseal(&self, data: &mut [u8]) {
        if let Some((field, sum)) = self.sum(data) {
            field.set(data, sum);
        }
    }

    /// Puts in a checksum that is wrong in each bit.
    pub(crate) fn spoil(&self, data: &mut [u8]) {
        if let Some((field, sum)) = self.sum(data) {
            field.set(data, !sum);
        }
    }

    /// Judges the bytes of a message.
    pub(crate) fn check(&self, data: &[u8], received: &mut Received) -> Verdict {
        let is_whole = match &self.seal {
            Some(Seal::E2e(e2e)) => e2e.is_prepared(data),
            Some(Seal::Sum(_)) | None => true,
        };
        if !is_whole || self.sum(data).is_some_and(|(field, sum)| field.get(data) != sum) {
            return Verdict::WrongChecksum;
        }
        let Some(counter) = &self.counter else { return Verdict::Ok };
        let number = counter.field.get(data);
        let verdict = counter.judge(received.last, number);
        // Behind a gap that is too long too: else nothing would ever be right again.
        if verdict != Verdict::WrongCounter {
            received.last = Some(number);
        }
        verdict
    }

    /// Where the checksum belongs, and what it is.
    fn sum(&self, data: &[u8]) -> Option<(crate::layout::BitField, u64)> {
        match self.seal.as_ref()? {
            Seal::Sum(sum) => Some((sum.field, sum.of(data))),
            Seal::E2e(e2e) => {
                let number = self.counter.map_or(0, |counter| counter.field.get(data));
                Some((e2e.crc_field(data.len())?, e2e.crc(data, number)))
            }
        }
    }
}
