//! Arithmetic over the signals' present values.

/// An expression with a number as its value, not a number while a signal in it has none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Number {
    Constant(f64),
    /// The value of a signal of the formula.
    Slot(usize),
    Negate(Box<Number>),
    Abs(Box<Number>),
    /// In another unit: times the factor, times ten to the power.
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
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            // Those of the standard library hide what is not a number.
            Self::Min | Self::Max if a.is_nan() || b.is_nan() => f64::NAN,
            Self::Min => a.min(b),
            Self::Max => a.max(b),
        }
    }
}

/// Divides by a power of ten rather than multiply by one that no float is: 4250 mV are 4.25 V.
fn scale(value: f64, factor: f64, tens: i32) -> f64 {
    let value = value * factor;
    if tens < 0 { value / 10f64.powi(-tens) } else { value * 10f64.powi(tens) }
}
