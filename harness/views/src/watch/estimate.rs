//! Estimate of a plan's remaining bench time.
//!
//! Each step has a nominal duration: what it states, or what its motion takes as prescribed. The ratio of actual to
//! nominal time of the steps so far gives the pace of this run, which scales the rest.

use plan::{Action, Plan, Step};
use std::collections::BTreeMap;
use wire::time::{Span, Timestamp};

/// The pace is used once this much nominal time is done. Assumption: a bias test.
const PACE_AFTER_S: f64 = 5.0;
/// Nominal time of a step that ends at once or takes an unknown time. Assumption.
const UNKNOWN_S: f64 = 0.0;

/// Duration of a plan, and how much of it is done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimate {
    /// Nominal seconds of each step, by its place without the round.
    steps: BTreeMap<String, f64>,
    total_s: f64,
    done_s: f64,
    /// Bench time when the last step ended.
    ended_s: f64,
    current_s: f64,
}

impl Estimate {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut estimate = Self::default();
        estimate.total_s = estimate.list("steps", &plan.steps);
        estimate
    }

    fn list(&mut self, place: &str, steps: &[Step]) -> f64 {
        let mut sum_s = 0.0;
        for (index, step) in steps.iter().enumerate() {
            let place = format!("{place}[{index}]");
            let action = &step.action;
            sum_s += match action.steps() {
                [] => {
                    let nominal = action.rest() + action.motion();
                    let is_known = nominal > Span::ZERO;
                    let nominal_s = if is_known { nominal.as_secs_f64() } else { UNKNOWN_S };
                    self.steps.insert(place, nominal_s);
                    nominal_s
                }
                within => {
                    let once_s = self.list(&format!("{place}.{}", action.name()), within);
                    let period_s = match action {
                        Action::Repeat(repeat) => repeat.period.map_or(0.0, Span::as_secs_f64),
                        _ => 0.0,
                    };
                    once_s.max(period_s) * action.repetitions() as f64
                }
            };
        }
        sum_s
    }

    fn of(&self, place: &str) -> f64 {
        let place = place.split_once(" (").map_or(place, |(place, _)| place);
        self.steps.get(place).copied().unwrap_or(UNKNOWN_S)
    }

    pub(super) fn began(&mut self, place: &str) {
        self.current_s = self.of(place);
    }

    pub(super) fn ended(&mut self, place: &str, now: Timestamp) {
        self.done_s += self.of(place);
        self.ended_s = now.as_secs_f64();
        self.current_s = 0.0;
    }

    pub const fn nominal_s(&self) -> f64 {
        self.total_s
    }

    /// Returns the remaining bench time in seconds; `None` if it is unknown.
    pub fn left_s(&self, now: Timestamp) -> Option<f64> {
        if self.total_s <= 0.0 {
            return None;
        }
        let under_way_s = (now.as_secs_f64() - self.ended_s).clamp(0.0, self.current_s);
        let left_s = (self.total_s - self.done_s - under_way_s).max(0.0);
        let pace = if self.done_s > PACE_AFTER_S { self.ended_s / self.done_s } else { 1.0 };
        Some(left_s * pace)
    }

    /// Returns the share of the plan that is done, 0 to 1.
    pub fn share(&self, now: Timestamp) -> Option<f64> {
        let left_s = self.left_s(now)?;
        let now_s = now.as_secs_f64();
        Some(if now_s + left_s > 0.0 { now_s / (now_s + left_s) } else { 0.0 })
    }
}
