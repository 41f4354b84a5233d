//! Truth and robustness of a formula in one ordered number.

use std::cmp::Ordering;
use std::fmt;
use std::ops::Neg;

/// Truth of a formula at one moment: false, unknown or true, with a margin.
///
/// The margin is the robustness of Donzé & Maler (2010): how far the signals could move before the formula changes, as
/// a share of the range of the comparison. Truths are ordered: clearly false, just false, unknown, just true, clearly
/// true. `and` is the minimum, `or` the maximum, `not` the mirror image. So a formula with margin zero is still either
/// true (`x >= 4` at 4) or false (`x > 4` at 4).
///
/// If one operand is unknown and the other decides, the margin is that of the deciding operand: a lower bound, since
/// the unknown one could only increase it.
#[derive(Clone, Copy)]
pub struct Truth {
    rank: i64,
    /// The deciding comparison, by its number. With equal margins it may be either.
    comparison: usize,
}

impl Truth {
    /// Neither true nor false: a signal has no value.
    pub const UNKNOWN: Self = Self::ranked(0);
    /// True whatever the signals do: "at every moment" of an empty set.
    pub const TRUE: Self = Self::ranked(f64::INFINITY.to_bits() as i64 + 1);
    /// False whatever the signals do: "at some moment" of an empty set.
    pub const FALSE: Self = Self::ranked(-(f64::INFINITY.to_bits() as i64 + 1));

    const fn ranked(rank: i64) -> Self {
        Self { rank, comparison: 0 }
    }

    /// True or false with the absolute value of `distance` as margin; unknown if it is NaN.
    pub fn new(holds: bool, distance: f64) -> Self {
        if distance.is_nan() {
            return Self::UNKNOWN;
        }
        // The bits of positive floats have the same order as the floats.
        let rank = distance.abs().to_bits() as i64 + 1;
        Self::ranked(if holds { rank } else { -rank })
    }

    pub(crate) const fn by(self, comparison: usize) -> Self {
        Self { comparison, ..self }
    }

    pub(crate) const fn comparison(self) -> usize {
        self.comparison
    }

    /// Whether it holds; `None` if unknown.
    pub fn holds(self) -> Option<bool> {
        (self != Self::UNKNOWN).then_some(self.rank > 0)
    }

    /// The robustness: positive or zero if it holds, otherwise negative or zero.
    pub fn robustness(self) -> Option<f64> {
        let holds = self.holds()?;
        let distance = f64::from_bits(self.rank.unsigned_abs() - 1);
        // No negative zero in the result.
        Some(if holds || distance == 0.0 { distance } else { -distance })
    }

    pub(crate) fn is_known(self) -> bool {
        self != Self::UNKNOWN
    }
}

impl Neg for Truth {
    type Output = Self;
    fn neg(self) -> Self {
        Self { rank: -self.rank, ..self }
    }
}

impl PartialEq for Truth {
    fn eq(&self, other: &Self) -> bool {
        self.rank == other.rank
    }
}

impl Eq for Truth {}

impl PartialOrd for Truth {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Truth {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank.cmp(&other.rank)
    }
}

impl fmt::Debug for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.holds(), self.robustness()) {
            (Some(holds), Some(robustness)) => write!(f, "{holds}({robustness})"),
            _ => f.write_str("unknown"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Truth;
    use proptest::prelude::*;

    #[test]
    fn a_margin_of_zero_keeps_its_side() {
        let (holds, fails) = (Truth::new(true, 0.0), Truth::new(false, -0.0));
        assert_eq!((holds.holds(), holds.robustness()), (Some(true), Some(0.0)));
        assert_eq!((fails.holds(), fails.robustness()), (Some(false), Some(0.0)));
        assert!(fails.robustness().is_some_and(f64::is_sign_positive));
        assert!(fails < Truth::UNKNOWN && Truth::UNKNOWN < holds);
        assert_eq!(-holds, fails);
    }

    #[test]
    fn the_ends_are_infinite() {
        assert_eq!(Truth::TRUE.robustness(), Some(f64::INFINITY));
        assert_eq!(-Truth::TRUE, Truth::FALSE);
        assert_eq!(Truth::new(true, f64::NAN), Truth::UNKNOWN);
        assert_eq!(Truth::new(false, f64::INFINITY), Truth::FALSE);
    }

    proptest! {
        #[test]
        fn order_is_that_of_the_robustness(a in -1e6f64..1e6, b in -1e6f64..1e6) {
            let (x, y) = (Truth::new(a > 0.0, a), Truth::new(b > 0.0, b));
            prop_assert_eq!(x.robustness(), Some(a));
            prop_assert_eq!(x < y, a < b);
            prop_assert_eq!((-x).robustness(), Some(-a));
        }
    }
}
