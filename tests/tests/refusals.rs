//! What the controller refuses, and what makes it break off.

use controller::calibration::{Calibration, Factor};
use controller::health::Level;
use controller::mission::{
    AbortReason, BiasMethod, Command, HeadingSource, MissionResult, Refusal, Straight, Turn,
};
use emulators::base::Transport;
use tests::devices::{NAVIGATOR, TRANSPORTS, ideal, ideal_table};
use tests::rig::{Answer, Direction, Rig};
use wire::base::{PoseWriteResult, Reply, Request, can_link};
use wire::device::Transmit;
use wire::table::Command as TableCommand;
use wire::time::Span;
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

fn refused(reason: Refusal) -> Answer {
    Answer::Refused(reason)
}

fn pose(x: f64, y: f64, heading: f64) -> Command {
    Command::SetPose(Pose {
        x: Length::from_m(x),
        y: Length::from_m(y),
        heading: Angle::from_rad(heading),
    })
}

fn is_at_rest(rig: &mut Rig) -> bool {
    let truth = rig.truth();
    truth.speed == Speed::ZERO && truth.steer_rate == AngularRate::ZERO
}

#[test]
fn one_mission_at_a_time() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let running = rig.under_way(Rig::straight_order(2.0, 0.4), Span::from_secs(2));
        for command in [
            Rig::straight_order(1.0, 0.4),
            Rig::turn_order(90.0, 30.0),
            Rig::bias_test_order(1.0),
            pose(0.0, 0.0, 0.0),
            Command::SetHeadingSource(HeadingSource::Odometry),
            Command::SetCalibration(Calibration::default()),
        ] {
            let name = format!("{command:?}");
            assert_eq!(rig.command(command), refused(Refusal::Busy), "{name}");
        }
        let Answer::Done(MissionResult::Straight(result)) = rig.finish(running) else {
            panic!("what was refused must not touch what runs: {:?}", rig.answer(running));
        };
        assert!(result.stop_error.abs().m() <= 0.002);
    }
}

#[test]
fn stop_ends_a_mission_and_the_next_starts_from_there() {
    for transport in TRANSPORTS {
        for order in [Rig::straight_order(4.0, 0.4), Rig::turn_order(360.0, 30.0)] {
            let mut rig = Rig::new(&ideal(transport), 1).ready();
            let id = rig.under_way(order, Span::from_secs(3));
            assert_eq!(rig.command(Command::Stop), Answer::Done(MissionResult::Applied));
            assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::Stopped));
            // 30 deg/s at 22.5 deg/s^2 take 1.34 s.
            rig.run_for(Span::from_secs(2));
            assert!(is_at_rest(&mut rig));
            let before = rig.heading();
            rig.turn(10.0, 30.0);
            let turned = (rig.heading() - before).deg();
            assert!((turned - 10.0).abs() <= 0.1, "{turned}");
        }
    }
}

/// The base reports rest once more when the turn has already begun.
#[test]
fn a_stop_at_rest_takes_nothing_from_a_turn_that_comes_at_once() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let before = rig.heading();
        assert_eq!(rig.command(Command::Stop), Answer::Done(MissionResult::Applied));
        rig.turn(90.0, 30.0);
        let turned = (rig.heading() - before).deg();
        assert!((turned - 90.0).abs() <= 0.1, "{turned}");
    }
}

#[test]
fn a_number_that_is_none_or_beyond_the_limits_is_refused() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let straight = |distance: f64, speed: f64| {
        Command::Straight(Straight {
            distance: Length::from_m(distance),
            speed: Speed::from_m_per_s(speed),
        })
    };
    let turn = |angle: f64, rate: f64| {
        Command::Turn(Turn {
            angle: Angle::from_rad(angle),
            rate: AngularRate::from_rad_per_s(rate),
        })
    };
    let mut commands = vec![straight(1_000.1, 0.4), straight(1.0, 0.781), straight(1.0, 0.0)];
    commands.extend([turn(1_000.1, 0.5), turn(1.0, 2.1), turn(1.0, 0.0), straight(1.0, -0.4)]);
    // Below the base's smallest commandable speed: it would never move.
    commands.extend([straight(1.0, 1e-6), straight(1.0, f64::MIN_POSITIVE), turn(1.0, 1e-6)]);
    commands.extend([turn(1.0, -0.5), Rig::bias_test_order(0.0), Rig::bias_test_order(3_600.1)]);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        commands.extend([straight(bad, 0.4), straight(1.0, bad), turn(bad, 0.5), turn(1.0, bad)]);
        commands.extend([pose(bad, 0.0, 0.0), pose(0.0, bad, 0.0), pose(0.0, 0.0, bad)]);
        commands.push(Rig::bias_test_order(bad));
        let factors = [Factor::Constant(bad)].into_iter().collect();
        commands.push(Command::SetCalibration(Calibration { factors, ..Calibration::default() }));
    }
    // Beyond the 23 bits of a coordinate, 419 m: the base could not accept it.
    commands.extend([pose(500.0, 0.0, 0.0), pose(0.0, -1e9, 0.0)]);
    let before = rig.state().pose;
    for command in commands {
        let name = format!("{command:?}");
        assert_eq!(rig.command(command), refused(Refusal::OutOfRange), "{name}");
    }
    assert_eq!(rig.state().pose, before);
    assert_eq!(rig.health().level, Level::Ok);
    rig.straight(0.1, 0.4);
}

#[test]
fn by_the_gyro_nothing_moves_before_its_bias_is_known() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1);
    rig.run_for(Span::from_secs(1));
    assert_eq!(rig.health().level, Level::Degraded);
    assert!(rig.health().causes.no_bias);
    let turn = || Rig::turn_order(90.0, 30.0);
    assert_eq!(rig.command(turn()), refused(Refusal::NoBias));
    // A missing table gives no bias either.
    rig.command(Command::SetBiasMethod(BiasMethod::TemperatureTable));
    assert_eq!(rig.command(turn()), refused(Refusal::NoBias));
    rig.command(Command::SetBiasMethod(BiasMethod::None));
    assert!(matches!(rig.command(turn()), Answer::Done(_)));
    rig.command(Command::SetBiasMethod(BiasMethod::StaticTest));
    assert_eq!(rig.command(turn()), refused(Refusal::NoBias));
    rig.command(Command::SetHeadingSource(HeadingSource::Odometry));
    assert!(matches!(rig.command(turn()), Answer::Done(_)));
}

#[test]
fn nothing_moves_by_a_gyro_that_was_never_heard() {
    for method in [BiasMethod::StaticTest, BiasMethod::None] {
        let mut rig = Rig::new(&ideal(Transport::Can), 1);
        rig.silence(Direction::GyroToController);
        rig.run_for(Span::from_secs(3));
        rig.command(Command::SetBiasMethod(method));
        for order in [Rig::turn_order(90.0, 30.0), Rig::straight_order(1.0, 0.4)] {
            assert_eq!(rig.command(order), refused(Refusal::NoGyro), "{method:?}");
        }
        assert_eq!(rig.command(Rig::bias_test_order(1.0)), refused(Refusal::NoGyro));
        assert_eq!(rig.health().level, Level::Starting);
        assert!(is_at_rest(&mut rig));
    }
}

#[test]
fn nothing_moves_on_a_base_that_was_never_heard() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1);
        rig.silence(Direction::BaseToController);
        rig.run_for(Span::from_secs(3));
        assert_eq!(rig.command(Rig::turn_order(90.0, 30.0)), refused(Refusal::NoBase));
        assert_eq!(rig.command(Rig::bias_test_order(1.0)), refused(Refusal::Moving));
        assert_eq!(rig.health().level, Level::Starting);
    }
    // A table has no base at all.
    let mut rig = Rig::new(&ideal_table(NAVIGATOR), 1).ready();
    assert_eq!(rig.command(Rig::straight_order(1.0, 0.4)), refused(Refusal::OutOfRange));
    assert_eq!(rig.command(pose(1.0, 2.0, 3.0)), Answer::Done(MissionResult::Applied));
}

/// Turns the table at this rate, and keeps it turning.
fn turn_table(rig: &mut Rig, deg_per_s: u32) {
    let now = rig.now();
    let table = rig.table();
    for command in [
        TableCommand::TopRate(80 * deg_per_s),
        TableCommand::Ramp(1_200),
        TableCommand::Distance(1_000_000),
        TableCommand::Go,
    ] {
        table.command(now, command);
    }
}

#[test]
fn a_bias_test_on_a_turning_table_comes_to_nothing() {
    for deg_per_s in [1, 3, 30] {
        // The table turns before the test ...
        let mut rig = Rig::new(&ideal_table(NAVIGATOR), 1).ready();
        turn_table(&mut rig, deg_per_s);
        rig.run_for(Span::from_millis(3_500));
        let answer = rig.command(Rig::bias_test_order(20.0));
        let expected = [refused(Refusal::Moving), Answer::Aborted(AbortReason::NotAtRest)];
        assert!(expected.contains(&answer), "{deg_per_s} deg/s: {answer:?}");
        assert_eq!(rig.state().bias, AngularRate::ZERO, "the good bias stays");

        // ... or it begins to turn during the test.
        let mut rig = Rig::new(&ideal_table(NAVIGATOR), 1).ready();
        let id = rig.under_way(Rig::bias_test_order(20.0), Span::from_secs(15));
        turn_table(&mut rig, deg_per_s);
        assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::NotAtRest), "{deg_per_s} deg/s");
        assert!(rig.health().causes.bias_test_failed);
    }
}

#[test]
fn a_bias_test_on_a_base_that_is_pushed_off_comes_to_nothing() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        let id = rig.under_way(Rig::bias_test_order(20.0), Span::from_secs(5));
        let now = rig.now();
        let push =
            Request::SetVelocity { drive: Speed::ZERO, steer: AngularRate::from_deg_per_s(5.0) };
        rig.base().request(now, push);
        assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::NotAtRest), "{transport:?}");
    }
}

#[test]
fn an_emergency_stop_or_a_fault_forbids_motion_until_it_is_gone() {
    type Set = fn(&mut Rig, bool);
    let emergency_stop: Set = |rig, on| {
        let now = rig.now();
        rig.base().set_emergency_stop(now, on);
    };
    let fault: Set = |rig, on| {
        let now = rig.now();
        rig.base().set_fault(now, on);
    };
    let cases = [(emergency_stop, AbortReason::EmergencyStop), (fault, AbortReason::BaseFault)];
    for transport in TRANSPORTS {
        for (set, reason) in cases {
            let mut rig = Rig::new(&ideal(transport), 1).ready();
            // On a serial line, rest is polled twice a second.
            let heard = Span::from_millis(600);
            set(&mut rig, true);
            rig.run_for(heard);
            assert_eq!(rig.command(Rig::turn_order(90.0, 30.0)), refused(Refusal::BaseNotReady));
            assert_eq!(rig.health().level, Level::Fault);
            assert!(rig.health().causes.base_not_ready);
            set(&mut rig, false);
            rig.run_for(heard);
            assert_eq!(rig.health().level, Level::Ok);

            let id = rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(3));
            let (since, from) = (rig.now(), rig.truth().pose.x.m());
            set(&mut rig, true);
            assert_eq!(rig.finish(id), Answer::Aborted(reason));
            // One period of the loop and two exchanges of 21 characters: 27 + 22 ms.
            assert!((rig.now() - since).as_secs_f64() <= 0.05, "{transport:?}");
            assert!(rig.run_until(Span::from_secs(3), is_at_rest));
            // The base brakes at once by itself: 0.4 m/s at 0.5 m/s^2.
            let travelled = rig.truth().pose.x.m() - from;
            assert!(travelled <= 0.4 * 0.4 / (2.0 * 0.5) + 1e-6, "{travelled}");
            set(&mut rig, false);
            rig.run_for(heard);
            assert!(is_at_rest(&mut rig), "nothing moves again by itself");
            rig.straight(-0.5, 0.4);
        }
    }
}

/// Keeps the base in slow motion, or at rest.
fn nudge(rig: &mut Rig, m_per_s: f64) {
    let now = rig.now();
    let (drive, steer) = (Speed::from_m_per_s(m_per_s), AngularRate::ZERO);
    rig.base().request(now, Request::SetVelocity { drive, steer });
}

#[test]
fn a_pose_write_that_is_refused_in_motion_is_tried_again_at_rest() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        // The controller does not know yet that the base moves.
        nudge(&mut rig, 0.05);
        let id = rig.begin(pose(1.0, 2.0, 0.5));
        rig.run_for(Span::from_millis(300));
        assert_eq!(rig.answer(id), None, "{transport:?}: a pose is not written in motion");
        assert_eq!(rig.finish(id), Answer::Done(MissionResult::Applied), "{transport:?}");
        assert!(is_at_rest(&mut rig));
        assert!(!rig.health().causes.pose_not_written);
    }
}

#[test]
fn a_base_that_never_takes_the_pose_shows_in_health_until_it_does() {
    for transport in TRANSPORTS {
        let mut rig = Rig::new(&ideal(transport), 1).ready();
        nudge(&mut rig, 0.01);
        let id = rig.begin(pose(1.0, 2.0, 0.5));
        // Five attempts, 0.7 s apart.
        for _ in 0..40 {
            rig.run_for(Span::from_millis(100));
            nudge(&mut rig, 0.01);
        }
        assert_eq!(
            rig.answer(id).map(|(_, answer)| answer),
            Some(Answer::Aborted(AbortReason::PoseWriteRefused)),
            "{transport:?}"
        );
        assert!(rig.health().causes.pose_not_written);
        assert_eq!(rig.health().level, Level::Degraded);
        nudge(&mut rig, 0.0);
        rig.run_for(Span::from_secs(1));
        assert_eq!(rig.command(pose(0.0, 0.0, 0.0)), Answer::Done(MissionResult::Applied));
        assert_eq!(rig.health().level, Level::Ok);
    }
}

/// A base on CAN that rejects the next `refusals` pose writes because it moved.
fn refuse_pose_writes(rig: &mut Rig, refusals: u32) {
    let (mut counter, mut writes) = (None, 0);
    rig.tap(Direction::BaseToController, move |_, piece| {
        let Transmit::Frame(frame) = &piece else { return vec![piece] };
        let Some(Reply::Motion(mut motion)) = can_link::parse_reply(frame) else {
            return vec![piece];
        };
        let before = counter.replace(motion.pose_write_counter);
        writes += u32::from(before.is_some_and(|before| before != motion.pose_write_counter));
        if (1..=refusals).contains(&writes) {
            motion.pose_write = PoseWriteResult::RefusedInMotion;
        }
        vec![Transmit::Frame(can_link::reply_frame(&Reply::Motion(motion)))]
    });
}

#[test]
fn a_straight_line_tells_how_often_it_had_to_write_its_pose() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    assert_eq!(rig.straight(0.5, 0.4).pose_writes, 1);
    refuse_pose_writes(&mut rig, 2);
    assert_eq!(rig.straight(0.5, 0.4).pose_writes, 3);
    refuse_pose_writes(&mut rig, u32::MAX);
    assert_eq!(
        rig.command(Rig::straight_order(0.5, 0.4)),
        Answer::Aborted(AbortReason::PoseWriteRefused)
    );
    assert!(rig.health().causes.pose_not_written);
    // It stands at its target, and may continue.
    rig.untap(Direction::BaseToController);
    assert_eq!(rig.straight(-1.5, 0.4).pose_writes, 1);
    assert_eq!(rig.health().level, Level::Ok);
    assert!(rig.truth().pose.x.abs().m() < 0.008);
}

#[test]
fn a_command_timeout_of_the_base_is_seen() {
    let mut rig = Rig::new(&ideal(Transport::Can), 1).ready();
    let id = rig.under_way(Rig::straight_order(4.0, 0.4), Span::from_secs(3));
    let since = rig.now();
    rig.silence(Direction::ControllerToBase);
    assert_eq!(rig.finish(id), Answer::Aborted(AbortReason::BaseCommandTimeout));
    // The base's 0.5 s, one report of 20 ms, one period of the loop.
    let noticed = (rig.now() - since).as_secs_f64();
    assert!((0.5 - 0.03..=0.5 + 0.05).contains(&noticed), "{noticed}");
}
