//! The Kalman filter compared with the paper's method, on the paper's robot: the error of heading and position that a
//! lap adds, and whether the filter's uncertainty covers it.
//!
//! `cargo test --release -p tests --test scenarios estimators -- --ignored --nocapture` prints the table of 3,000 laps.

use controller::calibration::{Calibration, Factor};
use controller::health::Level;
use controller::mission::{AbortReason, Command, Estimator, MissionResult, Uncertainty};
use emulators::device_file::Devices;
use emulators::gyro::GyroFault;
use emulators::random::RandomStream;
use tests::devices::{TRANSPORTS, ideal, shipped};
use tests::rig::{Answer, Direction, Rig};
use wire::device::Transmit;
use wire::packet::Packet;
use wire::time::Span;
use wire::units::{Angle, Length};

/// Errors added by a lap.
#[derive(Debug, Clone, Copy)]
struct Lap {
    heading_deg: f64,
    x_mm: f64,
    y_mm: f64,
    /// Standard deviations that the filter reports.
    says: Option<Uncertainty>,
}

/// The paper's robot, warmed up, calibrated with the paper's own line of Eq. 5.
fn warm() -> Devices {
    let mut devices = shipped("paper");
    devices.gyro.1.powered_before_s = 7_200.0;
    devices
}

fn ready(devices: &Devices, estimator: Estimator, seed: u64) -> Rig {
    let mut rig = Rig::new(devices, seed);
    rig.run_for(Span::from_secs(2));
    let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
    let factors = [line].into_iter().collect();
    rig.command(Command::SetCalibration(Calibration { factors, ..Calibration::default() }));
    rig.command(Command::SetEstimator(estimator));
    rig
}

/// Drives bias test, pose, and once around the paper's square.
fn lap(rig: &mut Rig, way: f64) -> Lap {
    rig.bias_test(20.0);
    rig.set_pose();
    let before = rig.truth().pose;
    for _ in 0..4 {
        rig.straight(4.0, 0.4);
        rig.turn(90.0 * way, 30.0);
    }
    // The standstill after the last turn counts too.
    rig.run_for(Span::from_millis(300));
    let after = rig.truth().pose;
    let state = rig.state();
    let (x, y) = ((after.x - before.x).m(), (after.y - before.y).m());
    let (sin, cos) = (before.heading.sin(), before.heading.cos());
    Lap {
        heading_deg: (state.pose.heading - (after.heading - before.heading)).wrapped().deg(),
        x_mm: (state.pose.x.m() - (x * cos + y * sin)) * 1e3,
        y_mm: (state.pose.y.m() - (y * cos - x * sin)) * 1e3,
        says: state.uncertainty,
    }
}

/// Drives ten laps on each robot, in alternating directions.
fn laps(estimator: Estimator, seeds: std::ops::Range<u64>) -> Vec<Lap> {
    let mut all = Vec::new();
    for seed in seeds {
        let mut rig = ready(&warm(), estimator, seed);
        for n in 0..10 {
            all.push(lap(&mut rig, if n % 2 == 0 { 1.0 } else { -1.0 }));
            assert!(rig.health().level == Level::Ok, "{seed}, {n}: {:?}", rig.health());
        }
    }
    all
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

fn heading_rms(laps: &[Lap]) -> f64 {
    rms(laps.iter().map(|lap| lap.heading_deg))
}

fn position_rms(laps: &[Lap]) -> f64 {
    rms(laps.iter().map(|lap| lap.x_mm.hypot(lap.y_mm)))
}

/// Share of the laps whose error is within 1.96 of the filter's own standard deviations.
fn covered(laps: &[Lap], error: fn(&Lap) -> f64, says: fn(Uncertainty) -> f64) -> f64 {
    let within = laps.iter().filter(|lap| {
        lap.says.is_some_and(|deviations| error(lap).abs() <= 1.96 * says(deviations))
    });
    within.count() as f64 / laps.len() as f64
}

#[test]
#[ignore = "3,000 laps twice, minutes"]
fn three_thousand_laps_each_way() {
    println!("| estimator | heading rms, deg | position rms, mm | heading within 95 % | x | y |");
    println!("|---|---|---|---|---|---|");
    for estimator in [Estimator::Paper, Estimator::Kalman] {
        let laps = laps(estimator, 1..301);
        let heading = covered(&laps, |lap| lap.heading_deg, |says| says.heading.deg()) * 100.0;
        let x = covered(&laps, |lap| lap.x_mm, |says| says.x.m() * 1e3) * 100.0;
        let y = covered(&laps, |lap| lap.y_mm, |says| says.y.m() * 1e3) * 100.0;
        let (by, at) = (heading_rms(&laps), position_rms(&laps));
        println!("| {estimator:?} | {by:.3} | {at:.1} | {heading:.1} % | {x:.1} % | {y:.1} % |");
    }
}

#[test]
fn standstills_more_than_halve_the_error_of_a_lap() {
    let paper = laps(Estimator::Paper, 1001..1005);
    let kalman = laps(Estimator::Kalman, 1001..1005);
    let (worse, better) = (heading_rms(&paper), heading_rms(&kalman));
    // 40 laps each, with the same noise: an rms of 40 is accurate to 11 %.
    assert!(better < 0.6 * worse, "{better} deg against {worse}");
    assert!(position_rms(&kalman) < 0.6 * position_rms(&paper));
}

fn heading_error_deg(rig: &mut Rig) -> f64 {
    (rig.state().pose.heading - rig.heading()).deg().abs()
}

#[test]
fn a_line_that_is_gone_for_seconds_is_bridged_and_said() {
    for transport in TRANSPORTS {
        let mut devices = warm();
        devices.base.as_mut().expect("it has a base").0 = transport;
        let mut rig = ready(&devices, Estimator::Kalman, 7);
        rig.bias_test(20.0);
        rig.set_pose();
        let id = rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(2));
        rig.silence(Direction::GyroToController);
        rig.run_for(Span::from_millis(300));
        let causes = rig.health().causes;
        assert!(causes.bridging && !causes.gyro_silent, "{causes:?}");
        let before = rig.state().uncertainty.expect("it has one").heading;
        rig.run_for(Span::from_secs(4));
        let after = rig.state().uncertainty.expect("it has one").heading;
        assert!(after > before && after.deg() > 0.1, "{after:?}");
        assert!(heading_error_deg(&mut rig) <= 3.0 * after.deg());
        rig.untap(Direction::GyroToController);
        assert!(matches!(rig.finish(id), Answer::Done(MissionResult::Straight(_))));
        let causes = rig.health().causes;
        assert!(!causes.bridging && causes.samples_lost, "{causes:?}");
        let says = rig.state().uncertainty.expect("it has one").heading.deg();
        assert!(heading_error_deg(&mut rig) <= 3.0 * says);
    }
}

/// The odometry errs by distance: a base that waits for its gyro loses little.
#[test]
fn the_base_stands_while_the_gyro_is_gone_for_long_and_goes_on_with_it() {
    for (transport, order) in [
        (TRANSPORTS[0], Rig::turn_order(180.0, 30.0)),
        (TRANSPORTS[1], Rig::turn_order(180.0, 30.0)),
        (TRANSPORTS[0], Rig::straight_order(4.0, 0.4)),
        (TRANSPORTS[1], Rig::straight_order(4.0, 0.4)),
    ] {
        let mut devices = warm();
        devices.base.as_mut().expect("it has a base").0 = transport;
        let mut rig = ready(&devices, Estimator::Kalman, 3);
        rig.bias_test(20.0);
        rig.set_pose();
        let id = rig.under_way(order, Span::from_secs(3));
        rig.silence(Direction::GyroToController);
        // 0.3 s of patience, 1.4 s of the ramp, and the delays.
        rig.run_for(Span::from_secs(2));
        let truth = rig.truth();
        assert!(truth.speed.m_per_s() == 0.0 && truth.steer_rate.rad_per_s() == 0.0, "{truth:?}");
        rig.run_for(Span::from_secs(7));
        assert!(rig.health().causes.bridging && rig.answer(id).is_none());
        rig.untap(Direction::GyroToController);
        assert!(matches!(rig.finish(id), Answer::Done(_)));
        let off = heading_error_deg(&mut rig);
        assert!(off < 0.7, "{off} deg after 1.1 % of 50 deg and a step");
    }
}

/// Found by envelopes: a silence that ended before the base's next message was bridged by nobody.
#[test]
fn a_pause_just_above_the_time_out_loses_no_turn() {
    for pause_ms in (100..=400).step_by(13) {
        for seed in 1..=4 {
            let mut rig = ready(&warm(), Estimator::Kalman, seed);
            rig.bias_test(20.0);
            rig.set_pose();
            let id = rig.under_way(Rig::turn_order(90.0, 30.0), Span::from_millis(1_500));
            rig.silence(Direction::GyroToController);
            rig.run_for(Span::from_millis(pause_ms));
            rig.untap(Direction::GyroToController);
            rig.run_for(Span::from_millis(200));
            let off = heading_error_deg(&mut rig);
            // A reading may be 20 ms old; a pause of 100 ms that is not bridged costs 3 deg.
            assert!(off < 1.0, "{pause_ms} ms: {off} deg");
            assert!(rig.health().causes.samples_lost);
            assert!(matches!(rig.finish(id), Answer::Done(_)));
        }
    }
}

/// Half of all samples are lost, in bursts: Gilbert and Elliott's model, 5 % and 10 % a byte.
#[test]
fn a_lap_on_a_line_that_loses_half_of_its_samples() {
    for seed in 1..=3 {
        let mut rig = ready(&warm(), Estimator::Kalman, seed);
        rig.bias_test(20.0);
        rig.set_pose();
        let before = rig.truth().pose;
        let (mut chance, mut is_bad) = (RandomStream::new(seed, "gyro", "line"), false);
        rig.tap(Direction::GyroToController, move |_, piece| {
            let Transmit::Bytes(sent) = piece else { return vec![piece] };
            let mut heard = Packet::new();
            for byte in sent.as_slice() {
                let share = if is_bad { 0.10 } else { 0.05 };
                is_bad ^= 0.5 + 0.5 * chance.symmetric_uniform() < share;
                let _ = is_bad || heard.push(*byte);
            }
            vec![Transmit::Bytes(heard)]
        });
        for _ in 0..4 {
            rig.straight(4.0, 0.4);
            rig.turn(90.0, 30.0);
        }
        assert!(rig.state().samples_lost > rig.state().samples / 2);
        let after = rig.truth().pose;
        let off = (after.heading - before.heading).wrapped().deg();
        assert!(off.abs() < 1.2, "{off} deg");
        let (x, y) = ((after.x - before.x).m(), (after.y - before.y).m());
        assert!(x.abs() < 0.05 && y.abs() < 0.05, "{x} m, {y} m");
    }
}

#[test]
fn a_turn_goes_on_through_a_cut() {
    for seed in 1..=10 {
        let mut rig = ready(&warm(), Estimator::Kalman, seed);
        rig.bias_test(20.0);
        rig.set_pose();
        let id = rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
        rig.silence(Direction::GyroToController);
        rig.run_for(Span::from_secs(2));
        rig.untap(Direction::GyroToController);
        assert!(matches!(rig.finish(id), Answer::Done(_)));
        let says = rig.state().uncertainty.expect("it has one").heading.deg();
        let off = heading_error_deg(&mut rig);
        assert!(off <= 3.0 * says && off < 2.0, "{off} deg, says {says}");
    }
}

#[test]
fn nobody_bridges_for_ever_and_the_papers_way_does_not_bridge() {
    for (estimator, limit_s) in [(Estimator::Kalman, 10.0), (Estimator::Paper, 0.1)] {
        let mut rig = ready(&warm(), estimator, 1);
        rig.bias_test(20.0);
        let id = rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(2));
        let since = rig.now();
        rig.silence(Direction::GyroToController);
        assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::GyroSilent));
        let took = (rig.now() - since).as_secs_f64();
        assert!((took - limit_s).abs() < 0.1, "{estimator:?}: {took}");
    }
}

/// Nothing is lost: all late samples arrive at once, and their sequence numbers show that none is missing.
#[test]
fn running_numbers_carry_the_heading_across_a_stall() {
    for (stall_ms, turn) in
        [(400, true), (1_500, true), (2_500, true), (2_300, false), (6_000, true)]
    {
        let mut rig = ready(&ideal(TRANSPORTS[0]), Estimator::Kalman, 1);
        rig.command(Command::SetCalibration(Calibration::default()));
        rig.bias_test(20.0);
        rig.set_pose();
        let order = if turn { Rig::turn_order(180.0, 30.0) } else { Rig::straight_order(4.0, 0.4) };
        let id = rig.under_way(order, Span::from_secs(3));
        let until = rig.now() + Span::from_millis(stall_ms);
        let mut waiting = Vec::new();
        rig.tap(Direction::GyroToController, move |now, piece| {
            waiting.push(piece);
            if now < until { Vec::new() } else { std::mem::take(&mut waiting) }
        });
        rig.run_for(Span::from_millis(stall_ms + 100));
        let off = heading_error_deg(&mut rig);
        assert!(off < 0.5, "{stall_ms} ms: {off} deg");
        assert!(matches!(rig.finish(id), Answer::Done(_)));
        let off = heading_error_deg(&mut rig);
        assert!(off < 0.1, "{stall_ms} ms: {off} deg");
        assert_eq!(rig.state().samples_lost, 0);
    }
}

/// All 256 numbers or none may be missing. What arrives late then is not added to the bridge.
#[test]
fn numbers_that_may_have_wrapped_do_not_turn_the_heading_twice() {
    for seed in 1..=4 {
        let mut rig = ready(&warm(), Estimator::Kalman, seed);
        rig.bias_test(20.0);
        rig.set_pose();
        let id = rig.under_way(Rig::turn_order(180.0, 30.0), Span::from_secs(3));
        let until = rig.now() + Span::from_millis(2_560);
        let mut waiting = Vec::new();
        rig.tap(Direction::GyroToController, move |now, piece| {
            waiting.push(piece);
            if now < until { Vec::new() } else { std::mem::take(&mut waiting) }
        });
        assert!(matches!(rig.finish(id), Answer::Done(_)));
        let off = heading_error_deg(&mut rig);
        assert!(off < 1.0, "{off} deg");
    }
}

/// 90 deg/h turn a lap by 1.8 deg. The filter cannot believe such a leap, and says so at the next standstills.
#[test]
fn a_bias_that_leaps_by_more_than_the_filter_believes_shows() {
    let mut silent = 0;
    for seed in 1..=20 {
        let mut rig = ready(&warm(), Estimator::Kalman, seed);
        rig.bias_test(20.0);
        rig.set_pose();
        rig.straight(1.0, 0.4);
        let by = 90f64.to_radians() / 3_600.0;
        rig.gyro().begin_fault(
            0,
            GyroFault::BiasStep { by },
            RandomStream::new(1, "gyro", "fault"),
        );
        for _ in 0..4 {
            rig.straight(4.0, 0.4);
            rig.turn(90.0, 30.0);
        }
        silent += u32::from(heading_error_deg(&mut rig) > 1.2 && rig.health().level == Level::Ok);
    }
    assert_eq!(silent, 0);
}

/// A filter of this gyro cannot believe a bias that jumps by 2,000 deg/h.
#[test]
fn a_filter_that_cannot_believe_what_it_hears_gives_way_and_says_so() {
    let mut rig = ready(&warm(), Estimator::Kalman, 5);
    let tested = rig.bias_test(20.0).mean;
    rig.set_pose();
    let by = 2_000f64.to_radians() / 3_600.0;
    let chance = RandomStream::new(1, "gyro", "fault");
    rig.gyro().begin_fault(0, GyroFault::BiasStep { by }, chance);
    rig.run_for(Span::from_secs(5));
    let causes = rig.health().causes;
    assert!(causes.estimator_failed && causes.bias_moved, "{causes:?}");
    assert_eq!(rig.health().level, Level::Degraded);
    rig.run_for(Span::from_secs(1));
    assert_eq!((rig.state().bias, rig.state().uncertainty), (tested, None));
    rig.command(Command::SetEstimator(Estimator::Kalman));
    assert!(!rig.health().causes.estimator_failed, "asked for anew");
}

#[test]
fn on_a_table_the_bias_test_tells_the_filter() {
    let mut rig = ready(&shipped("paper-table"), Estimator::Kalman, 5);
    let tested = rig.bias_test(20.0).mean;
    rig.run_for(Span::from_secs(2));
    let apart = (rig.state().bias - tested).abs();
    assert!(apart.deg_per_h() < 2.0 && tested.abs() > apart, "{apart:?} {tested:?}");
}

#[test]
fn an_estimator_that_is_chosen_leaves_no_trace_when_it_is_left() {
    let mut rig = ready(&warm(), Estimator::Kalman, 3);
    rig.bias_test(20.0);
    assert!(rig.state().uncertainty.is_some());
    rig.command(Command::SetEstimator(Estimator::Paper));
    assert!(rig.state().uncertainty.is_none());
    rig.set_pose();
    rig.turn(90.0, 30.0);
    let heading: Angle = rig.state().pose.heading;
    assert!((heading.deg() - 90.0).abs() < 0.2 && rig.state().pose.x.abs() < Length::from_m(0.01));
}
