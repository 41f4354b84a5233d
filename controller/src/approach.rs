//! The two loops that straight lines and turns share: prescribed speed with ramps, then a loop closed on the remaining
//! distance. Metres or radians, forward only: the caller applies the direction.

use wire::time::Span;

/// Tuning of the loops, in the unit of the motion (m or rad) and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Prescribed speed.
    pub speed: f64,
    /// Ramp.
    pub acceleration: f64,
    /// Speed per remaining unit, 1/s.
    pub gain: f64,
    /// Slowest speed before arrival.
    pub creep: f64,
    /// Tolerance for arrival.
    pub tolerance: f64,
    /// Delay from a measurement to its effect.
    pub delay: Span,
}

/// The active loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loop {
    /// Prescribed speed with ramps.
    Prescribed,
    /// Closed on the remaining distance.
    Closing,
    /// Within tolerance: stopped.
    Arrived,
}

/// The state of the two loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    tuning: Tuning,
    ramp: f64,
    at: Loop,
}

impl Approach {
    /// Starts from rest.
    pub const fn new(tuning: Tuning) -> Self {
        Self { tuning, ramp: 0.0, at: Loop::Prescribed }
    }

    /// The active loop.
    pub const fn at(&self) -> Loop {
        self.at
    }

    /// Switches back to the closing loop after a stop that missed the target.
    pub const fn reopen(&mut self) {
        self.at = Loop::Closing;
        self.ramp = self.tuning.creep;
    }

    /// The speed for the next `period` on the way to a stop before the target. [`Self::speed`] goes on from there.
    pub fn hold(&mut self, acceleration: f64, period: Span) -> f64 {
        if self.at == Loop::Arrived {
            return 0.0;
        }
        self.at = Loop::Prescribed;
        self.ramp = (self.ramp - acceleration * period.as_secs_f64()).max(0.0);
        self.ramp
    }

    /// The speed for the next `period` at distance `remaining` (negative: overshot).
    pub fn speed(&mut self, remaining: f64, period: Span) -> f64 {
        let Tuning { speed, acceleration, gain, creep, tolerance, delay } = self.tuning;
        if self.at == Loop::Arrived || remaining.abs() <= tolerance {
            self.at = Loop::Arrived;
            return 0.0;
        }
        if remaining < 0.0 {
            self.at = Loop::Closing;
            return -(gain * -remaining).clamp(creep, speed.max(creep));
        }
        // Highest speed from which a brake that acts after `delay` still stops in time:
        // v delay + v^2 / 2a = remaining.
        let reaction = acceleration * delay.as_secs_f64();
        let braking = libm::sqrt(reaction * reaction + 2.0 * acceleration * remaining) - reaction;
        let closing = braking.min(gain * remaining).max(creep);
        self.ramp = (self.ramp + acceleration * period.as_secs_f64()).min(speed);
        if closing < self.ramp {
            self.at = Loop::Closing;
            self.ramp = closing;
        }
        self.ramp
    }
}

#[cfg(test)]
mod tests {
    use super::{Approach, Loop, Tuning};
    use proptest::prelude::*;
    use wire::time::Span;

    const PERIOD: Span = Span::from_millis(27);
    const TUNING: Tuning = Tuning {
        speed: 0.4,
        acceleration: 0.4,
        gain: 4.0,
        creep: 0.005,
        tolerance: 0.001,
        delay: Span::from_millis(80),
    };

    /// Simulates a plant that follows each command two periods late; returns its stopping position, top speed and
    /// largest change of speed in one period.
    fn drive(distance: f64) -> (f64, f64, f64) {
        let mut approach = Approach::new(TUNING);
        let (mut at, mut top, mut change) = (0.0, 0.0f64, 0.0f64);
        let mut commands = [0.0; 3];
        for _ in 0..10_000 {
            let speed = approach.speed(distance - at, PERIOD);
            commands.rotate_right(1);
            change = change.max((speed - commands[1]).abs());
            commands[0] = speed;
            at += commands[2] * PERIOD.as_secs_f64();
            top = top.max(speed);
            if approach.at() == Loop::Arrived && commands == [0.0; 3] {
                break;
            }
        }
        (at, top, change)
    }

    #[test]
    fn four_metres_take_the_time_of_the_paper() {
        let (at, top, _) = drive(4.0);
        assert!((at - 4.0).abs() < 0.002, "{at}");
        assert_eq!(top, 0.4);
    }

    proptest! {
        #[test]
        fn every_distance_is_met_within_two_millimetres(distance in 0.002f64..20.0) {
            let (at, top, change) = drive(distance);
            prop_assert!((at - distance).abs() <= 0.002, "{} for {}", at, distance);
            prop_assert!(top <= 0.4);
            // The ramp up never exceeds the acceleration; braking may, by the closing gain.
            prop_assert!(change <= 0.4 * 0.027 * 2.5, "{}", change);
        }
    }
}
