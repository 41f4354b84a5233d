//! Checks whether the base could have turned like that from one sample to the next.
//!
//! A one-byte checksum lets one corrupted frame in 256 pass, with an arbitrary rate. A reading that no base could have
//! reached since the previous one is dropped and bridged like an invalid one, unless the next reading confirms it:
//! then the base was pushed.

use wire::gyro::GyroOutput;
use wire::time::{Span, Timestamp};
use wire::units::{AngularAcceleration, AngularRate};

/// Largest acceleration of a base. Assumption: twice the 120 deg/s^2 assumed as the steering limit of a K2A of 125 kg.
const ACCELERATION_MAX: AngularAcceleration = AngularAcceleration::from_deg_per_s2(240.0);
/// Allowance for noise. Assumption: ten times the largest spread at which a bias test calls a gyro at rest.
const NOISE_MAX: AngularRate = AngularRate::from_deg_per_s(0.5);

/// Rate limit for integrated angles, which include the time between two samples. Assumption: twice the K2A's top rate
/// of 120 deg/s.
const RATE_MAX: AngularRate = AngularRate::from_deg_per_s(240.0);

/// Checks each sample before it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JumpGate {
    period: Span,
    credible: Option<Seen>,
    doubtful: Option<Seen>,
}

type Seen = (Timestamp, GyroOutput);

impl JumpGate {
    pub(crate) const fn new(period: Span) -> Self {
        Self { period, credible: None, doubtful: None }
    }

    /// Restarts after a gap of unknown content.
    pub(crate) const fn restart(&mut self) {
        self.credible = None;
        self.doubtful = None;
    }

    /// True if a gyro on a base could read this at `now`.
    pub(crate) fn believes(&mut self, now: Timestamp, output: GyroOutput) -> bool {
        let seen = (now, output);
        let follows = |before: Option<Seen>| before.is_some_and(|b| self.could_follow(b, seen));
        let believed = self.credible.is_none() || follows(self.credible) || follows(self.doubtful);
        if believed {
            (self.credible, self.doubtful) = (Some(seen), None);
        } else {
            self.doubtful = Some(seen);
        }
        believed
    }

    fn could_follow(&self, (at, from): Seen, (now, to): Seen) -> bool {
        // Samples that arrive in bunches seem simultaneous.
        let passed = (now - at).max(self.period);
        let differs_by = || NOISE_MAX + ACCELERATION_MAX * passed;
        match (from, to) {
            (GyroOutput::Rate(from), GyroOutput::Rate(to)) => {
                let differs = (to - from).abs();
                // The usual case takes no division.
                differs <= NOISE_MAX || differs <= differs_by()
            }
            (GyroOutput::Increment(from), GyroOutput::Increment(to)) => {
                (to - from).abs() <= differs_by() * self.period
            }
            (GyroOutput::Integrated(from), GyroOutput::Integrated(to)) => {
                (to - from).wrapped().abs() <= RATE_MAX * (passed + self.period)
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{GyroOutput, JumpGate, Span, Timestamp};
    use proptest::prelude::*;
    use wire::units::{Angle, AngularRate};

    fn believes(gate: &mut JumpGate, n: i64, deg_per_s: f64) -> bool {
        let now = Timestamp::ZERO + Span::from_millis(10) * n;
        gate.believes(now, GyroOutput::Rate(AngularRate::from_deg_per_s(deg_per_s)))
    }

    #[test]
    fn one_jump_is_let_go_and_two_are_a_push() {
        let mut gate = JumpGate::new(Span::from_millis(10));
        assert!(believes(&mut gate, 0, 30.0));
        assert!(!believes(&mut gate, 1, -71.0));
        assert!(believes(&mut gate, 2, 30.1), "as if it had not been");
        assert!(!believes(&mut gate, 3, 40.0) && !believes(&mut gate, 4, 90.0));
        assert!(believes(&mut gate, 5, 30.0));
        assert!(!believes(&mut gate, 6, 60.0) && believes(&mut gate, 7, 59.0), "a push");
    }

    #[test]
    fn increments_and_angles_are_gated_as_well() {
        let period = Span::from_millis(10);
        let forms: [fn(f64) -> GyroOutput; 2] = [
            |deg| GyroOutput::Increment(Angle::from_deg(deg)),
            |deg| GyroOutput::Integrated(Angle::from_deg(deg)),
        ];
        for form in forms {
            let mut gate = JumpGate::new(period);
            let mut believes =
                |n, deg| gate.believes(Timestamp::ZERO + period * i64::from(n), form(deg));
            assert!(believes(0, 0.3) && !believes(1, 90.0) && believes(2, 0.31));
        }
    }

    proptest! {
        #[test]
        fn a_base_within_its_limits_is_believed_however_late_it_is_heard(
            steps in prop::collection::vec((-1.2f64..1.2, 0i64..100), 1..300),
        ) {
            let mut gate = JumpGate::new(Span::from_millis(10));
            let (mut rate, mut angle, mut arrived) = (0.0, 0.0, Timestamp::ZERO);
            let mut integrated = gate;
            for (n, (step, late_ms)) in steps.into_iter().enumerate() {
                rate = f64::clamp(rate + step, -120.0, 120.0);
                angle += rate * 0.01;
                let due = Timestamp::ZERO + Span::from_millis(10 * n as i64);
                arrived = arrived.max(due + Span::from_millis(late_ms));
                let output = GyroOutput::Rate(AngularRate::from_deg_per_s(rate));
                prop_assert!(gate.believes(arrived, output));
                let output = GyroOutput::Integrated(Angle::from_deg(angle).wrapped());
                prop_assert!(integrated.believes(arrived, output));
            }
        }
    }
}
