//! Faults of its inputs that the controller detects, and no false alarms without faults.

use controller::calibration::{Calibration, Factor};
use controller::config::IntegrationClock;
use controller::health::Level;
use controller::mission::{AbortReason, BiasTest, Command};
use emulators::base::{BaseFault, Transport};
use emulators::device_file::{Devices, Mount};
use emulators::gyro::GyroFault;
use emulators::random::RandomStream;
use tests::devices::shipped;
use tests::rig::{Answer, Rig};
use wire::gyro::{GyroFormat, GyroStream, OutputMode};
use wire::time::Span;

/// Each shipped gyro on the paper's robot, with every stream that it supports, on the host's clock.
fn healthy() -> Vec<Devices> {
    let modes = [OutputMode::Rate, OutputMode::Increment, OutputMode::Integrated];
    let mut all = Vec::new();
    for gyro in ["paper-table", "dsp3000-table", "undeclared-table"] {
        for format in GyroFormat::ALL {
            for mode in modes.into_iter().filter(|mode| format.carries(*mode)) {
                for transport in [Transport::Can, Transport::Serial] {
                    let mut devices = shipped("paper");
                    let mut parameters = shipped(gyro).gyro.1;
                    // Warm, as in the paper's laps, and calibrated.
                    parameters.powered_before_s = 7_200.0;
                    parameters.scale_ppm_per_kelvin = 0.0;
                    let stream = GyroStream { format, mode, reversed: false };
                    devices.gyro = (stream, parameters);
                    devices.mount = Mount::Base;
                    if let Some((way, _)) = &mut devices.base {
                        *way = transport;
                    }
                    all.push(devices);
                }
            }
        }
    }
    all
}

/// By the host's clock, a wrong gyro clock does not affect rates.
fn ready(devices: &Devices, seed: u64) -> Rig {
    let mut rig = Rig::with_config(devices, seed, |config| {
        config.gyro.clock = IntegrationClock::HostTime;
    });
    rig.run_for(Span::from_secs(2));
    rig.bias_test(20.0);
    rig.set_pose();
    rig
}

/// The paper's robot, warmed up.
fn warm() -> Devices {
    let mut devices = shipped("paper");
    devices.gyro.1.powered_before_s = 7_200.0;
    devices
}

fn drive_lap(rig: &mut Rig, way: f64) {
    for _ in 0..4 {
        rig.straight(4.0, 0.4);
        rig.turn(90.0 * way, 30.0);
    }
}

#[test]
fn nothing_is_noticed_of_a_healthy_lap_whatever_the_stream() {
    for (seed, devices) in (1..).zip(healthy()) {
        let mut rig = ready(&devices, seed);
        for way in [1.0, -1.0] {
            drive_lap(&mut rig, way);
            // As long as a person takes to measure.
            rig.run_for(Span::from_secs(60));
        }
        let bad: Vec<_> =
            rig.health_changes().iter().filter(|(_, health)| health.level > Level::Ok).collect();
        let after_start = bad.iter().filter(|(at, _)| at.as_secs_f64() > 25.0);
        assert_eq!(after_start.count(), 0, "{:?} {seed}: {bad:?}", devices.gyro.0);
    }
}

fn chance() -> RandomStream {
    RandomStream::new(1, "gyro", "fault")
}

/// Time from the begin of a fault to its detection, s.
fn word_of(rig: &mut Rig, limit_s: f64, said: fn(&mut Rig) -> bool) -> Option<f64> {
    let since = rig.now();
    rig.run_until(Span::from_secs_f64(limit_s), said).then(|| (rig.now() - since).as_secs_f64())
}

#[test]
fn a_gyro_that_is_stuck_in_a_turn_stops_the_base_at_once() {
    for devices in healthy() {
        let mut rig = ready(&devices, 1);
        let id = rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
        rig.gyro().begin_fault(0, GyroFault::Stuck, chance());
        let took = word_of(&mut rig, 1.0, |rig| rig.health().causes.gyro_fault);
        assert!(took.is_some_and(|s| s <= 0.15), "{:?}: {took:?}", devices.gyro.0);
        assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::GyroFault));
        rig.gyro().end_fault(0);
        rig.run_for(Span::from_secs(1));
        assert!(rig.health().causes.gyro_invalid, "what it did not see stays lost");
    }
}

#[test]
fn a_gyro_that_sticks_during_its_bias_test_fails_it() {
    for devices in healthy() {
        for ahead_s in [2, 10, 19] {
            let mut rig = Rig::new(&devices, 1);
            rig.run_for(Span::from_secs(2));
            let test = Command::BiasTest(BiasTest { duration_s: 20.0 });
            let id = rig.under_way(test, Span::from_secs(ahead_s));
            rig.gyro().begin_fault(0, GyroFault::Stuck, chance());
            let answer = rig.finish(id);
            // The stuck reading may also be far from the mean.
            let reason = match answer {
                Answer::Aborted(reason) => reason,
                other => panic!("{:?}, after {ahead_s} s: {other:?}", devices.gyro.0),
            };
            assert!(matches!(reason, AbortReason::GyroFault | AbortReason::NotAtRest));
            assert!(rig.health().level > Level::Ok);
        }
    }
}

#[test]
fn a_gyro_that_sticks_throughout_its_bias_test_shows_at_the_first_standstill_after_it() {
    for devices in healthy() {
        let mut rig = Rig::with_config(&devices, 1, |config| {
            config.gyro.clock = IntegrationClock::HostTime;
        });
        rig.run_for(Span::from_secs(2));
        rig.gyro().begin_fault(0, GyroFault::Stuck, chance());
        rig.bias_test(20.0);
        rig.set_pose();
        assert_eq!(rig.health().level, Level::Ok, "it may be a gyro without noise");
        rig.gyro().end_fault(0);
        rig.straight(1.0, 0.4);
        rig.straight(1.0, 0.4);
        assert!(rig.health().causes.bias_moved, "{:?}", devices.gyro.0);
    }
}

#[test]
fn an_odometer_that_stands_for_a_moment_on_the_way_shows() {
    for seed in 1..=20 {
        let mut rig = ready(&shipped("paper"), seed);
        let ahead = Span::from_millis(2_000 + 137 * seed as i64);
        rig.under_way(Rig::straight_order(4.0, 0.4), ahead);
        let now = rig.now();
        rig.base().begin_fault(now, 0, BaseFault::StuckOdometry, chance());
        rig.run_for(Span::from_millis(350));
        assert!(rig.health().causes.odometry_doubtful, "seed {seed}");
    }
}

/// Found by a campaign: the base stopped by itself, and so nothing said how far it should have gone.
#[test]
fn an_odometer_that_stands_while_a_base_that_refuses_orders_brakes_shows() {
    for seed in 1..=20 {
        let mut rig = ready(&shipped("paper"), seed);
        rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_millis(2_100));
        let now = rig.now();
        rig.base().begin_fault(now, 0, BaseFault::RefuseCommands, chance());
        rig.run_for(Span::from_millis(650));
        let now = rig.now();
        rig.base().end_fault(now, 0);
        rig.base().begin_fault(now, 1, BaseFault::StuckOdometry, chance());
        rig.run_for(Span::from_millis(400));
        assert!(rig.health().causes.odometry_doubtful, "seed {seed}");
    }
}

/// Found by a campaign: the base heard no order from there on, and went 0.2 m.
#[test]
fn an_odometer_that_does_not_begin_to_count_shows_within_half_a_second() {
    for seed in 1..=20 {
        let mut rig = ready(&shipped("paper"), seed);
        let now = rig.now();
        rig.base().begin_fault(now, 0, BaseFault::StuckOdometry, chance());
        rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_millis(500));
        assert!(rig.health().causes.odometry_doubtful, "seed {seed}");
    }
}

/// Found by a campaign: both said that the base stood, and so they agreed.
#[test]
fn a_turn_that_neither_gyro_nor_odometry_shows_is_not_what_was_ordered() {
    for devices in healthy() {
        let mut rig = Rig::new(&devices, 1);
        rig.run_for(Span::from_secs(2));
        rig.gyro().begin_fault(0, GyroFault::Stuck, chance());
        rig.bias_test(20.0);
        rig.set_pose();
        let now = rig.now();
        rig.base().begin_fault(now, 1, BaseFault::StuckOdometry, chance());
        rig.under_way(Rig::turn_order(90.0, 30.0), Span::from_secs(1));
        assert!(rig.health().causes.odometry_doubtful, "{:?}", devices.gyro.0);
    }
}

#[test]
fn a_bias_that_leaps_after_its_test_shows_at_the_next_standstill() {
    for seed in 1..=20 {
        let mut rig = ready(&shipped("paper"), seed);
        let by = 400f64.to_radians() / 3_600.0;
        rig.straight(1.0, 0.4);
        rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance());
        rig.straight(1.0, 0.4);
        rig.turn(90.0, 30.0);
        assert!(rig.health().causes.bias_moved, "seed {seed}");
        rig.bias_test(20.0);
        assert!(rig.health().causes.bias_moved, "no test finds what it has turned the heading by");
        rig.set_pose();
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
        rig.gyro().end_fault(0);
        rig.run_for(Span::from_secs(1));
        rig.set_pose();
        assert!(rig.health().causes.bias_moved, "the bias in use is not the gyro's");
        rig.bias_test(20.0);
        assert_eq!(rig.health().level, Level::Ok, "it stood since the pose was set");
    }
}

/// What the filter beside the paper's method knew of the heading is lost with it.
#[test]
fn a_filter_that_watches_and_fails_says_so_until_a_pose_is_set() {
    let mut rig = ready(&warm(), 5);
    rig.bias_test(20.0);
    rig.set_pose();
    rig.straight(1.0, 0.4);
    let by = 2_000f64.to_radians() / 3_600.0;
    rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance());
    rig.run_for(Span::from_secs(30));
    let causes = rig.health().causes;
    assert!(causes.estimator_failed && causes.bias_moved, "{causes:?}");
    rig.gyro().end_fault(0);
    rig.bias_test(20.0);
    assert!(rig.health().causes.estimator_failed, "a bias test forgives nothing");
    rig.set_pose();
    assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health().causes);
}

/// Found by campaigns: no single standstill shows it for certain, and no comparison of one turn. It is a matter of statistics:
/// what is off by 1 deg is known to within 0.1 deg or so.
#[test]
fn a_small_bias_that_lasts_shows_by_what_it_turned() {
    let mut noticed = 0;
    for seed in 1..=40 {
        let mut rig = ready(&warm(), seed);
        let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
        let factors = [line].into_iter().collect();
        rig.command(Command::SetCalibration(Calibration { factors, ..Calibration::default() }));
        let by = 80f64.to_radians() / 3_600.0;
        rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance());
        drive_lap(&mut rig, 1.0);
        let off_deg = (rig.state().pose.heading - rig.heading()).deg();
        assert!(off_deg > 1.0, "seed {seed}: {off_deg}");
        rig.run_for(Span::from_secs(1));
        noticed += u32::from(rig.health().causes.bias_moved);
    }
    assert!(noticed >= 36, "{noticed} of 40");
}

/// Found by campaigns: the turn may be off by 3.3 deg for a base that is not known, but this one turned before.
#[test]
fn a_leap_that_is_gone_before_the_standstill_shows_once_the_base_is_known() {
    for seed in 1..=20 {
        let mut rig = ready(&warm(), seed);
        for _ in 0..2 {
            rig.straight(4.0, 0.4);
            rig.turn(90.0, 30.0);
        }
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
        let id = rig.under_way(Rig::turn_order(90.0, 30.0), Span::from_secs(1));
        let by = 4_000f64.to_radians() / 3_600.0;
        rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance());
        rig.run_for(Span::from_secs(2));
        rig.gyro().end_fault(0);
        assert!(matches!(rig.finish(id), Answer::Done(_)));
        rig.run_for(Span::from_millis(300));
        assert!(rig.health().causes.headings_disagree, "seed {seed}: {:?}", rig.health());
    }
}

#[test]
fn a_temperature_that_is_wild_or_frozen_while_it_warms_up_shows() {
    let warming = |fault| {
        let mut devices = shipped("paper");
        devices.gyro.1.powered_before_s = 0.0;
        let mut rig = Rig::new(&devices, 1);
        rig.run_for(Span::from_secs(2));
        rig.bias_test(20.0);
        rig.gyro().begin_fault(0, fault, chance());
        rig
    };
    let doubtful = |rig: &mut Rig| rig.health().causes.temperature_doubtful;
    let mut wild = warming(GyroFault::TemperatureWild { rms_kelvin: 3.0 });
    let took = word_of(&mut wild, 60.0, doubtful);
    assert!(took.is_some_and(|s| s <= 10.0), "{took:?}");
    let mut frozen = warming(GyroFault::TemperatureFrozen);
    let took = word_of(&mut frozen, 400.0, doubtful);
    // It had warmed by a step of its sensor in some seconds.
    assert!(took.is_some_and(|s| (20.0..=60.0).contains(&s)), "{took:?}");
    frozen.set_pose();
    assert!(frozen.health().causes.temperature_doubtful, "it is frozen still");
    frozen.gyro().end_fault(0);
    frozen.run_for(Span::from_secs(2));
    frozen.command(Command::SetPose(wire::units::Pose::default()));
    assert!(!frozen.health().causes.temperature_doubtful);
}
