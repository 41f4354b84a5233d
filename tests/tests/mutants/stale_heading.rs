//! The gyro's line is cut on a straight line.

use super::scenario::{caught, rig};
use controller::Mutant;
use tests::devices::{TRANSPORTS, ideal};
use tests::rig::{Direction, Rig};
use wire::time::Span;

#[test]
fn moves_on_a_stale_heading_and_does_not_stop() {
    for transport in TRANSPORTS {
        for property in ["fresh_heading", "stops_on_loss"] {
            caught(Mutant::StaleHeading, property, |mutant| {
                let mut rig = rig(&ideal(transport), mutant);
                rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(3));
                rig.silence(Direction::GyroToController);
                rig.run_for(Span::from_secs(3));
                rig.verdicts()
            });
        }
    }
}
