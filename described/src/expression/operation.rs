//! Operators and functions.

use super::array::Array;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unary {
    Negate,
    Not,
    Abs,
    Sign,
    Floor,
    Ceil,
    Round,
    Sqrt,
    Exp,
    Ln,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Tanh,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Or,
    And,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
    Min,
    Max,
    Atan2,
    BitAnd,
    BitOr,
    BitXor,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    Of1(Unary),
    Of2(Binary),
    /// Applied to two values or more, from the left.
    Fold(Binary),
    /// `clamp(x, low, high)`.
    Clamp,
    /// `if(condition, then, else)`.
    If,
    /// `last(state)`.
    Last,
    /// Applied to an array.
    Aggregate(Aggregate),
    /// `time_in(machine)`.
    TimeIn,
}

/// The functions by name.
pub(super) const FUNCTIONS: &[(&str, Function)] = &[
    ("if", Function::If),
    ("min", Function::Fold(Binary::Min)),
    ("max", Function::Fold(Binary::Max)),
    ("clamp", Function::Clamp),
    ("last", Function::Last),
    ("abs", Function::Of1(Unary::Abs)),
    ("sign", Function::Of1(Unary::Sign)),
    ("floor", Function::Of1(Unary::Floor)),
    ("ceil", Function::Of1(Unary::Ceil)),
    ("round", Function::Of1(Unary::Round)),
    ("sqrt", Function::Of1(Unary::Sqrt)),
    ("exp", Function::Of1(Unary::Exp)),
    ("ln", Function::Of1(Unary::Ln)),
    ("log10", Function::Of1(Unary::Log10)),
    ("sin", Function::Of1(Unary::Sin)),
    ("cos", Function::Of1(Unary::Cos)),
    ("tan", Function::Of1(Unary::Tan)),
    ("asin", Function::Of1(Unary::Asin)),
    ("acos", Function::Of1(Unary::Acos)),
    ("atan", Function::Of1(Unary::Atan)),
    ("atan2", Function::Of2(Binary::Atan2)),
    ("tanh", Function::Of1(Unary::Tanh)),
];

/// Functions whose names variables may have too: they are recognised by the parenthesis.
pub(super) const FUNCTIONS_OF_NAMES: &[(&str, Function)] = &[
    ("sum", Function::Aggregate(Aggregate::Sum)),
    ("mean", Function::Aggregate(Aggregate::Mean)),
    ("argmin", Function::Aggregate(Aggregate::ArgMin)),
    ("argmax", Function::Aggregate(Aggregate::ArgMax)),
    ("time_in", Function::TimeIn),
    ("bit_and", Function::Fold(Binary::BitAnd)),
    ("bit_or", Function::Fold(Binary::BitOr)),
    ("bit_xor", Function::Fold(Binary::BitXor)),
];

/// All functions by name.
pub(super) fn functions() -> impl Iterator<Item = &'static (&'static str, Function)> {
    FUNCTIONS.iter().chain(FUNCTIONS_OF_NAMES)
}

/// True if a function has this name.
pub(crate) fn is_function(name: &str) -> bool {
    functions().any(|(known, _)| *known == name)
}

/// True for names with a meaning in every expression.
pub(crate) fn is_reserved(name: &str) -> bool {
    matches!(name, "t" | "pi" | "and" | "or" | "not")
        || FUNCTIONS.iter().any(|(known, _)| *known == name)
}

/// 1 for true, 0 for false.
fn truth(is: bool) -> f64 {
    f64::from(u8::from(is))
}

/// An operation on the bits of two whole numbers below 2^53, where a double has no gaps; NaN for others.
fn of_bits(a: f64, b: f64, operation: impl Fn(u64, u64) -> u64) -> f64 {
    let bits = |x: f64| ((0.0..=EXACT_MAX).contains(&x) && x % 1.0 == 0.0).then_some(x as u64);
    match (bits(a), bits(b)) {
        (Some(a), Some(b)) => operation(a, b) as f64,
        _ => f64::NAN,
    }
}

/// 2^53 - 1.
const EXACT_MAX: f64 = ((1u64 << f64::MANTISSA_DIGITS) - 1) as f64;

impl Unary {
    #[inline]
    pub(super) fn apply(self, x: f64) -> f64 {
        match self {
            Self::Negate => -x,
            Self::Not if x.is_nan() => x,
            Self::Not => truth(x == 0.0),
            Self::Abs => x.abs(),
            Self::Sign if x == 0.0 => 0.0,
            Self::Sign => x.signum(),
            Self::Floor => libm::floor(x),
            Self::Ceil => libm::ceil(x),
            Self::Round => libm::round(x),
            Self::Sqrt => libm::sqrt(x),
            Self::Exp => libm::exp(x),
            Self::Ln => libm::log(x),
            Self::Log10 => libm::log10(x),
            Self::Sin => libm::sin(x),
            Self::Cos => libm::cos(x),
            Self::Tan => libm::tan(x),
            Self::Asin => libm::asin(x),
            Self::Acos => libm::acos(x),
            Self::Atan => libm::atan(x),
            Self::Tanh => libm::tanh(x),
        }
    }
}

impl Binary {
    /// NaN propagates: a comparison does not turn it into false, nor a minimum into the other value.
    #[inline]
    pub(super) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            // NaN propagates by itself.
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            _ if a.is_nan() || b.is_nan() => f64::NAN,
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Less => truth(a < b),
            Self::LessOrEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterOrEqual => truth(a >= b),
            Self::Equal => truth(a == b),
            Self::NotEqual => truth(a != b),
            Self::Modulo => a - b * libm::floor(a / b),
            Self::Power => libm::pow(a, b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
            Self::Atan2 => libm::atan2(a, b),
            Self::BitAnd => of_bits(a, b, |a, b| a & b),
            Self::BitOr => of_bits(a, b, |a, b| a | b),
            Self::BitXor => of_bits(a, b, |a, b| a ^ b),
        }
    }
}

/// A function of a whole array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aggregate {
    Min,
    Max,
    Sum,
    Mean,
    /// The index of the smallest element, the first of several.
    ArgMin,
    ArgMax,
}

impl Aggregate {
    /// If an element is NaN, the result is too.
    pub(super) fn of(self, array: Array, variables: &[f64]) -> f64 {
        let values = variables.get(array.slots()).unwrap_or_default();
        let fold = |binary: Binary| values.iter().copied().reduce(|a, b| binary.apply(a, b));
        let extreme = |binary| {
            let value = fold(binary)?;
            let place = values.iter().position(|one| *one == value)?;
            Some(f64::from(array.first) + place as f64)
        };
        let value = match self {
            Self::Min => fold(Binary::Min),
            Self::Max => fold(Binary::Max),
            Self::Sum => fold(Binary::Add),
            Self::Mean => fold(Binary::Add).map(|sum| sum / f64::from(array.count)),
            Self::ArgMin => extreme(Binary::Min),
            Self::ArgMax => extreme(Binary::Max),
        };
        value.unwrap_or(f64::NAN)
    }
}
