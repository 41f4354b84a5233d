//! The controller's states at rest: windows of mean rate, and conditions to wait for.

use controller::mission::State;
use plan::{Condition, quantities};
use std::collections::VecDeque;
use wire::time::{Span, Timestamp};
use wire::units::{AngularRate, Temperature};

/// Most states kept: 68 min at one per second.
pub const HISTORY_MAX: usize = 4_096;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Moment {
    at: Timestamp,
    rate: AngularRate,
    temperature: Option<Temperature>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct RestWatch {
    history: VecDeque<Moment>,
    samples: Option<u64>,
    /// Weighted sum of mean rates, deg/s, and the number of samples.
    sum: f64,
    weight: u64,
    temperature: Option<Temperature>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub(super) rate_deg_per_s: f64,
    pub(super) samples: u64,
    pub(super) temperature: Option<Temperature>,
}

impl RestWatch {
    /// Takes a state; one in motion clears the history.
    pub(super) fn take(&mut self, now: Timestamp, state: &State) {
        let samples = state.samples.saturating_sub(self.samples.unwrap_or(state.samples));
        self.samples = Some(state.samples);
        if state.moving {
            self.history.clear();
            return;
        }
        if state.health.causes.gyro_silent {
            // What the gyro last read is not what it reads now.
            self.history.clear();
            self.open();
            return;
        }
        if self.history.len() >= HISTORY_MAX {
            self.history.pop_front();
        }
        let moment = Moment { at: now, rate: state.raw_rate, temperature: state.temperature };
        self.history.push_back(moment);
        // Each state carries the mean since the previous one, so it is weighted by its samples.
        self.sum += state.raw_rate.deg_per_s() * samples as f64;
        self.weight += samples;
        self.temperature = state.temperature;
    }

    pub(super) fn open(&mut self) {
        self.sum = 0.0;
        self.weight = 0;
    }

    /// Ends the window; `None` if it has no sample.
    pub(super) fn close(&mut self) -> Option<Window> {
        let window = (self.weight > 0).then(|| Window {
            rate_deg_per_s: self.sum / self.weight as f64,
            samples: self.weight,
            temperature: self.temperature,
        });
        self.open();
        window
    }

    /// Whether the condition holds at the last state.
    pub(super) fn holds(&self, condition: &Condition) -> bool {
        let quantity = condition.quantity().as_str();
        let value = |moment: &Moment| {
            if quantity == quantities::GYRO_TEMPERATURE.name {
                moment.temperature.map(Temperature::celsius)
            } else {
                Some(moment.rate.deg_per_s())
            }
        };
        self.over(condition.window(), value).is_some_and(|(low, high)| condition.holds(low, high))
    }

    /// Smallest and largest value over the last `span`; `None` while the history is shorter.
    fn over(&self, span: Span, value: impl Fn(&Moment) -> Option<f64>) -> Option<(f64, f64)> {
        let from = self.history.back()?.at - span;
        let known = self.history.front()?.at <= from;
        if !known {
            return None;
        }
        let mut range: Option<(f64, f64)> = None;
        for moment in self.history.iter().rev().take_while(|moment| moment.at >= from) {
            let value = value(moment)?;
            let (low, high) = range.unwrap_or((value, value));
            range = Some((low.min(value), high.max(value)));
        }
        range
    }
}
