//! Faulty inputs that only a comparison reveals.

use super::scenario::{caught, on_can};
use controller::Mutant;
use controller::mission::Command;
use emulators::base::BaseFault;
use emulators::gyro::GyroFault;
use emulators::random::RandomStream;
use tests::rig::Rig;
use wire::time::Span;

fn chance() -> RandomStream {
    RandomStream::new(1, "device", "fault")
}

#[test]
fn a_gyro_that_has_lost_a_tenth_of_its_scale() {
    for property in ["no_silent_wrong", "done_is_done"] {
        caught(Mutant::HeadingsNotCompared, property, |mutant| {
            let mut rig = on_can(mutant);
            rig.gyro().set_parameter("scale_ppm", -100_000.0).expect("the gyro has one");
            rig.command(Rig::turn_order(90.0, 30.0));
            rig.verdicts()
        });
    }
}

#[test]
fn a_bias_that_leaps_after_its_test() {
    caught(Mutant::MovedBiasIgnored, "no_silent_wrong", |mutant| {
        let mut rig = on_can(mutant);
        let by = 400f64.to_radians() / 3_600.0;
        rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance());
        for _ in 0..8 {
            rig.command(Rig::straight_order(1.0, 0.4));
        }
        rig.verdicts()
    });
}

#[test]
fn an_odometer_that_stands_for_a_moment() {
    caught(Mutant::LaggingOdometerBelieved, "no_silent_wrong", |mutant| {
        let mut rig = on_can(mutant);
        let id = rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(4));
        let now = rig.now();
        rig.base().begin_fault(now, 0, BaseFault::StuckOdometry, chance());
        rig.run_for(Span::from_millis(420));
        let now = rig.now();
        rig.base().end_fault(now, 0);
        rig.finish(id);
        rig.verdicts()
    });
}

#[test]
fn a_base_that_rolls_on_after_a_stop() {
    caught(Mutant::StopCalledRest, "done_is_done", |mutant| {
        let mut rig = on_can(mutant);
        rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(4));
        rig.command(Command::Stop);
        // Braking takes a second.
        rig.run_for(Span::from_millis(400));
        rig.state();
        rig.run_for(Span::from_secs(2));
        rig.state();
        rig.verdicts()
    });
}
