//! Effect of each fault on the base and on its reports.

use super::{BaseEmulator, Motion, Span, base, motions, replies, seconds, velocity};
use crate::base::{BaseFault, BaseParameters};
use crate::random::RandomStream;
use wire::base::Request;
use wire::time::Timestamp;
use wire::units::Angle;

fn begin(base: &mut BaseEmulator, now: Timestamp, fault: BaseFault) {
    base.begin_fault(now, 2, fault, RandomStream::new(1, "fault", "2"));
}

/// Commands 0.4 m/s every 100 ms from `from` to `until`; returns the reports.
fn drive(base: &mut BaseEmulator, from: f64, until: f64) -> Vec<(Timestamp, Motion)> {
    let (mut now, mut reported) = (seconds(from), Vec::new());
    while now < seconds(until) {
        base.request(now, velocity(0.4, 0.0));
        let next = now + Span::from_millis(100);
        reported.extend(motions(replies(base, now, next)));
        now = next;
    }
    reported
}

#[test]
fn refused_commands_move_nothing_and_are_counted() {
    let mut base = base(BaseParameters::default());
    begin(&mut base, seconds(0.0), BaseFault::RefuseCommands);
    drive(&mut base, 0.0, 1.0);
    assert_eq!(base.truth_at(seconds(1.0)).pose.x.m(), 0.0);
    assert_eq!(base.end_fault(seconds(1.0), 2), 10);
    drive(&mut base, 1.0, 3.0);
    assert!(base.truth_at(seconds(3.0)).pose.x.m() > 0.1);
}

#[test]
fn stuck_odometry_says_the_same_while_the_base_moves() {
    let mut base = base(BaseParameters::default());
    drive(&mut base, 0.0, 2.0);
    begin(&mut base, seconds(2.0), BaseFault::StuckOdometry);
    let stuck = drive(&mut base, 2.0, 3.0);
    let (first, last) = (stuck[1].1, stuck[stuck.len() - 1].1);
    assert_eq!(first.displacement, last.displacement);
    assert!(last.moving && last.sequence != first.sequence);
    assert!(base.end_fault(seconds(3.0), 2) > 10);
    let after = drive(&mut base, 3.0, 3.1);
    assert!((after.last().unwrap().1.displacement - last.displacement).m() > 0.3);
}

#[test]
fn wheels_that_slip_go_less_far_than_they_count() {
    let mut base = base(BaseParameters::default());
    drive(&mut base, 0.0, 2.0);
    let before = base.truth_at(seconds(2.0)).pose.x.m();
    begin(&mut base, seconds(2.0), BaseFault::WheelSlip { lost: 0.25 });
    drive(&mut base, 2.0, 4.0);
    let slipped = base.truth_at(seconds(4.0)).pose.x.m() - before;
    assert!((slipped - 0.75 * 0.8).abs() < 1e-9, "{slipped}");
    base.end_fault(seconds(4.0), 2);
    let counted = drive(&mut base, 4.0, 4.1).last().unwrap().1.displacement.m();
    let gone = base.truth_at(seconds(4.1)).pose.x.m();
    // 25 % of 0.8 m.
    assert!((counted - gone - 0.2).abs() < 1e-3, "{counted} {gone}");
}

#[test]
fn a_stop_comes_late_and_a_new_velocity_replaces_it() {
    for request in [Request::Stop, velocity(0.0, 0.0)] {
        let mut base = base(BaseParameters::default());
        drive(&mut base, 0.0, 2.0);
        begin(&mut base, seconds(2.0), BaseFault::LateStop { by: Span::from_millis(300) });
        base.request(seconds(2.0), request);
        base.request(seconds(2.1), request);
        assert_eq!(base.truth_at(seconds(2.1)).speed.m_per_s(), 0.4);
        base.wake(seconds(2.3));
        base.wake(seconds(2.4));
        assert!(base.truth_at(seconds(2.4)).speed.m_per_s() < 0.4);
        base.request(seconds(2.4), velocity(0.4, 0.0));
        base.wake(seconds(5.0));
        assert_eq!(base.end_fault(seconds(5.0), 2), 1);
    }
    let mut base = base(BaseParameters::default());
    drive(&mut base, 0.0, 2.0);
    begin(&mut base, seconds(2.0), BaseFault::LateStop { by: Span::from_millis(300) });
    base.request(seconds(2.0), Request::Stop);
    drive(&mut base, 2.1, 3.0);
    assert_eq!(base.truth_at(seconds(3.0)).speed.m_per_s(), 0.4);
}

#[test]
fn the_emergency_stop_is_pressed_and_released() {
    let mut base = base(BaseParameters::default());
    drive(&mut base, 0.0, 2.0);
    begin(&mut base, seconds(2.0), BaseFault::EmergencyStop);
    let stopped = drive(&mut base, 2.0, 4.0);
    assert!(stopped.last().unwrap().1.emergency_stop && !stopped.last().unwrap().1.moving);
    base.end_fault(seconds(4.0), 2);
    assert!(drive(&mut base, 4.0, 5.0).last().unwrap().1.moving);
}

#[test]
fn an_encoder_that_jumps_turns_reports_and_pose_and_nothing_else() {
    for moving in [false, true] {
        let mut base = base(BaseParameters::default());
        if moving {
            drive(&mut base, 0.0, 2.0);
        }
        let before = base.truth_at(seconds(2.0)).pose;
        base.jump_encoder(seconds(2.0), Angle::from_deg(5.0));
        let told = motions(replies(&mut base, seconds(2.0), seconds(2.6)));
        assert!((told.last().unwrap().1.heading.deg() - 5.0).abs() < 0.2);
        assert_eq!(base.truth_at(seconds(2.6)).pose.heading, before.heading);
        assert!((base.truth_at(seconds(2.6)).pose.x - before.x).m() >= 0.0);
    }
}
