//! The base's messages are cut off in motion.

use super::scenario::{caught, on_can};
use controller::Mutant;
use tests::rig::{Direction, Rig};
use wire::time::Span;

#[test]
fn does_not_stop_without_the_base() {
    for order in [Rig::straight_order(4.0, 0.4), Rig::turn_order(360.0, 30.0)] {
        caught(Mutant::WatchdogOffByTen, "stops_on_loss", |mutant| {
            let mut rig = on_can(mutant);
            rig.under_way(order.clone(), Span::from_secs(3));
            rig.silence(Direction::BaseToController);
            rig.run_for(Span::from_secs(4));
            rig.verdicts()
        });
    }
}
