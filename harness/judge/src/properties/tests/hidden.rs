//! What faults hide explains a violation, and nothing more than that does.

use super::super::{Seen, Truth};
use super::scene::Scene;
use controller::health::Causes;
use controller::mission::{
    Command, MissionResult, Report, Straight, StraightResult, Turn, TurnResult,
};
use wire::base::{Motion, Reply, Request, can_link};
use wire::device::Transmit;
use wire::time::Span;
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

/// True if the first violation is explained by what was hidden; it is violated in any case.
fn is_explained(name: &str, play: impl FnOnce(&mut Scene)) -> bool {
    let mut scene = Scene::new();
    scene.health(Causes::default());
    play(&mut scene);
    let verdict = scene.verdict(name);
    let what = verdict.first_violation.expect("it is violated").what;
    assert!(verdict.margin.is_some_and(|margin| margin < 0.0));
    assert_eq!(what.contains("; under "), what.ends_with("which no input of the controller shows"));
    what.contains("; under ")
}

fn drive(speed: f64) -> Request {
    Request::SetVelocity { drive: Speed::from_m_per_s(speed), steer: AngularRate::ZERO }
}

/// A straight of 4 m that is called done, at 0.4 m/s by the wheels: `grip` of it holds for the last 5 s.
fn slides(grip: f64, done_m: f64) -> bool {
    is_explained("done_is_done", |scene| {
        let truth = |x: f64, speed: f64, wheels: f64| Truth {
            pose: Pose { x: Length::from_m(x), ..Pose::default() },
            speed: Speed::from_m_per_s(speed),
            wheels: Speed::from_m_per_s(wheels),
            ..Truth::default()
        };
        scene.see(&Seen::Truth(truth(0.0, 0.0, 0.0)));
        let (distance, speed) = (Length::from_m(4.0), Speed::from_m_per_s(0.4));
        scene.tell(3, Command::Straight(Straight { distance, speed }));
        let mut x = 0.0;
        for n in 0..500 {
            let speed = 0.4 * if n < 250 { 1.0 } else { grip };
            x += speed * 0.02;
            scene.after(20).see(&Seen::Truth(truth(x * done_m / 4.0, speed, 0.4)));
        }
        scene.after(20).see(&Seen::Truth(truth(x * done_m / 4.0, 0.0, 0.0)));
        let result = MissionResult::Straight(StraightResult {
            stop_error: Length::ZERO,
            heading_error_max: Angle::ZERO,
            heading_error: Angle::ZERO,
            pose: Pose::default(),
            pose_writes: 1,
            duration: Span::from_secs(10),
        });
        scene.report(Report::Done { id: 3, result });
    })
}

#[test]
fn slip_explains_the_path_that_was_lost_and_no_more() {
    assert!(slides(0.9, 4.0), "0.2 m of 0.2 m");
    assert!(!slides(0.98, 3.8), "0.04 m of 0.24 m");
}

/// A turn of 90 deg at 30 deg/s that is called done. The gyro reads `leap_deg` more than there is, all of it before the
/// base stands, or half of it after; the base stops after `true_deg`, and its odometry errs by `odometry` of the turn.
fn leaps(leap_deg: f64, true_deg: f64, odometry: f64, at_rest: bool, turns_before: u32) -> bool {
    is_explained("done_is_done", |scene| {
        scene.truth(0.0, 0.0);
        let mut from = Angle::ZERO;
        for _ in 0..turns_before {
            turn(scene, from, (0.0, 90.0), odometry, 0.0);
            from += Angle::from_deg(90.0);
        }
        let order = Turn { angle: Angle::from_deg(90.0), rate: AngularRate::from_deg_per_s(30.0) };
        scene.tell(3, Command::Turn(order));
        let rests_deg = if at_rest { 0.5 } else { 0.0 };
        turn(scene, from, (leap_deg, true_deg), odometry, rests_deg);
        let result = MissionResult::Turn(TurnResult {
            stop_error: Angle::ZERO,
            gyro_angle: order.angle,
            odometry_angle: order.angle,
            duration: Span::from_secs(5),
        });
        scene.report(Report::Done { id: 3, result });
    })
}

fn turn(
    scene: &mut Scene,
    from: Angle,
    (leap_deg, true_deg): (f64, f64),
    odometry: f64,
    rests_deg: f64,
) {
    let mut show = |share: f64, rate_deg: f64, leapt_deg: f64| {
        let turned = Angle::from_deg(true_deg * share);
        let heading = ((from + turned) * (1.0 + odometry)).wrapped();
        let motion = Motion { heading, moving: rate_deg != 0.0, ..Motion::default() };
        scene.see(&Seen::BaseFrame(&can_link::reply_frame(&Reply::Motion(motion))));
        let pose = Pose { heading: from + turned, ..Pose::default() };
        let steer_rate = AngularRate::from_deg_per_s(rate_deg);
        let leapt = Angle::from_deg(leapt_deg);
        scene.see(&Seen::Truth(Truth { pose, steer_rate, leapt, ..Truth::default() })).after(20);
    };
    show(0.0, 0.0, 0.0);
    for n in 0..150 {
        show(f64::from(n) / 150.0, 30.0, leap_deg * f64::from(n) / 150.0);
    }
    for n in 0..25 {
        show(1.0, 0.0, leap_deg + rests_deg * f64::from(n) / 25.0);
    }
}

#[test]
fn a_leap_explains_a_turn_unless_an_input_shows_it() {
    assert!(leaps(2.5, 87.5, 0.0, false, 0), "an unknown base may err by 3.2 deg");
    assert!(leaps(3.22, 86.7, 0.0, false, 0), "of the turn that the gyro shows");
    assert!(!leaps(3.5, 86.5, 0.0, false, 0), "and by no more");
    assert!(leaps(3.5, 86.5, 0.01, false, 0), "by what it erred itself, they differ by less");
    assert!(!leaps(2.5, 87.5, 0.0, true, 0), "a standstill shows it");
    assert!(!leaps(2.5, 87.5, 0.0, false, 1), "the base is known from its first turn");
    assert!(!leaps(0.8, 87.5, 0.0, false, 0), "the leap is not all that is wrong");
}

/// A base that speeds up by more than is allowed, after the orders that it received.
fn speeds_up(orders: impl FnOnce(&mut Scene)) -> bool {
    is_explained("within_limits", |scene| {
        scene.truth(0.0, 0.0);
        orders(scene);
        scene.after(60).truth(0.0, 0.0).after(60).truth(0.0, 0.2);
    })
}

fn carried(scene: &mut Scene, request: &Request) {
    let frame = can_link::request_frame(request).expect("it fits the wire");
    scene.see(&Seen::Carried(&Transmit::Frame(frame)));
}

#[test]
fn an_order_that_the_controller_did_not_give_explains_what_the_base_does() {
    assert!(!speeds_up(|scene| {
        scene.request(&drive(0.1));
        carried(scene, &drive(0.1));
    }));
    assert!(speeds_up(|scene| {
        scene.request(&drive(0.1));
        carried(scene, &drive(0.3));
    }));
    assert!(!speeds_up(|scene| {
        scene.request(&drive(0.1));
        carried(scene, &drive(0.3));
        carried(scene, &drive(0.1));
    }));
    let stops_late = |millis| {
        speeds_up(|scene| {
            scene.request(&drive(0.1)).request(&Request::Stop).after(millis);
            carried(scene, &drive(0.1));
        })
    };
    assert!(stops_late(150) && !stops_late(50), "it was withdrawn");
}

#[test]
fn a_message_that_was_changed_explains_what_is_believed_until_the_next_two() {
    let off = |heard_again: u32| {
        is_explained("no_silent_wrong", |scene| {
            scene.truth(0.0, 0.0).state(0.0, 1).motion().see(&Seen::Misheard);
            for _ in 0..heard_again {
                scene.motion();
            }
            scene.after(10).truth(0.0, 0.0).state(2.0, 2);
        })
    };
    assert!(off(0) && off(1) && !off(2));
}

#[test]
fn what_is_broken_in_both_worlds_is_not_explained() {
    let broken = |at_first: bool| {
        is_explained("within_limits", |scene| {
            if at_first {
                scene.truth(0.0, -0.83).after(10);
            }
            scene.request(&drive(0.1));
            carried(scene, &drive(0.3));
            scene.after(10).truth(0.0, 0.9).after(10);
            carried(scene, &drive(0.1));
            scene.truth(0.0, 0.1).after(10);
            if !at_first {
                scene.truth(0.0, 0.83);
            }
        })
    };
    assert!(!broken(true), "it was broken before anything was hidden");
    assert!(!broken(false), "and is again after the base followed its order");
}
