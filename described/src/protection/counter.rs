//! A counter that advances from message to message.

use super::Verdict;
use crate::bits::BitField;

/// Maximum number of steps tried to get from one number to another, for counters with a step above one.
const STEPS_TRIED: u128 = 1 << 16;

/// The position of a message's counter, and its rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Counter {
    pub(crate) field: BitField,
    /// Number in the first message.
    pub(crate) first: u64,
    /// Increment per message; not zero, and at most `greatest`.
    pub(crate) step: u64,
    /// The last number before it wraps.
    pub(crate) greatest: u64,
    /// The largest difference that a receiver accepts, in steps; `None` for any.
    pub(crate) max_delta: Option<u64>,
}

impl Counter {
    /// The number after `number`.
    pub(crate) fn next(&self, number: u64) -> u64 {
        ((u128::from(number) + u128::from(self.step)) % self.modulo()) as u64
    }

    /// The verdict on the number of a receiver whose last number was `last`.
    pub(super) fn judge(&self, last: Option<u64>, number: u64) -> Verdict {
        if number > self.greatest {
            return Verdict::WrongCounter;
        }
        let Some(last) = last else { return Verdict::Ok };
        match self.steps(last, number) {
            None => Verdict::WrongCounter,
            Some(0) => Verdict::Repeated,
            Some(1) => Verdict::Ok,
            Some(steps) if self.max_delta.is_some_and(|most| steps > most) => {
                Verdict::WrongSequence(steps - 1)
            }
            Some(steps) => Verdict::Lost(steps - 1),
        }
    }

    /// The smallest number of steps from one number to the other.
    fn steps(&self, from: u64, to: u64) -> Option<u64> {
        let modulo = self.modulo();
        if self.step == 1 {
            return Some(((u128::from(to) + modulo - u128::from(from)) % modulo) as u64);
        }
        let mut number = from;
        for steps in 0..modulo.min(STEPS_TRIED) {
            if number == to {
                return Some(steps as u64);
            }
            number = self.next(number);
        }
        None
    }

    fn modulo(&self) -> u128 {
        u128::from(self.greatest) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::{BitField, Counter, Verdict};
    use crate::file::ByteOrder;

    fn counter(step: u64, greatest: u64, max_delta: Option<u64>) -> Counter {
        let field = BitField::new(ByteOrder::Little, 0, 64, 8).unwrap();
        Counter { field, first: 0, step, greatest, max_delta }
    }

    #[test]
    fn it_begins_again_behind_its_greatest() {
        assert_eq!(counter(1, 14, None).next(13), 14);
        assert_eq!(counter(1, 14, None).next(14), 0);
        assert_eq!(counter(3, 15, None).next(14), 1);
        assert_eq!(counter(1, u64::MAX, None).next(u64::MAX), 0);
    }

    #[test]
    fn a_receiver_counts_what_was_lost() {
        let plain = counter(1, 14, None);
        assert_eq!(plain.judge(None, 9), Verdict::Ok);
        assert_eq!(plain.judge(Some(14), 0), Verdict::Ok);
        assert_eq!(plain.judge(Some(14), 14), Verdict::Repeated);
        assert_eq!(plain.judge(Some(13), 2), Verdict::Lost(3));
        assert_eq!(plain.judge(Some(3), 2), Verdict::Lost(13));
        assert_eq!(plain.judge(None, 15), Verdict::WrongCounter);
        let strict = counter(1, 14, Some(2));
        assert_eq!(strict.judge(Some(0), 2), Verdict::Lost(1));
        assert_eq!(strict.judge(Some(0), 3), Verdict::WrongSequence(2));
    }

    #[test]
    fn a_counter_by_several_meets_some_numbers_alone() {
        let even = counter(2, 15, None);
        assert_eq!(even.judge(Some(14), 0), Verdict::Ok);
        assert_eq!(even.judge(Some(14), 2), Verdict::Lost(1));
        assert_eq!(even.judge(Some(14), 3), Verdict::WrongCounter);
    }
}
