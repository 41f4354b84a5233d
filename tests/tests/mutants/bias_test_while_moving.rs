//! A bias test is commanded while the base still turns.

use super::scenario::{caught, on_can};
use controller::Mutant;
use controller::mission::Command;
use tests::rig::Rig;
use wire::time::Span;

#[test]
fn takes_rotation_for_bias() {
    caught(Mutant::BiasTestWhileMoving, "no_silent_wrong", |mutant| {
        let mut rig = on_can(mutant);
        rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
        rig.begin(Command::Stop);
        rig.command(Rig::bias_test_order(1.0));
        rig.run_for(Span::from_secs(2));
        rig.begin_step();
        rig.command(Rig::turn_order(45.0, 30.0));
        rig.verdicts()
    });
}
