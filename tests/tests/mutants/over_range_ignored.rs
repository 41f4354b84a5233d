//! A turn faster than the gyro can read.

use super::scenario::{caught, rig};
use controller::Mutant;
use emulators::base::Transport;
use tests::devices::ideal;
use tests::rig::Rig;

#[test]
fn the_turn_goes_too_far_in_silence() {
    caught(Mutant::OverRangeIgnored, "done_is_done", |mutant| {
        let mut devices = ideal(Transport::Can);
        devices.gyro.1.range_deg_per_s = 100.0;
        let mut rig = rig(&devices, mutant);
        rig.command(Rig::turn_order(1_440.0, 118.0));
        rig.verdicts()
    });
}
