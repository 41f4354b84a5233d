//! Default time limits of steps.
//!
//! | step | limit |
//! |---|---|
//! | at rest for a known time | that time + [`SLACK`] |
//! | motion | [`MOTION_FACTOR`] x nominal time + [`SLACK`] |
//! | lap | the same for each of its eight motions, + two absolute measurements |
//! | waiting for a condition | [`CONDITION_LIMIT`] |
//! | waiting for a reaction | [`REACTION_LIMIT`] |
//! | what a person does on a bench, each value of a sweep included | [`PERSON_LIMIT`] |
//! | a command of the bench | [`COMMAND_S_MAX`](super::bench_file::COMMAND_S_MAX), which is the most that a bench file may allow, + [`SLACK`] |
//! | settings and fits | [`SLACK`] |
//! | the controller's answer to a mission where a person takes part in the step | [`MOTION_FACTOR`] x nominal time of the step's motion + [`ANSWER_LIMIT`] |
//! | repeat, sweep | the limits of the repetitions, or their period if longer, + [`SLACK`] |

use wire::time::Span;
use wire::units::{Acceleration, AngularAcceleration};

/// Added to every limit. Assumption: communication and settling take seconds.
pub const SLACK: Span = Span::from_secs(10);
/// Factor by which motions may exceed their nominal time. Assumption: creep and corrections near the end.
pub const MOTION_FACTOR: i64 = 3;
/// Limit for a condition. Assumption: twice the two hours of the paper's warm-up.
pub const CONDITION_LIMIT: Span = Span::from_secs(4 * 3_600);
/// Limit for a reaction. Assumption: nodes that react at all do so within seconds.
pub const REACTION_LIMIT: Span = Span::from_secs(60);
/// Limit for an answer of the controller that no motion delays. Assumption: twice the longest fault that holds it up and
/// that a run survives, a host that stands still for 60 s.
pub const ANSWER_LIMIT: Span = Span::from_secs(120);
/// Limit for a person's action: placing a robot, measuring a pose, answering. Assumption.
pub const PERSON_LIMIT: Span = Span::from_secs(3_600);
/// Ramps of speed. Assumption: 0.4 m/s^2 with 15 deg/s^2 give the paper's lap of 64 s.
pub const RAMP: Acceleration = Acceleration::from_m_per_s2(0.4);
/// Ramps of turns; see [`RAMP`].
pub const TURN_RAMP: AngularAcceleration = AngularAcceleration::from_deg_per_s2(15.0);

/// Time of a motion from rest to rest over `distance` with constant speed and equal ramps, all above zero and in the
/// same base units.
pub fn trapezoid(distance: f64, speed: f64, acceleration: f64) -> Span {
    let ramps = speed * speed / acceleration;
    let seconds = if distance >= ramps {
        distance / speed + speed / acceleration
    } else {
        2.0 * (distance / acceleration).sqrt()
    };
    Span::from_secs_f64(seconds)
}

#[cfg(test)]
mod tests {
    use super::trapezoid;
    use crate::{Action, Step};
    use serde::Deserialize;
    use wire::time::Span;

    fn step(text: &str) -> Step {
        #[derive(Deserialize)]
        struct Holder {
            step: Step,
        }
        toml::from_str::<Holder>(&format!("step = {text}")).unwrap().step
    }

    fn action(text: &str) -> Action {
        step(text).action
    }

    /// A test at rest may take longer than a person, and its answer as long as it.
    #[test]
    fn answers_have_a_limit_where_a_person_has_one() {
        for (text, seconds) in [
            ("{ place = { x_m = 0, y_m = 0, heading_deg = 0 } }", Some(120)),
            ("{ lap = { direction = \"cw\" } }", Some(3 * 64 + 120)),
            ("{ lap = { direction = \"cw\" }, time_limit_s = 900 }", None),
            ("{ bias_test = { duration_s = 7200 } }", None),
            ("{ straight = { distance_m = -4 } }", None),
        ] {
            assert_eq!(step(text).answer_limit(), seconds.map(Span::from_secs), "{text}");
        }
    }

    #[test]
    fn a_move_is_a_trapezoid_or_a_triangle() {
        assert_eq!(trapezoid(4.0, 0.4, 0.4), Span::from_secs(11));
        assert_eq!(trapezoid(1.0, 1.0, 1.0), Span::from_secs(2));
        assert_eq!(trapezoid(0.25, 1.0, 1.0), Span::from_secs(1));
    }

    #[test]
    fn the_papers_motions_take_the_papers_times() {
        // 64 s of travel for a lap; 48 s for a table run of a 20 s bias test and two turns.
        let lap = action("{ lap = { direction = \"cw\" } }").motion();
        assert_eq!(lap, Span::from_secs(64));
        let turn = action("{ table_turn = { angle_deg = -360 } }").motion();
        assert_eq!(turn * 2 + Span::from_secs(20), Span::from_secs(48));
    }

    #[test]
    fn limits_follow_the_table() {
        for (text, seconds) in [
            ("{ bias_test = {} }", 30),
            ("{ wait = { duration_s = 7200 } }", 7_210),
            ("{ table_turn = { angle_deg = 360 } }", 3 * 14 + 10),
            ("{ straight = { distance_m = -4 } }", 3 * 11 + 10),
            ("{ use_calibration = \"none\" }", 10),
            ("{ repeat = { times = 3, steps = [{ bias_test = {} }] } }", 100),
            ("{ repeat = { times = 3, period_s = 60, steps = [{ bias_test = {} }] } }", 190),
            ("{ repeat = { times = 2, steps = [{ bias_test = {}, time_limit_s = 5 }] } }", 20),
        ] {
            assert_eq!(action(text).kind().limit(), Span::from_secs(seconds), "{text}");
        }
    }
}
