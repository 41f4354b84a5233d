//! Arithmetic on the current values of the signals.

/// An expression with a numeric value; NaN while one of its signals has no value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Number {
    Constant(f64),
    /// The value of a signal of the formula.
    Slot(usize),
    Negate(Box<Number>),
    Abs(Box<Number>),
    /// Conversion to another unit: the factor and the power of ten.
    Scale(Box<Number>, f64, i32),
    Binary(Binary, Box<Number>, Box<Number>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Min,
    Max,
    /// Of the bits of whole numbers below 2^53, where a double has no gaps; NaN for others.
    BitAnd,
}

impl Number {
    pub(crate) fn value(&self, slots: &[f64]) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Slot(slot) => slots.get(*slot).copied().unwrap_or(f64::NAN),
            Self::Negate(of) => -of.value(slots),
            Self::Abs(of) => of.value(slots).abs(),
            Self::Scale(of, factor, tens) => scale(of.value(slots), *factor, *tens),
            Self::Binary(binary, left, right) => {
                binary.apply(left.value(slots), right.value(slots))
            }
        }
    }

    /// Smallest and largest possible value by interval arithmetic, as if all operands were independent; `None` if the
    /// range of a signal is unknown.
    pub(crate) fn range(&self, of: &dyn Fn(usize) -> Option<(f64, f64)>) -> Option<(f64, f64)> {
        Some(match self {
            Self::Constant(value) => (*value, *value),
            Self::Slot(slot) => of(*slot)?,
            Self::Negate(number) => {
                let (least, greatest) = number.range(of)?;
                (-greatest, -least)
            }
            Self::Abs(number) => {
                let (least, greatest) = number.range(of)?;
                (least.max(-greatest).max(0.0), greatest.max(-least))
            }
            Self::Scale(number, factor, tens) => {
                let (least, greatest) = number.range(of)?;
                let ends = [least, greatest].map(|end| scale(end, *factor, *tens));
                (ends[0].min(ends[1]), ends[0].max(ends[1]))
            }
            Self::Binary(binary, left, right) => binary.range(left.range(of)?, right.range(of)?),
        })
    }

    pub(crate) fn binary(binary: Binary, left: Self, right: Self) -> Self {
        match (&left, &right) {
            (Self::Constant(a), Self::Constant(b)) => Self::Constant(binary.apply(*a, *b)),
            _ => Self::Binary(binary, Box::new(left), Box::new(right)),
        }
    }

    pub(crate) fn negated(self) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(-value),
            other => Self::Negate(Box::new(other)),
        }
    }

    pub(crate) fn scaled(self, factor: f64, tens: i32) -> Self {
        match self {
            same if factor == 1.0 && tens == 0 => same,
            Self::Constant(value) => Self::Constant(scale(value, factor, tens)),
            other => Self::Scale(Box::new(other), factor, tens),
        }
    }
}

impl Binary {
    /// The range of the result for these ranges of the operands. Division by a range that contains zero is unbounded.
    pub(crate) fn range(self, (a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
        let corners = [(a, c), (a, d), (b, c), (b, d)].map(|(left, right)| self.apply(left, right));
        let is_unbounded = self == Self::Divide && c <= 0.0 && d >= 0.0;
        if is_unbounded {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        if self == Self::BitAnd {
            return (0.0, b.min(d).max(0.0));
        }
        let least = corners.iter().copied().fold(f64::INFINITY, f64::min);
        (least, corners.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            // `min` and `max` of the standard library hide NaN.
            Self::Min | Self::Max if a.is_nan() || b.is_nan() => f64::NAN,
            Self::Min => a.min(b),
            Self::Max => a.max(b),
            Self::BitAnd => {
                const WHOLE: u64 = 1 << f64::MANTISSA_DIGITS;
                let bits =
                    |x: f64| (x >= 0.0 && x < WHOLE as f64 && x % 1.0 == 0.0).then_some(x as u64);
                bits(a).zip(bits(b)).map_or(f64::NAN, |(a, b)| (a & b) as f64)
            }
        }
    }
}

/// For negative powers it divides by a power of ten, since 0.001 is no exact float: 4250 mV are 4.25 V.
fn scale(value: f64, factor: f64, tens: i32) -> f64 {
    let value = value * factor;
    if tens < 0 { value / 10f64.powi(-tens) } else { value * 10f64.powi(tens) }
}

#[cfg(test)]
mod tests {
    use super::Binary;

    #[test]
    fn bits_are_those_of_whole_numbers() {
        let and = |a: f64, b: f64| Binary::BitAnd.apply(a, b);
        assert_eq!(and(592.0, 0x6F as f64), 64.0);
        assert_eq!(and(9_007_199_254_740_991.0, 7.0), 7.0);
        for a in [-1.0, 0.5, f64::NAN, f64::INFINITY, 9_007_199_254_740_992.0] {
            assert!(and(a, 1.0).is_nan(), "{a}");
        }
        assert_eq!(Binary::BitAnd.range((-5.0, 300.0), (111.0, 111.0)), (0.0, 111.0));
    }
}
