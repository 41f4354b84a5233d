//! A straight line, with a pose write at its end.

use super::scenario::{caught, rig};
use controller::Mutant;
use tests::devices::{TRANSPORTS, ideal};
use tests::rig::Rig;

#[test]
fn the_base_still_creeps() {
    for transport in TRANSPORTS {
        caught(Mutant::PoseWrittenInMotion, "pose_written_at_rest", |mutant| {
            let mut rig = rig(&ideal(transport), mutant);
            rig.command(Rig::straight_order(2.0, 0.4));
            rig.verdicts()
        });
    }
}
