//! Physical values as counts, and back.

use crate::bits::SIGNAL_BITS_MAX;

/// Allowed excess over the end of a range, in counts: the rounding error of decimal fractions in binary.
pub(super) const RANGE_SLACK_COUNTS: f64 = 1e-6;
/// A decimal fraction, its scale and their product, each rounded to a double, as a share of the value.
const DOUBLE_SLACK: f64 = 4.0 * f64::EPSILON;

/// Encoding of a number in the bits of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    Unsigned,
    /// Two's complement.
    Signed,
    /// IEEE 754 binary32.
    Float32,
    /// IEEE 754 binary64.
    Float64,
}

/// Physical value = `factor` times the number on the wire, plus `offset`.
///
/// Both are written as decimal fractions, and so are the limits of a value: 401 by (0.1, -40) is 0.1, and not the
/// 0.10000000000000142 of the doubles. So the value is `(numerator * number + addend) / denominator`, with whole numbers and a
/// power of ten, which is rounded once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Finite and not zero.
    pub(crate) factor: f64,
    /// Finite.
    pub(crate) offset: f64,
    numerator: f64,
    addend: f64,
    /// 1 where factor or offset has too many digits.
    denominator: f64,
}

/// Most decimal places of a scale: ten to this power is exact as a double, and so are 15 digits.
const PLACES_MAX: i32 = 15;

/// Decimal places of a number, as it is written most shortly.
fn places(number: f64) -> i32 {
    let text = format!("{number:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let behind = digits.split_once('.').map_or(0, |(_, behind)| behind.len());
    behind as i32 - exponent.parse::<i32>().unwrap_or(0)
}

impl Scale {
    pub(crate) const ONE: Self =
        Self { factor: 1.0, offset: 0.0, numerator: 1.0, addend: 0.0, denominator: 1.0 };

    pub(crate) fn new(factor: f64, offset: f64) -> Option<Self> {
        if !(factor.is_finite() && factor != 0.0 && offset.is_finite()) {
            return None;
        }
        let places = places(factor).max(places(offset)).max(0);
        let denominator = 10_f64.powi(places.min(PLACES_MAX));
        let [numerator, addend] = [factor, offset].map(|one| libm::round(one * denominator));
        let is_exact = numerator / denominator == factor && addend / denominator == offset;
        Some(match is_exact {
            true => Self { factor, offset, numerator, addend, denominator },
            false => Self { factor, offset, numerator: factor, addend: offset, denominator: 1.0 },
        })
    }

    pub(crate) fn physical(self, number: f64) -> f64 {
        (self.numerator * number + self.addend) / self.denominator
    }

    /// Whether the value `sent`, one of those `step` apart, is not `value`. A decimal fraction is only as far from a step as
    /// its double is.
    pub(crate) fn is_another(self, sent: f64, value: f64, step: f64) -> bool {
        let of_doubles = (value.abs() + self.offset.abs()) * DOUBLE_SLACK;
        (sent - value).abs() > of_doubles.max(RANGE_SLACK_COUNTS * step)
    }

    pub(crate) fn number(self, physical: f64) -> f64 {
        (physical - self.offset) / self.factor
    }

    /// The range between two numbers on the wire, the smaller value first; limited to finite doubles.
    pub(crate) fn range(self, first: f64, last: f64) -> (f64, f64) {
        let end = |number: f64| self.physical(number).clamp(f64::MIN, f64::MAX);
        let (a, b) = (end(first), end(last));
        (a.min(b), a.max(b))
    }
}

impl Coding {
    /// The smallest and the largest number in `bits` bits.
    pub(crate) fn limits(self, bits: u32) -> (f64, f64) {
        let reach = |bits: u32| libm::exp2(f64::from(bits));
        match self {
            Self::Unsigned => (0.0, reach(bits) - 1.0),
            Self::Signed => (-reach(bits - 1), reach(bits - 1) - 1.0),
            Self::Float32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
            Self::Float64 => (f64::MIN, f64::MAX),
        }
    }

    pub(crate) const fn is_float(self) -> bool {
        matches!(self, Self::Float32 | Self::Float64)
    }

    /// The number encoded by the lowest `bits` bits of `raw`.
    pub(crate) fn number(self, raw: u64, bits: u32) -> f64 {
        let above = SIGNAL_BITS_MAX - bits;
        match self {
            Self::Unsigned => raw as f64,
            Self::Signed => (((raw << above) as i64) >> above) as f64,
            Self::Float32 => f64::from(f32::from_bits(raw as u32)),
            Self::Float64 => f64::from_bits(raw),
        }
    }

    /// The number that a receiver reads for this one.
    fn rounded(self, number: f64) -> f64 {
        match self {
            Self::Unsigned | Self::Signed => libm::round(number),
            Self::Float32 => f64::from(number as f32),
            Self::Float64 => number,
        }
    }

    /// The bits of `physical`, rounded to the nearest count; `None` for NaN, and if that count exceeds the bits or the
    /// counts of `minimum` and `maximum`.
    pub(crate) fn raw(
        self,
        physical: f64,
        bits: u32,
        scale: Scale,
        (minimum, maximum): (f64, f64),
    ) -> Option<u64> {
        let number = self.rounded(scale.number(physical));
        let (least, greatest) = self.limits(bits);
        // The end of a range may lie between two counts.
        let ends = [minimum, maximum].map(|end| self.rounded(scale.number(end)));
        let range = ends[0].min(ends[1])..=ends[0].max(ends[1]);
        if !(least..=greatest).contains(&number) || !range.contains(&number) {
            return None;
        }
        let unused = SIGNAL_BITS_MAX - bits;
        Some(match self {
            // As a double, the largest number of more than 53 bits is one too large.
            Self::Unsigned => (number as u64).min(u64::MAX >> unused),
            Self::Signed => (number as i64).min(i64::MAX >> unused) as u64,
            Self::Float32 => u64::from((number as f32).to_bits()),
            Self::Float64 => number.to_bits(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Coding, Scale};

    const ALL: (f64, f64) = (f64::MIN, f64::MAX);

    #[test]
    fn counts_are_rounded_and_the_ends_are_inside() {
        let scale = Scale::new(0.01, 0.0).unwrap();
        let raw = |value, range| Coding::Signed.raw(value, 16, scale, range);
        assert_eq!(raw(-0.014, ALL), Some(-1i64 as u64));
        assert_eq!(raw(327.67, ALL), Some(32_767));
        assert_eq!(raw(327.674, ALL), Some(32_767));
        assert_eq!(raw(327.68, ALL), None);
        assert_eq!(raw(-327.68, ALL), Some(-32_768i64 as u64));
        assert_eq!(raw(0.3, (0.1, 0.3)), Some(30));
        assert_eq!(raw(0.31, (0.1, 0.3)), None);
        assert_eq!(raw(0.304, (0.1, 0.304)), Some(30));
        assert_eq!(raw(0.304, (0.1, 0.3)), Some(30));
        // The value sent for 0.309 is within the range that ends there.
        assert_eq!(raw(0.31, (0.1, 0.309)), Some(31));
        assert_eq!(raw(f64::NAN, ALL), None);
        assert_eq!(raw(f64::INFINITY, ALL), None);
    }

    /// Found by a user: a band from 0.1 failed at its own end, and `> 0.1` was true there.
    #[test]
    fn a_value_is_the_decimal_fraction_that_the_layout_means() {
        let value = |factor, offset, number| Scale::new(factor, offset).unwrap().physical(number);
        assert_eq!(value(0.1, -40.0, 401.0), 0.1);
        assert_eq!(value(0.1, 0.0, 3.0), 0.3);
        assert_eq!(value(-0.01, 27.35, 2_725.0), 0.1);
        assert_eq!(value(1e-3, -0.0005, 2.0), 0.0015);
        assert_eq!(value(5e-324, 0.0, 2.0), 1e-323);
        for number in 0..100_000 {
            let text = format!("{}.{:02}", number / 100, number % 100);
            assert_eq!(
                value(0.01, -250.0, f64::from(number + 25_000)),
                text.parse::<f64>().unwrap()
            );
        }
        // Of a third, no decimal fraction is meant.
        assert_eq!(value(1.0 / 3.0, 1.0, 3.0), 2.0);
    }

    #[test]
    fn the_greatest_number_of_many_bits_is_all_of_them() {
        let scale = Scale::new(1.0, 0.0).unwrap();
        for bits in [53, 54, 56, 64] {
            for coding in [Coding::Unsigned, Coding::Signed] {
                let (least, greatest) = coding.limits(bits);
                let raw = |number| coding.raw(number, bits, scale, ALL).unwrap();
                let ends = [raw(least), raw(greatest)].map(|raw| coding.number(raw, bits));
                assert_eq!(ends, [least, greatest], "{coding:?} {bits}");
            }
        }
    }

    #[test]
    fn the_top_bit_is_the_sign() {
        assert_eq!(Coding::Signed.number(0b111, 3), -1.0);
        assert_eq!(Coding::Signed.number(u64::MAX, 64), -1.0);
        assert_eq!(Coding::Unsigned.number(0b111, 3), 7.0);
        assert_eq!(Coding::Signed.limits(1), (-1.0, 0.0));
    }

    #[test]
    fn a_falling_scale_has_its_least_value_at_the_greatest_count() {
        let scale = Scale::new(-0.5, 10.0).unwrap();
        assert_eq!(scale.range(0.0, 255.0), (-117.5, 10.0));
        assert_eq!(Scale::new(0.0, 1.0), None);
        assert_eq!(Scale::new(1.0, f64::NAN), None);
    }

    #[test]
    fn floats_are_kept_and_what_overflows_them_is_refused() {
        let scale = Scale::new(1.0, 0.0).unwrap();
        let raw = Coding::Float32.raw(1.5, 32, scale, ALL).unwrap();
        assert_eq!(Coding::Float32.number(raw, 32), 1.5);
        assert_eq!(Coding::Float32.raw(1e39, 32, scale, ALL), None);
        let raw = Coding::Float64.raw(-1e300, 64, scale, ALL).unwrap();
        assert_eq!(Coding::Float64.number(raw, 64), -1e300);
    }
}
