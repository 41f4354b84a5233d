//! A host delivers every gyro packet twice for a while.

use super::scenario::{caught, on_can};
use controller::Mutant;
use tests::rig::{Direction, Rig};
use wire::time::Span;

#[test]
fn the_turn_stops_short_in_silence() {
    caught(Mutant::RepeatedSampleCounted, "done_is_done", |mutant| {
        let mut rig = on_can(mutant);
        let id = rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
        rig.tap(Direction::GyroToController, |_, piece| vec![piece, piece]);
        rig.run_for(Span::from_secs(1));
        rig.untap(Direction::GyroToController);
        rig.finish(id);
        rig.verdicts()
    });
}
