//! All slow parts of a gyro's bias and scale except noise, from step to step.

use super::effects::with_play;
use super::parameters::GyroParameters;
use super::terms::{Memory, Moment, Sums};

/// State carried from one slow step to the next: time, and the histories of temperatures.
#[derive(Debug, Clone)]
pub(super) struct Slow {
    start: State,
    end: State,
}

#[derive(Debug, Clone, PartialEq)]
struct State {
    moment: Moment,
    /// The coil's temperature with play.
    play: f64,
    memory: Memory,
}

impl Slow {
    /// A gyro with a uniform temperature.
    pub(super) fn new(parameters: &GyroParameters, celsius: f64) -> Self {
        let time_s = parameters.powered_before_s;
        let state = State {
            moment: Moment { celsius, time_s, ..Moment::default() },
            play: celsius,
            memory: Memory::new(&parameters.terms, celsius),
        };
        Self { start: state.clone(), end: state }
    }

    /// Advances by `step_s`, in which the coil goes from the first to the second temperature; returns bias and scale
    /// at both ends.
    pub(super) fn advance(
        &mut self,
        parameters: &GyroParameters,
        coil: (f64, f64),
        step_s: f64,
    ) -> [Sums; 2] {
        let kelvin_per_s = (coil.1 - coil.0) / step_s;
        self.start = self.end.clone();
        self.start.moment.celsius = coil.0;
        self.start.moment.kelvin_per_s = kelvin_per_s;
        let State { moment, play, memory } = &mut self.end;
        *moment = Moment {
            celsius: coil.1,
            kelvin_per_s,
            time_s: self.start.moment.time_s + step_s,
            ..Moment::default()
        };
        *play = with_play(*play, coil.1, parameters.hysteresis_half_width_kelvin);
        memory.advance(&parameters.terms, coil.1, step_s);
        [self.start.sums(parameters), self.end.sums(parameters)]
    }

    /// Bias and scale for the coil at `celsius`, in the steady state.
    pub(super) fn now(&self, parameters: &GyroParameters, celsius: f64) -> (f64, f64) {
        let mut state = self.end.clone();
        state.moment.celsius = celsius;
        state.moment.kelvin_per_s = 0.0;
        let sums = state.sums(parameters);
        (sums.bias, sums.scale)
    }

    /// Ends the step early, after `share` of it.
    pub(super) fn cut(&mut self, share: f64) {
        let (start, end) = (&self.start, &mut self.end);
        end.moment = between(&start.moment, &end.moment, share);
        end.play = start.play + (end.play - start.play) * share;
        end.memory = start.memory.between(&end.memory, share);
    }

    /// The true state after `share` of the step, and the sums of the fast terms there.
    pub(super) fn at(
        &self,
        parameters: &GyroParameters,
        share: f64,
        rate: f64,
        heading: f64,
    ) -> (Moment, Sums) {
        let slow = between(&self.start.moment, &self.end.moment, share);
        let moment = Moment { rate, heading, ..slow };
        if parameters.terms.is_empty() {
            return (moment, Sums::default());
        }
        let memory = self.start.memory.between(&self.end.memory, share);
        (moment, memory.sums(&parameters.terms, &moment, true))
    }
}

impl State {
    fn sums(&self, parameters: &GyroParameters) -> Sums {
        let Moment { celsius, kelvin_per_s, time_s, .. } = self.moment;
        let terms = self.memory.sums(&parameters.terms, &self.moment, false);
        Sums {
            bias: parameters.bias(celsius, kelvin_per_s)
                + parameters.slow_effects(&self.moment, self.play)
                + terms.bias,
            scale: parameters.scale(celsius) + parameters.slow_scale_effects(time_s) + terms.scale,
        }
    }
}

fn between(start: &Moment, end: &Moment, share: f64) -> Moment {
    Moment {
        celsius: start.celsius + (end.celsius - start.celsius) * share,
        time_s: start.time_s + (end.time_s - start.time_s) * share,
        ..*end
    }
}
