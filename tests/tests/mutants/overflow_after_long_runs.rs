//! As much turning as sixty laps in the same direction.

use super::scenario::{caught, on_can};
use controller::Mutant;
use tests::rig::Rig;

#[test]
fn the_sixtieth_turn_is_the_wrong_one() {
    caught(Mutant::OverflowAfterLongRuns, "no_silent_wrong", |mutant| {
        let mut rig = on_can(mutant);
        for _ in 0..60 {
            rig.command(Rig::turn_order(360.0, 100.0));
        }
        rig.verdicts()
    });
}
