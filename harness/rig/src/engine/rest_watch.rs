//! The gyro's mean rate over a window of rest.

use controller::mission::State;
use wire::units::Temperature;

#[derive(Debug, Clone, Default)]
pub(super) struct RestWatch {
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
    /// Takes a state; returns whether it is one of rest, with a gyro that is heard.
    pub(super) fn take(&mut self, state: &State) -> bool {
        let samples = state.samples.saturating_sub(self.samples.unwrap_or(state.samples));
        self.samples = Some(state.samples);
        if state.moving {
            return false;
        }
        if state.health.causes.gyro_silent {
            // What the gyro last read is not what it reads now.
            self.open();
            return false;
        }
        // Each state carries the mean since the previous one, so it is weighted by its samples.
        self.sum += state.raw_rate.deg_per_s() * samples as f64;
        self.weight += samples;
        self.temperature = state.temperature;
        true
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
}
