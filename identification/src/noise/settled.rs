//! When the covariance of a filter has settled: from then on, observations that are alike share their gains.

use super::innovations::STATES_MAX;

/// Inputs that determine the covariance after an observation, besides the previous covariance.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Inputs {
    pub step: f64,
    pub activity: f64,
    pub seen: f64,
    pub own: f64,
    pub new_run: bool,
}

/// The previous observation: once the covariance has settled, the next has the same gains.
#[derive(Default)]
pub(super) struct Last {
    pub inputs: Option<Inputs>,
    pub which: u32,
    pub weight: f64,
    pub log_variance: f64,
    pub is_settled: bool,
}

/// Time steps that differ by less than this share are equal: the rest is rounding.
const STEP_EQUAL: f64 = 1e-9;
/// The covariance has settled once an observation changes it by less than this share.
const SETTLED: f64 = 1e-14;

impl Last {
    pub fn is_like(&self, now: &Inputs) -> bool {
        self.inputs.is_some_and(|last| {
            let steps_equal = (now.step - last.step).abs() <= STEP_EQUAL * last.step;
            steps_equal && Inputs { step: last.step, ..*now } == last
        })
    }

    pub fn repeats(&self, now: &Inputs) -> bool {
        self.is_settled && self.is_like(now)
    }
}

pub(super) fn has_settled(
    before: &[[f64; STATES_MAX]; STATES_MAX],
    after: &[[f64; STATES_MAX]; STATES_MAX],
) -> bool {
    let pairs = before.iter().flatten().zip(after.iter().flatten());
    pairs.into_iter().all(|(before, after)| (before - after).abs() <= SETTLED * after.abs())
}
