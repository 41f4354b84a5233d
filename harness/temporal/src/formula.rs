//! A parsed formula.

use crate::number::Number;
use crate::truth::Truth;
use wire::time::Span;

/// A formula with resolved signals and checked units: the input of a [`Monitor`](crate::Monitor).
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    pub(crate) text: String,
    pub(crate) condition: Condition,
    pub(crate) signals: Vec<Used>,
    /// The units of its comparisons.
    pub(crate) units: Vec<String>,
    /// Of `a -> b`.
    pub(crate) premise: Option<Premise>,
}

/// The left side of a formula `a -> b`: where it is never true, `b` is never asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Premise {
    pub(crate) text: String,
    /// `a` is true and `b` is known.
    pub(crate) answered: Condition,
    /// `a` is true and `b` is unknown.
    pub(crate) unanswered: Condition,
    /// How far `b` looks ahead.
    pub(crate) limit: Span,
}

impl Premise {
    pub(crate) fn new(text: &str, left: Condition, right: &Condition) -> Self {
        let known = || Box::new(Condition::Known(Box::new(right.clone())));
        let left = Box::new(left);
        Self {
            text: text.to_owned(),
            answered: Condition::And(left.clone(), known()),
            unanswered: Condition::And(left, Box::new(Condition::Not(known()))),
            limit: Span::from_nanos(right.horizon()),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Used {
    pub name: String,
    /// The caller's number for it, as returned by [`Signals`](crate::Signals).
    pub index: usize,
    /// It counts messages: before the first there were none, and it is never unknown.
    pub counts: bool,
}

impl Used {
    /// Its value before the first update.
    pub(crate) const fn before(&self) -> f64 {
        if self.counts { 0.0 } else { f64::NAN }
    }
}

/// A part of a formula that is true or false at a moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Condition {
    Compare(Comparator, Number, Number, Width),
    /// With `true`, the numbers differ by at most the last; with `false`, by more.
    Near(bool, Number, Number, Number, Width),
    /// The last is the number before the first update: NaN if it is not known yet.
    Changes(Number, Width, f64),
    Rises(Box<Condition>),
    Not(Box<Condition>),
    /// Whether it is true or false; never unknown itself.
    Known(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
    Eventually(Interval, Box<Condition>),
    Always(Interval, Box<Condition>),
    Once(Interval, Box<Condition>),
    Historically(Interval, Box<Condition>),
    Until(Interval, Box<Condition>, Box<Condition>),
    Since(Interval, Box<Condition>, Box<Condition>),
}

wire::tabled! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(crate) enum Comparator {
        Less = "<",
        LessOrEqual = "<=",
        Greater = ">",
        GreaterOrEqual = ">=",
        Equal = "==",
        NotEqual = "!=",
    }
    pub(crate) fn symbol() -> &'static str
}

/// How far the compared numbers can be apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Width {
    /// Their largest possible distance, in the unit of the comparison. Robustness is a share of it. 1 if unknown.
    pub(crate) range: f64,
    /// That unit, by its index among those of the formula; `None` for pure numbers.
    pub(crate) unit: Option<usize>,
}

/// Nanoseconds from now, ahead or back; without an end it reaches to the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Interval {
    pub(crate) from: i64,
    pub(crate) to: Option<i64>,
}

impl Formula {
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The signals in the formula. An update of any other signal changes nothing.
    pub fn signals(&self) -> &[Used] {
        &self.signals
    }

    /// How far it looks ahead: the truth of a moment is final this long after it.
    pub fn horizon(&self) -> Span {
        Span::from_nanos(self.condition.horizon())
    }
}

impl Condition {
    pub(crate) fn horizon(&self) -> i64 {
        match self {
            Self::Compare(..) | Self::Near(..) | Self::Changes(..) => 0,
            Self::Rises(of) | Self::Not(of) | Self::Known(of) => of.horizon(),
            Self::Once(_, of) | Self::Historically(_, of) => of.horizon(),
            Self::And(a, b) | Self::Or(a, b) | Self::Since(_, a, b) => a.horizon().max(b.horizon()),
            Self::Eventually(interval, of) | Self::Always(interval, of) => {
                interval.ahead().saturating_add(of.horizon())
            }
            Self::Until(interval, a, b) => {
                interval.ahead().saturating_add(a.horizon().max(b.horizon()))
            }
        }
    }
}

impl Interval {
    pub(crate) fn ahead(self) -> i64 {
        self.to.unwrap_or(i64::MAX)
    }
}

impl Comparator {
    pub(crate) fn truth(self, left: f64, right: f64, width: Width) -> Truth {
        let right = if distance(left, right) == 0.0 { left } else { right };
        let holds = match self {
            Self::Less => left < right,
            Self::LessOrEqual => left <= right,
            Self::Greater => left > right,
            Self::GreaterOrEqual => left >= right,
            Self::Equal => left == right,
            Self::NotEqual => left != right,
        };
        Truth::new(holds, distance(left, right) / width.range)
    }
}

/// The distance of two numbers. Equal infinities have distance zero, and so have numbers that differ by rounding alone:
/// three counts of 0.1 V are 0.30000000000000004 V.
pub(crate) fn distance(left: f64, right: f64) -> f64 {
    rounded(left, right, left.abs().max(right.abs()))
}

/// The distance of two numbers that were calculated from numbers of that size.
pub(crate) fn rounded(left: f64, right: f64, size: f64) -> f64 {
    let apart = (left - right).abs();
    if left == right || (size.is_finite() && apart <= 4.0 * f64::EPSILON * size) {
        0.0
    } else {
        apart
    }
}
