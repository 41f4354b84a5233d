//! Effects that a plain odometry model lacks, each alone.

use super::super::{BaseEmulator, BaseParameters};
use super::{base, seconds, velocity};
use wire::base::Request;
use wire::units::{Acceleration, AngularAcceleration};

fn patient() -> BaseParameters {
    BaseParameters {
        command_timeout_s: f64::INFINITY,
        acceleration_max_m_per_s2: 1.0,
        ..Default::default()
    }
}

fn accelerate_by(base: &mut BaseEmulator, m_per_s2: f64, at_s: f64) {
    let drive = Acceleration::from_m_per_s2(m_per_s2);
    let steer = AngularAcceleration::from_deg_per_s2(30.0);
    base.request(seconds(at_s), Request::SetAcceleration { drive, steer });
}

/// Ratio of true to odometer path of a straight line from `start_s`, up to 0.4 m/s and down again.
fn path_ratio(base: &mut BaseEmulator, start_s: f64) -> f64 {
    let odometer = |base: &BaseEmulator, at| base.kinematics.state_at(seconds(at)).displacement;
    base.wake(seconds(start_s));
    let before = (base.truth_at(seconds(start_s)).pose.x.m(), odometer(base, start_s));
    base.request(seconds(start_s), velocity(0.4, 0.0));
    base.request(seconds(start_s + 8.0), velocity(0.0, 0.0));
    base.wake(seconds(start_s + 16.0));
    let end = start_s + 16.0;
    (base.truth_at(seconds(end)).pose.x.m() - before.0) / (odometer(base, end) - before.1)
}

#[test]
fn slip_goes_with_the_acceleration_beyond_what_holds() {
    // An acceleration ladder. A ramp of 0.4 m/s at a takes 0.08/a of the path of 3.2 m.
    for (acceleration, beyond) in [(0.1, 0.0), (0.2, 0.0), (0.4, 0.2), (0.8, 0.6)] {
        let ramp_share = 0.4 * 0.4 / 2.0 / acceleration / (0.4 * 8.0);
        for (driving, braking, expected) in [
            (0.05, 0.0, 1.0 - 0.05 * beyond * ramp_share),
            (0.0, 0.05, 1.0 + 0.05 * beyond * ramp_share),
            (0.05, 0.05, 1.0),
        ] {
            let mut base = base(BaseParameters {
                slip_driving_per_m_per_s2: driving,
                slip_braking_per_m_per_s2: braking,
                slip_free_m_per_s2: 0.2,
                ..patient()
            });
            accelerate_by(&mut base, acceleration, 0.0);
            let ratio = path_ratio(&mut base, 0.0);
            assert!((ratio - expected).abs() < 1e-9, "{acceleration}: {ratio} {expected}");
        }
    }
}

#[test]
fn tyres_grow_with_time() {
    let mut base = base(BaseParameters { tyre_growth_per_h: 0.001, ..patient() });
    for start_s in [0.0, 3_600.0, 16.0 * 3_600.0] {
        let ratio = path_ratio(&mut base, start_s);
        assert!((ratio - (1.0 + 0.001 * start_s / 3_600.0)).abs() < 1e-9, "{ratio}");
    }
}

#[test]
fn turns_may_be_larger_one_way_than_the_other() {
    for asymmetry in [0.002, -0.002] {
        for direction in [1.0, -1.0] {
            let mut base = base(BaseParameters { turn_scale_asymmetry: asymmetry, ..patient() });
            base.request(seconds(0.0), velocity(0.0, 30.0 * direction));
            base.request(seconds(12.0), velocity(0.0, 0.0));
            base.wake(seconds(20.0));
            let odometer = base.kinematics.state_at(seconds(20.0)).steered;
            let truth = base.truth_at(seconds(20.0)).steering_angle.rad();
            let expected = 1.0 + direction * asymmetry / 2.0;
            assert!((truth / odometer - expected).abs() < 1e-12, "{direction}");
        }
    }
}

#[test]
fn motors_draw_current_while_they_turn() {
    let mut base = base(patient());
    accelerate_by(&mut base, 0.4, 0.0);
    let now = |base: &BaseEmulator, at| base.motor_current_at(seconds(at));
    assert_eq!(now(&base, 0.0), 0.0);
    base.request(seconds(0.0), velocity(0.4, 0.0));
    assert!((now(&base, 0.5) - (4.0 + 10.0 * 0.4)).abs() < 1e-9);
    base.wake(seconds(3.0));
    assert_eq!(now(&base, 3.0), 4.0);
    base.request(seconds(3.0), velocity(0.0, 10.0));
    base.wake(seconds(6.0));
    assert_eq!(now(&base, 6.0), 2.0);
    base.request(seconds(6.0), velocity(0.0, 0.0));
    base.wake(seconds(9.0));
    assert_eq!(now(&base, 9.0), 0.0);
}
