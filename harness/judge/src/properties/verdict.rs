//! The result of a property, and its margin.

use plan::Kind;
use record::Violation;
use record::outcome::PropertySummary;
use serde::Serialize;
use wire::time::Timestamp;

/// The result of one property in one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PropertyVerdict {
    /// Name, as in a plan.
    pub name: String,
    /// Kind of property.
    pub kind: Kind,
    /// Always: it was never violated. Sometimes: it occurred.
    pub held: bool,
    /// The first violation of an always-property.
    pub first_violation: Option<Violation>,
    /// What was missing, for a property that did not hold because the run had nothing to judge it by. A fault of the bus
    /// cannot violate it in this way.
    pub never_judged: Option<Missing>,
    /// Robustness, as in the falsification of signal temporal logic: the smallest distance to a violation in the run as
    /// a share of the limit, from 1 (far) over 0 (at the limit) to -1. `None` if there was nothing to judge, and for
    /// sometimes-properties.
    pub margin: Option<f64>,
    /// For a held formula `a -> b`: the text of `a`, if it was true at no moment at which `b` was known.
    pub never_asked: Option<String>,
}

/// What a property lacked to be judged by.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Since when it was missing, and until when it would have been in time.
    pub span: (Timestamp, Timestamp),
    /// What was missing.
    pub what: String,
}

/// What a sometimes-property comes to that did not occur.
pub(super) const NEVER: &str = "never reached";

impl From<&PropertyVerdict> for PropertySummary {
    fn from(verdict: &PropertyVerdict) -> Self {
        let violation = verdict.first_violation.as_ref();
        Self {
            name: verdict.name.clone(),
            always: verdict.kind == Kind::Always,
            held: Some(verdict.held),
            not_judged: None,
            margin: verdict.margin,
            never_asked: verdict.never_asked.clone(),
            broken_s: violation.map(|violation| violation.at.as_secs_f64()),
            what: violation
                .map(|violation| &violation.what)
                .or_else(|| verdict.never_judged.as_ref().map(|missing| &missing.what))
                .cloned()
                .or_else(|| (!verdict.held).then(|| NEVER.to_owned())),
        }
    }
}

/// The smallest margin so far, and the first violation.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Judgement {
    margin: Option<f64>,
    first_violation: Option<Violation>,
}

impl Judgement {
    /// Takes a margin; if it is negative, `what` describes the observation. NaN is a violation.
    pub(super) fn take(&mut self, at: Timestamp, margin: f64, what: impl FnOnce() -> String) {
        let margin = if margin.is_nan() { -1.0 } else { margin.clamp(-1.0, 1.0) };
        if margin < 0.0 && self.first_violation.is_none() {
            self.first_violation = Some(Violation { at, what: what() });
        }
        self.margin = Some(self.margin.map_or(margin, |least| least.min(margin)));
    }

    /// What was hidden explains the first violation.
    pub(super) fn is_explained(&mut self, hidden: &str) {
        if let Some(violation) = &mut self.first_violation {
            violation.what += &format!("; under {hidden}, which no input of the controller shows");
        }
    }

    /// The first violation is that of another judgement.
    pub(super) fn take_violation(&mut self, of: &Self) {
        self.first_violation.clone_from(&of.first_violation);
    }

    /// The first violation.
    pub(super) const fn first_violation(&self) -> Option<&Violation> {
        self.first_violation.as_ref()
    }

    /// The verdict on the always-property `name`.
    pub(super) fn verdict(self, name: &str) -> PropertyVerdict {
        PropertyVerdict {
            name: name.to_owned(),
            kind: Kind::Always,
            held: self.first_violation.is_none(),
            first_violation: self.first_violation,
            never_judged: None,
            margin: self.margin,
            never_asked: None,
        }
    }
}

/// Distance of `value` from `limit` as a share of it; both are magnitudes.
pub(super) fn below(value: f64, limit: f64) -> f64 {
    1.0 - value / limit
}

#[cfg(test)]
mod tests {
    use super::{Judgement, Timestamp, below};

    #[test]
    fn the_least_margin_and_the_first_violation_stay() {
        let mut judgement = Judgement::default();
        for (second, value) in [(1, 0.5), (2, 1.5), (3, 1.2), (4, 0.1)] {
            let at = Timestamp::from_nanos(second);
            judgement.take(at, below(value, 1.0), || format!("{value}"));
        }
        let verdict = judgement.verdict("x");
        assert_eq!((verdict.held, verdict.margin), (false, Some(-0.5)));
        assert_eq!(verdict.first_violation.unwrap().what, "1.5");
    }

    #[test]
    fn no_number_is_a_violation_and_nothing_to_judge_is_none() {
        let mut judgement = Judgement::default();
        judgement.take(Timestamp::ZERO, f64::NAN, || "nan".into());
        assert_eq!(judgement.verdict("x").margin, Some(-1.0));
        let empty = Judgement::default().verdict("x");
        assert_eq!((empty.held, empty.margin), (true, None));
    }
}
