//! A device that falls silent: which node detects it, how soon, and how far the base still moves.
//!
//! The base brakes at the lower of its own limit (0.5 m/s^2, 120 deg/s^2) and the host's, one and a half times the
//! prescribed ramps (0.6 m/s^2, 22.5 deg/s^2). From a speed v, detected with a delay d, it moves on for v d + v^2 / 2a.

use controller::health::{Causes, Level};
use controller::mission::{AbortReason, Command, HeadingSource, MissionResult, Refusal};
use emulators::base::Transport;
use std::collections::VecDeque;
use tests::devices::{NAVIGATOR, TRANSPORTS, ideal, ideal_table};
use tests::rig::{Answer, Direction, Rig};
use wire::base::Request;
use wire::time::Span;
use wire::units::{AngularRate, Speed};

const SPEED: f64 = 0.4;
const RATE_DEG: f64 = 30.0;
const BRAKE: f64 = 0.5;
const STEER_BRAKE_DEG: f64 = 22.5;
/// `GyroConfig::timeout`.
const GYRO_TIMEOUT_S: f64 = 0.1;
/// `BaseConfig::timeout_moving`.
const BASE_TIMEOUT_S: f64 = 0.25;
/// `BaseParameters::command_timeout_s`.
const COMMAND_TIMEOUT_S: f64 = 0.5;
/// The gyro's period: maximum age of the last received sample when silence begins.
const SAMPLE_S: f64 = 0.01;
/// Rounding to whole nanoseconds, and to counts of the wire.
const SLACK: f64 = 1e-3;

/// Maximum time that a stop waits for its line and takes on it, while the base answers.
fn line_s(transport: Transport) -> f64 {
    match transport {
        // After one frame of at most 135 bits, at most 65 bits of its own, at 500 kbit/s.
        Transport::Can => 0.000_4,
        // After one exchange of 21 characters, 14 characters of its own, at 19200 baud.
        Transport::Serial => 0.018_3,
    }
}

/// How a running mission ended after something fell silent.
struct Fall {
    reason: AbortReason,
    /// Time from the silence to the report.
    noticed_s: f64,
    /// Time from the silence to rest.
    at_rest_s: f64,
    /// Metres or degrees from the silence to rest.
    travelled: f64,
}

/// Runs `command` for 3 s, silences the directions and waits for rest.
fn fall_silent(rig: &mut Rig, command: Command, silent: &[Direction]) -> Fall {
    let turns = matches!(command, Command::Turn(_));
    let id = rig.under_way(command, Span::from_secs(3));
    let place = |rig: &mut Rig| {
        let truth = rig.truth();
        if turns { truth.pose.heading.deg() } else { truth.pose.x.m() }
    };
    let (since, from) = (rig.now(), place(rig));
    silent.iter().for_each(|direction| rig.silence(*direction));
    let Answer::Aborted(reason) = rig.finish(id) else { panic!("{:?}", rig.answer(id)) };
    let noticed_s = (rig.now() - since).as_secs_f64();
    let stopped = rig.run_until(Span::from_secs(10), |rig| {
        let truth = rig.truth();
        truth.speed == Speed::ZERO && truth.steer_rate == AngularRate::ZERO
    });
    assert!(stopped, "the base never stopped");
    let at_rest_s = (rig.now() - since).as_secs_f64();
    Fall { reason, noticed_s, at_rest_s, travelled: place(rig) - from }
}

fn straight() -> Command {
    Rig::straight_order(4.0, SPEED)
}

fn turn() -> Command {
    Rig::turn_order(360.0, RATE_DEG)
}

#[test]
fn a_gyro_that_falls_silent_in_motion_stops_the_base() {
    for transport in TRANSPORTS {
        for (command, v, a) in [(straight(), SPEED, BRAKE), (turn(), RATE_DEG, STEER_BRAKE_DEG)] {
            let mut rig = Rig::new(&ideal(transport), 1).ready();
            let fall = fall_silent(&mut rig, command, &[Direction::GyroToController]);
            assert_eq!(fall.reason, AbortReason::GyroSilent);
            let noticed = GYRO_TIMEOUT_S - SAMPLE_S..=GYRO_TIMEOUT_S + SLACK;
            assert!(noticed.contains(&fall.noticed_s), "{transport:?} {}", fall.noticed_s);
            let late = GYRO_TIMEOUT_S + line_s(transport);
            assert!(fall.at_rest_s <= late + v / a + SLACK, "{transport:?} {}", fall.at_rest_s);
            let furthest = v * late + v * v / (2.0 * a);
            assert!(fall.travelled <= furthest * (1.0 + SLACK), "{} {furthest}", fall.travelled);
            let health = rig.health();
            assert_eq!(health.level, Level::Fault);
            assert_eq!(health.causes, Causes { gyro_silent: true, ..Causes::default() });
        }
    }
}

#[test]
fn a_silent_gyro_that_returns_is_used_again_and_its_gap_is_told() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    fall_silent(&mut rig, turn(), &[Direction::GyroToController]);
    assert_eq!(rig.command(straight()), Answer::Refused(Refusal::NoGyro));
    assert_eq!(rig.command(Rig::bias_test_order(1.0)), Answer::Refused(Refusal::NoGyro));
    rig.untap(Direction::GyroToController);
    rig.run_for(Span::from_millis(50));
    let causes = rig.health().causes;
    assert!(!causes.gyro_silent);
    // Nothing observed how far the base turned meanwhile: health must show the doubtful heading.
    let off = (rig.state().gyro_heading - rig.heading()).deg().abs();
    assert!(off > 10.0, "{off}");
    assert_eq!(rig.health().level, Level::Degraded);
    assert!(causes.samples_lost);
    rig.bias_test(1.0);
    assert!(rig.health().causes.samples_lost, "no bias test finds what was lost");
    rig.set_pose();
    assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
    rig.turn(90.0, RATE_DEG);
}

#[test]
fn a_short_silence_is_bridged_and_counted() {
    // With |w'| <= a, linear interpolation over T errs by at most a T^2 / 4.
    const GAP_S: f64 = 0.09;
    let bound_deg = STEER_BRAKE_DEG * (GAP_S + SAMPLE_S).powi(2) / 4.0;
    for at_ms in [500, 1_500, 3_000, 12_500] {
        let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
        let off = |rig: &mut Rig| rig.state().gyro_heading - rig.heading();
        let id = rig.under_way(turn(), Span::from_millis(at_ms));
        rig.silence(Direction::GyroToController);
        rig.run_for(Span::from_secs_f64(GAP_S));
        rig.untap(Direction::GyroToController);
        assert!(matches!(rig.finish(id), Answer::Done(MissionResult::Turn(_))), "at {at_ms} ms");
        rig.run_for(Span::from_secs(1));
        let off = off(&mut rig).deg().abs();
        assert!(off <= bound_deg, "at {at_ms} ms: {off} deg, expected at most {bound_deg}");
        assert_eq!(rig.state().samples_lost, 9, "at {at_ms} ms");
        assert!(rig.health().causes.samples_lost);
    }
}

#[test]
fn a_gyro_that_falls_silent_at_rest_shows_in_health_and_breaks_a_bias_test_off() {
    for devices in [ideal(Transport::Can), ideal(Transport::Serial), ideal_table(NAVIGATOR)] {
        let mut rig = Rig::new(&devices, 1).ready();
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
        let idle_since = rig.now();
        rig.silence(Direction::GyroToController);
        rig.run_for(Span::from_secs_f64(GYRO_TIMEOUT_S + SLACK));
        let &(at, health) = rig.health_changes().last().expect("health has changed");
        assert!((at - idle_since).as_secs_f64() >= GYRO_TIMEOUT_S - SAMPLE_S);
        assert!(health.level == Level::Fault && health.causes.gyro_silent);

        let mut rig = Rig::new(&devices, 1).ready();
        let id = rig.under_way(Rig::bias_test_order(20.0), Span::from_secs(5));
        let since = rig.now();
        rig.silence(Direction::GyroToController);
        assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::GyroSilent));
        assert!((rig.now() - since).as_secs_f64() <= GYRO_TIMEOUT_S + SLACK);
        assert!(rig.health().causes.bias_test_failed);
        // The bias of the previous test stays in force, and the next test clears the doubt.
        rig.untap(Direction::GyroToController);
        rig.run_for(Span::from_secs(1));
        rig.bias_test(1.0);
        rig.set_pose();
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
    }
}

#[test]
fn by_odometry_the_gyro_may_be_silent() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    rig.command(Command::SetHeadingSource(HeadingSource::Odometry));
    let id = rig.under_way(Rig::straight_order(1.0, SPEED), Span::from_secs(1));
    rig.silence(Direction::GyroToController);
    assert!(matches!(rig.finish(id), Answer::Done(_)));
    assert!(rig.health().causes.gyro_silent);
}

#[test]
fn a_base_that_is_not_heard_is_told_to_stop() {
    for transport in TRANSPORTS {
        for (command, v, a) in [(straight(), SPEED, BRAKE), (turn(), RATE_DEG, STEER_BRAKE_DEG)] {
            let mut rig = Rig::new(&ideal(transport), 1).ready();
            let fall = fall_silent(&mut rig, command, &[Direction::BaseToController]);
            assert_eq!(fall.reason, AbortReason::BaseSilent);
            // On a serial line a stop waits until the unanswered exchange is abandoned (60 ms) and the line has been
            // quiet (9 characters).
            let late = BASE_TIMEOUT_S
                + line_s(transport)
                + if transport == Transport::Serial { 0.065 } else { 0.0 };
            assert!(fall.noticed_s <= BASE_TIMEOUT_S + SLACK, "{}", fall.noticed_s);
            assert!(fall.at_rest_s <= late + v / a + SLACK, "{transport:?} {}", fall.at_rest_s);
            let furthest = v * late + v * v / (2.0 * a);
            assert!(fall.travelled <= furthest * (1.0 + SLACK), "{} {furthest}", fall.travelled);
            assert!(rig.health().causes.base_silent);
            assert_eq!(rig.command(turn()), Answer::Refused(Refusal::NoBase));

            rig.untap(Direction::BaseToController);
            rig.run_for(Span::from_secs(2));
            assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
            rig.turn(90.0, RATE_DEG);
        }
    }
}

#[test]
fn a_base_that_hears_nothing_stops_by_itself() {
    for transport in TRANSPORTS {
        for (command, v, a) in [(straight(), SPEED, BRAKE), (turn(), RATE_DEG, STEER_BRAKE_DEG)] {
            let mut rig = Rig::new(&ideal(transport), 1).ready();
            let fall = fall_silent(&mut rig, command, &[Direction::ControllerToBase]);
            // On CAN the base continues to report, and reports it itself; on a serial line it only answers.
            let expected = match transport {
                Transport::Can => AbortReason::BaseCommandTimeout,
                Transport::Serial => AbortReason::BaseSilent,
            };
            assert_eq!(fall.reason, expected);
            let at_rest = COMMAND_TIMEOUT_S + v / a + SLACK;
            assert!(fall.at_rest_s <= at_rest, "{transport:?} {} {at_rest}", fall.at_rest_s);
            let furthest = v * COMMAND_TIMEOUT_S + v * v / (2.0 * a);
            assert!(fall.travelled <= furthest * (1.0 + SLACK), "{} {furthest}", fall.travelled);

            rig.untap(Direction::ControllerToBase);
            rig.run_for(Span::from_secs(2));
            rig.straight(0.5, SPEED);
        }
    }
}

#[test]
fn a_base_that_is_cut_off_stops_by_itself_and_is_missed() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let both = [Direction::BaseToController, Direction::ControllerToBase];
        let fall = fall_silent(&mut rig, straight(), &both);
        assert_eq!(fall.reason, AbortReason::BaseSilent);
        assert!(fall.at_rest_s <= COMMAND_TIMEOUT_S + SPEED / BRAKE + SLACK, "{}", fall.at_rest_s);
        both.iter().for_each(|direction| rig.untap(*direction));
        rig.run_for(Span::from_secs(2));
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
        rig.straight(-0.5, SPEED);
    }
}

#[test]
fn a_base_that_is_silent_at_rest_shows_in_health_and_returns() {
    /// `BaseConfig::timeout_at_rest`.
    const TIMEOUT_S: f64 = 1.6;
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let since = rig.now();
        rig.silence(Direction::BaseToController);
        rig.run_for(Span::from_secs_f64(TIMEOUT_S + SLACK));
        let &(at, health) = rig.health_changes().last().expect("health has changed");
        assert!(health.level == Level::Fault && health.causes.base_silent, "{health:?}");
        assert!((at - since).as_secs_f64() <= TIMEOUT_S + SLACK);
        rig.untap(Direction::BaseToController);
        rig.run_for(Span::from_secs(1));
        assert_eq!(rig.health().level, Level::Ok, "{:?}", rig.health());
    }
}

#[test]
fn a_base_that_moves_on_its_own_while_nobody_looks_is_not_at_rest() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let (drive, steer) = (Speed::from_m_per_s(0.2), AngularRate::ZERO);
    let now = rig.now();
    rig.base().request(now, Request::SetVelocity { drive, steer });
    rig.run_for(Span::from_millis(100));
    assert_eq!(rig.command(Rig::bias_test_order(1.0)), Answer::Refused(Refusal::Moving));
    assert_eq!(rig.command(turn()), Answer::Refused(Refusal::Moving));
    // The base's own command time-out ends the motion.
    rig.run_for(Span::from_secs(3));
    rig.turn(10.0, RATE_DEG);
}

/// Found by a campaign: a bus that delays the base by a second. Each message is as old as the silence before the first,
/// and the believed path lags behind until the base is heard to stand.
#[test]
fn what_a_base_says_after_a_silence_is_not_trusted_until_it_stands() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let from = rig.truth().pose.x - rig.state().pose.x;
    let id = rig.under_way(straight(), Span::from_secs(3));
    let mut late = VecDeque::new();
    rig.tap(Direction::BaseToController, move |now, piece| {
        late.push_back((now + Span::from_secs(1), piece));
        let due = late.iter().take_while(|(at, _)| *at <= now).count();
        late.drain(..due).map(|(_, piece)| piece).collect()
    });
    assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::BaseSilent));
    let until = rig.now() + Span::from_secs(5);
    let mut worst = 0.0f64;
    rig.run_until(Span::from_secs(5), |rig| {
        let off = (rig.truth().pose.x - rig.state().pose.x - from).m().abs();
        worst = worst.max(off);
        assert!(off < 0.05 || rig.health().level > Level::Ok, "{off} m, {:?}", rig.health());
        rig.now() >= until
    });
    assert!(worst > 0.1, "the messages are late: {worst} m");
    assert_eq!(rig.health().level, Level::Ok, "it stands where it says: {:?}", rig.health());
}
