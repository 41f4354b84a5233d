//! Sixty milliseconds of gyro samples are lost in a turn: too short for a silence.

use super::scenario::{caught, on_can};
use controller::Mutant;
use tests::rig::{Direction, Rig};
use wire::time::Span;

#[test]
fn the_turn_goes_too_far_in_silence() {
    for property in ["done_is_done", "no_silent_wrong"] {
        caught(Mutant::MissedSequenceGap, property, |mutant| {
            let mut rig = on_can(mutant);
            let id = rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
            rig.silence(Direction::GyroToController);
            rig.run_for(Span::from_millis(60));
            rig.untap(Direction::GyroToController);
            rig.finish(id);
            rig.verdicts()
        });
    }
}
