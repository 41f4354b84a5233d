//! Instants and spans of bench time, in whole nanoseconds.
//!
//! Time is always an argument. Its origin is the start of the run: nothing in this crate reads a clock.

use crate::operator::operator;
use serde::{Deserialize, Serialize};

/// An instant, in nanoseconds since the run began.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Timestamp(i64);

/// A length of time in nanoseconds; negative if the end precedes the start.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Span(i64);

const NANOS_PER_SECOND: f64 = 1e9;

impl Timestamp {
    /// The start of the run.
    pub const ZERO: Self = Self(0);
    /// Later than every event of a run.
    pub const MAX: Self = Self(i64::MAX);

    /// `nanos` nanoseconds after the run began.
    #[inline]
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// `seconds` after the run began, to the nearest nanosecond; saturates.
    #[inline]
    pub fn from_secs_f64(seconds: f64) -> Self {
        Self(Span::from_secs_f64(seconds).0)
    }

    /// Nanoseconds since the run began.
    #[inline]
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// Seconds since the run began.
    #[inline]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 / NANOS_PER_SECOND
    }

    /// The time from `earlier` to `self`.
    #[inline]
    pub const fn since(self, earlier: Self) -> Span {
        Span(difference(self.0, earlier.0))
    }
}

impl Span {
    /// No time at all.
    pub const ZERO: Self = Self(0);
    /// Longer than every run.
    pub const MAX: Self = Self(i64::MAX);

    /// A span of whole nanoseconds.
    #[inline]
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// A span of whole microseconds.
    #[inline]
    pub const fn from_micros(micros: i64) -> Self {
        Self(micros.saturating_mul(1_000))
    }

    /// A span of whole milliseconds.
    #[inline]
    pub const fn from_millis(millis: i64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// A span of whole seconds.
    #[inline]
    pub const fn from_secs(seconds: i64) -> Self {
        Self(seconds.saturating_mul(1_000_000_000))
    }

    /// A span of `seconds`, to the nearest nanosecond; saturates, and a NaN becomes zero.
    #[inline]
    pub fn from_secs_f64(seconds: f64) -> Self {
        Self(libm::round(seconds * NANOS_PER_SECOND) as i64)
    }

    /// The span in nanoseconds.
    #[inline]
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// The span in seconds.
    #[inline]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 / NANOS_PER_SECOND
    }
}

/// The sum, saturated. Saturation is out of line: times are added all the time and do not overflow.
#[inline]
const fn sum(a: i64, b: i64) -> i64 {
    match a.checked_add(b) {
        Some(sum) => sum,
        None => end_of_range(b > 0),
    }
}

/// The difference; see [`sum`].
#[inline]
const fn difference(a: i64, b: i64) -> i64 {
    match a.checked_sub(b) {
        Some(difference) => difference,
        None => end_of_range(b < 0),
    }
}

#[cold]
const fn end_of_range(is_upper: bool) -> i64 {
    if is_upper { i64::MAX } else { i64::MIN }
}

operator!(Add::add, Timestamp, Span => Timestamp, |a, b| Timestamp(sum(a.0, b.0)));
operator!(AddAssign::add_assign, Timestamp, Span, |a, b| a + b);
operator!(Sub::sub, Timestamp, Span => Timestamp, |a, b| Timestamp(difference(a.0, b.0)));
operator!(Sub::sub, Timestamp, Timestamp => Span, |a, b| a.since(b));
operator!(Add::add, Span, Span => Span, |a, b| Span(sum(a.0, b.0)));
operator!(AddAssign::add_assign, Span, Span, |a, b| a + b);
operator!(Sub::sub, Span, Span => Span, |a, b| Span(difference(a.0, b.0)));
operator!(SubAssign::sub_assign, Span, Span, |a, b| a - b);
operator!(Neg::neg, Span => Span, |a| Span(a.0.saturating_neg()));
operator!(Mul::mul, Span, i64 => Span, |a, count| Span(a.0.saturating_mul(count)));
// A division by zero gives zero.
operator!(Div::div, Span, i64 => Span, |a, count| Span(a.0.checked_div(count).unwrap_or(0)));

#[cfg(test)]
mod tests {
    use super::{Span, Timestamp};
    use proptest::prelude::*;

    #[test]
    fn seconds_become_nanoseconds_and_come_back() {
        assert_eq!(Timestamp::from_secs_f64(0.027).as_nanos(), 27_000_000);
        assert_eq!(Span::from_millis(27).as_secs_f64(), 0.027);
        assert_eq!(Timestamp::from_secs_f64(57_600.0) - Timestamp::ZERO, Span::from_secs(57_600));
    }

    #[test]
    fn the_ends_of_the_range_saturate() {
        assert_eq!(Timestamp::MAX + Span::from_secs(1), Timestamp::MAX);
        assert_eq!(Span::from_secs_f64(f64::INFINITY), Span::MAX);
        assert_eq!(Span::from_secs_f64(f64::NAN), Span::ZERO);
        assert_eq!(Span::from_secs(1) / 0, Span::ZERO);
    }

    proptest! {
        #[test]
        fn no_arithmetic_panics(a in any::<i64>(), b in any::<i64>(), n in any::<i64>()) {
            let (t, s) = (Timestamp::from_nanos(a), Span::from_nanos(b));
            let _ = (t + s, t - s, s + s, s - s, -s, s * n, s / n, t - Timestamp::from_nanos(b));
        }

        #[test]
        fn a_span_added_is_the_span_between(a in -(1i64 << 60)..(1 << 60), b in -(1i64 << 60)..(1 << 60)) {
            let (t, s) = (Timestamp::from_nanos(a), Span::from_nanos(b));
            prop_assert_eq!((t + s) - t, s);
        }
    }
}
