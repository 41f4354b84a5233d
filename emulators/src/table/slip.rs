//! Loss of steps by a stepper that is ramped too hard.

use super::profile::Profile;
use libm::{floor, round};
use wire::time::Timestamp;

/// Half steps per cycle of the windings' currents. A rotor that falls behind the field locks in again a whole number
/// of cycles later: 4 full steps, 8 half steps.
pub const STEPS_PER_ELECTRICAL_CYCLE: f64 = 8.0;

/// The rotor's response in one move.
///
/// A rotor limited to `limit` needs the distance v^2/(2 limit) to reach the rate v of a field that ramps harder; by
/// then the field has run v^2/limit - v^2/(2 ramp). The difference is lost, in whole cycles. A rotor that has not
/// caught up when the field starts to brake stalls, and all whole cycles of the move are lost (assumption). Friction
/// helps braking, which therefore loses nothing (assumption).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Slip {
    /// The rotor follows the field.
    None,
    /// It reaches the rate by itself, and is `lost` steps behind from then on.
    CatchesUp {
        /// The rotor's acceleration, chosen so that the loss is whole cycles.
        acceleration: f64,
        /// Duration of the catching up.
        duration_s: f64,
        /// Steps, unsigned.
        lost: f64,
    },
    /// It falls behind by this share of the move.
    Stalls {
        /// Whole cycles of the move in steps, over its length.
        share: f64,
    },
}

impl Slip {
    pub(super) fn of(profile: &Profile, ramp: f64, limit: f64) -> Self {
        let rate = profile.top_rate();
        if ramp <= limit || rate == 0.0 {
            return Self::None;
        }
        let lost = whole_cycles(0.5 * rate * rate * (1.0 / limit - 1.0 / ramp));
        if lost == 0.0 {
            return Self::None;
        }
        let acceleration = 1.0 / (2.0 * lost / (rate * rate) + 1.0 / ramp);
        let duration_s = rate / acceleration;
        if duration_s <= profile.brakes_after_s() {
            Self::CatchesUp { acceleration, duration_s, lost }
        } else {
            Self::Stalls { share: whole_cycles(profile.length()) / profile.length() }
        }
    }

    /// Steps that the rotor is behind at `now`, unsigned.
    pub(super) fn behind(&self, profile: &Profile, now: Timestamp) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::CatchesUp { acceleration, duration_s, lost } => {
                let t = profile.elapsed_s(now);
                if t < duration_s {
                    (profile.commanded(now) - 0.5 * acceleration * t * t).max(0.0)
                } else {
                    lost
                }
            }
            Self::Stalls { share } => profile.commanded(now) * share,
        }
    }

    /// Steps, in whole cycles, that the rotor is behind when it locks in at `now`, after the end of the move,
    /// completed or aborted.
    pub(super) fn locked_in(&self, profile: &Profile, now: Timestamp) -> f64 {
        let cycles = self.behind(profile, now) / STEPS_PER_ELECTRICAL_CYCLE;
        round(cycles) * STEPS_PER_ELECTRICAL_CYCLE
    }
}

fn whole_cycles(steps: f64) -> f64 {
    floor(steps / STEPS_PER_ELECTRICAL_CYCLE) * STEPS_PER_ELECTRICAL_CYCLE
}

#[cfg(test)]
mod tests {
    use super::{Profile, Slip};
    use proptest::prelude::*;
    use wire::time::{Span, Timestamp};

    fn slip(distance: f64, rate: f64, ramp: f64, limit: f64) -> (Profile, Slip) {
        let profile = Profile::new(Timestamp::ZERO, 0.0, distance, rate, ramp);
        (profile, Slip::of(&profile, ramp, limit))
    }

    #[test]
    fn a_ramp_within_the_limit_loses_nothing() {
        assert_eq!(slip(28_800.0, 2_400.0, 1_200.0, 1_200.0).1, Slip::None);
        assert_eq!(slip(28_800.0, 2_400.0, 1e9, f64::INFINITY).1, Slip::None);
        // A hundredth of a cycle too fast costs no cycle.
        assert_eq!(slip(28_800.0, 2_400.0, 1_200.03, 1_200.0).1, Slip::None);
    }

    #[test]
    fn twice_the_ramp_loses_half_the_way_of_the_slow_one() {
        let (profile, slip) = slip(-28_800.0, 2_400.0, 2_400.0, 1_200.0);
        // 2400^2/2 (1/1200 - 1/2400) = 1200 steps, 150 cycles.
        assert_eq!(slip.locked_in(&profile, profile.end()), 1_200.0);
        assert_eq!(slip.behind(&profile, Timestamp::from_secs_f64(1.0)), 1_200.0 - 600.0);
    }

    #[test]
    fn a_short_hard_move_stalls() {
        let (profile, slip) = slip(803.0, 2_400.0, 24_000.0, 1_200.0);
        assert_eq!(slip.locked_in(&profile, profile.end()), 800.0);
    }

    proptest! {
        #[test]
        fn the_rotor_only_goes_forward_and_never_ahead_of_the_field(
            distance in 1i32..50_000, rate in 1f64..5_000.0, ramp in 1f64..10_000.0,
            limit in 1f64..10_000.0, share in 0f64..1.0,
        ) {
            let (profile, slip) = slip(distance.into(), rate, ramp, limit);
            let now = Timestamp::from_secs_f64(profile.end().as_secs_f64() * share);
            let later = now + Span::from_millis(1);
            let rotor = |at| profile.commanded(at) - slip.behind(&profile, at);
            prop_assert!(rotor(now) >= -1e-6 && slip.behind(&profile, now) >= 0.0);
            prop_assert!(rotor(later) >= rotor(now) - 1e-6);
            prop_assert_eq!(slip.locked_in(&profile, profile.end()) % 8.0, 0.0);
            let unlocked = slip.behind(&profile, profile.end());
            prop_assert!((unlocked - slip.locked_in(&profile, profile.end())).abs() < 1e-6);
        }
    }
}
