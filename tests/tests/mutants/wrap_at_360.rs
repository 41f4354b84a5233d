//! Four corners, in either direction.

use super::scenario::{caught, on_can};
use controller::Mutant;
use tests::rig::Rig;

#[test]
fn a_corner_goes_the_long_way_round() {
    for corner in [-90.0, 90.0] {
        caught(Mutant::WrapAt360, "done_is_done", |mutant| {
            let mut rig = on_can(mutant);
            for _ in 0..4 {
                rig.command(Rig::turn_order(corner, 30.0));
            }
            rig.verdicts()
        });
    }
}
