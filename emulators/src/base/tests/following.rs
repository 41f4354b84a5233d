//! How drive and steering follow their commands: noise, stiction, play.

use super::super::{BaseEmulator, BaseParameters, Transport};
use super::{any_request, base, looked_at, seconds, velocity};
use proptest::prelude::*;
use wire::base::Request;
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, AngularAcceleration};

fn patient() -> BaseParameters {
    BaseParameters { command_timeout_s: f64::INFINITY, ..Default::default() }
}

/// The steering's encoder and the true angle, in degrees.
fn steering(base: &BaseEmulator, at_s: f64) -> (f64, f64) {
    let state = base.kinematics.state_at(seconds(at_s));
    (state.steered.to_degrees(), state.truth.steer.to_degrees())
}

/// Turns at `deg_per_s` for 3 s and waits for rest: 8 s in all.
fn turn(base: &mut BaseEmulator, at_s: f64, deg_per_s: f64) -> (f64, f64) {
    base.request(seconds(at_s), velocity(0.0, deg_per_s));
    base.request(seconds(at_s + 3.0), velocity(0.0, 0.0));
    base.wake(seconds(at_s + 8.0));
    steering(base, at_s + 8.0)
}

#[test]
fn the_steering_loses_its_play_at_each_reversal() {
    let mut base = base(BaseParameters { steering_play_deg: 0.4, ..patient() });
    let mut lost = 0.0;
    for (n, (deg_per_s, loses)) in
        [(30.0, 0.0), (30.0, 0.0), (-30.0, -0.4), (-10.0, 0.0), (5.0, 0.4), (-30.0, -0.4)]
            .into_iter()
            .enumerate()
    {
        let (encoder, truth) = turn(&mut base, 8.0 * n as f64, deg_per_s);
        lost += loses;
        assert!((encoder - truth - lost).abs() < 1e-6, "{n}: {encoder} {truth}");
    }
}

#[test]
fn play_is_no_scale_error_of_one_way_turns() {
    for direction in [1.0, -1.0] {
        let parameters =
            BaseParameters { turn_scale_error: 0.01, steering_play_deg: 0.4, ..patient() };
        let mut base = base(parameters);
        let first = turn(&mut base, 0.0, 30.0 * direction);
        let second = turn(&mut base, 8.0, 30.0 * direction);
        assert!(((second.1 - first.1) / (second.0 - first.0) - 1.01).abs() < 1e-9);
    }
}

#[test]
fn while_play_is_taken_up_the_turret_stands() {
    let mut base = base(BaseParameters { steering_play_deg: 0.5, ..patient() });
    turn(&mut base, 0.0, 30.0);
    let before = steering(&base, 8.0);
    base.request(seconds(8.0), velocity(0.0, -10.0));
    // Half of a ramp of 21 deg/s^2 for 0.2 s is 0.42 deg; the play is 0.5.
    base.wake(seconds(8.2));
    let truth = base.truth_at(seconds(8.2));
    assert_eq!((truth.steering_angle.deg(), truth.steer_rate.deg_per_s()), (before.1, 0.0));
    assert!((steering(&base, 8.2).0 - before.0 + 0.42).abs() < 1e-6);
    base.wake(seconds(8.3));
    assert!(base.truth_at(seconds(8.3)).steer_rate.deg_per_s() < -6.0);
}

#[test]
fn below_its_stiction_a_drive_stands() {
    let parameters = BaseParameters {
        drive_stiction_m_per_s: 0.005,
        steering_stiction_deg_per_s: 0.5,
        ..patient()
    };
    let mut base = base(parameters);
    base.request(seconds(0.0), velocity(0.0049, -0.49));
    base.wake(seconds(10.0));
    let truth = base.truth_at(seconds(10.0));
    assert_eq!(
        (truth.speed.m_per_s(), truth.pose, truth.steer_rate.deg_per_s()),
        Default::default()
    );
    assert!(base.kinematics.is_moving(), "it has the command to");
    base.request(seconds(10.0), velocity(0.005, -0.5));
    base.wake(seconds(20.0));
    let truth = base.truth_at(seconds(20.0));
    assert_eq!(truth.speed.m_per_s(), 0.005);
    assert!((truth.steer_rate.deg_per_s() + 0.5).abs() < 1e-12);
}

#[test]
fn a_ramp_loses_what_lies_below_the_stiction_at_both_ends() {
    let path = |stiction| {
        let mut base = base(BaseParameters { drive_stiction_m_per_s: stiction, ..patient() });
        base.request(seconds(0.0), velocity(0.4, 0.0));
        base.request(seconds(5.0), velocity(0.0, 0.0));
        base.wake(seconds(10.0));
        base.kinematics.odometers_at(seconds(10.0)).0
    };
    // v^2 / 2a at each end, at 0.25 m/s^2.
    let lost: f64 = path(0.0) - path(0.05);
    assert!((lost - 0.05 * 0.05 / 0.25).abs() < 1e-9, "{lost}");
}

/// Paths of the odometer in intervals of 100 ms at 0.4 m/s, minus the commanded ones.
fn noise_of_the_path(parameters: &BaseParameters, name: &str) -> Vec<f64> {
    let mut base = BaseEmulator::new(parameters.clone(), Transport::Can, 1, name);
    base.request(seconds(0.0), velocity(0.4, 10.0));
    let at = |n: u32| seconds(2.0 + 0.1 * f64::from(n));
    base.wake(at(0));
    let mut last = base.kinematics.odometers_at(at(0)).0;
    (1..=2_000)
        .map(|n| {
            base.wake(at(n));
            let path = base.kinematics.odometers_at(at(n)).0;
            path - std::mem::replace(&mut last, path) - 0.04
        })
        .collect()
}

#[test]
fn noise_has_its_size_and_numbers_of_its_own() {
    let parameters = BaseParameters { drive_noise_m_per_s: 0.004, ..patient() };
    let noise = noise_of_the_path(&parameters, "base");
    let rms = (noise.iter().map(|x| x * x).sum::<f64>() / 2_000.0).sqrt();
    let mean = noise.iter().sum::<f64>() / 2_000.0;
    // Standard errors: 1.6 % of the rms, and the rms over the root of 2,000.
    assert!((rms / 0.0004 - 1.0).abs() < 0.06, "{rms}");
    assert!(mean.abs() < 4.0 * 0.0004 / 2_000f64.sqrt(), "{mean}");
    assert_eq!(noise, noise_of_the_path(&parameters, "base"));
    assert_ne!(noise, noise_of_the_path(&parameters, "other"));
    let both = BaseParameters { steering_noise_deg_per_s: 0.3, ..parameters };
    for (alone, both) in noise.iter().zip(noise_of_the_path(&both, "base")) {
        assert!((alone - both).abs() < 1e-9);
    }
}

#[test]
fn stops_scatter_by_noise_and_stand() {
    let mut base = base(BaseParameters { drive_noise_m_per_s: 0.004, ..patient() });
    let stops: Vec<f64> = (0..50)
        .map(|n| {
            let start = 10.0 * f64::from(n);
            let before = base.kinematics.odometers_at(seconds(start)).0;
            base.request(seconds(start), velocity(0.1, 0.0));
            base.request(seconds(start + 5.0), velocity(0.0, 0.0));
            base.wake(seconds(start + 7.0));
            let path = base.kinematics.odometers_at(seconds(start + 7.0)).0 - before;
            base.wake(seconds(start + 10.0));
            assert_eq!(base.kinematics.odometers_at(seconds(start + 10.0)).0 - before, path);
            path - 0.5
        })
        .collect();
    // 50 intervals of 0.1 s at 4 mm/s: 0.4 mm times the root of 50.
    let rms = (stops.iter().map(|x| x * x).sum::<f64>() / 50.0).sqrt();
    assert!((0.5..1.5).contains(&(rms / (0.0004 * 50f64.sqrt()))), "{rms}");
}

/// All imperfections at once.
fn rough() -> impl Strategy<Value = BaseParameters> {
    (0f64..1.0, 0f64..0.05, 0f64..5.0, 0f64..0.05, 0f64..5.0).prop_map(
        |(play, drive_stiction, steering_stiction, drive_noise, steering_noise)| BaseParameters {
            steering_play_deg: play,
            drive_stiction_m_per_s: drive_stiction,
            steering_stiction_deg_per_s: steering_stiction,
            drive_noise_m_per_s: drive_noise,
            steering_noise_deg_per_s: steering_noise,
            leakage_deg_per_m: 0.125,
            ..Default::default()
        },
    )
}

/// How far the encoder may go back within the millisecond of a reversal, without the truth following: noise at most
/// doubles the steering's 120 deg/s^2.
const BACK_DEG: f64 = 0.5 * 240.0 * 1e-6;

proptest! {
    /// Encoder and truth differ by the play only, and the truth moves with the encoder or not at all.
    #[test]
    fn the_truth_follows_the_encoder_within_the_play(
        parameters in rough(),
        requests in prop::collection::vec((1i64..1_500, any_request()), 1..8),
    ) {
        let play = parameters.steering_play_deg;
        let mut base = base(parameters);
        let mut now = Timestamp::ZERO;
        let mut last = (0.0, 0.0);
        for (millis, request) in requests {
            base.request(now, request);
            for _ in 0..millis {
                now += Span::from_millis(1);
                base.wake(now);
                let (encoder, truth) = steering(&base, now.as_secs_f64());
                let within = -play - 1e-6..=1e-6;
                prop_assert!(within.contains(&(encoder - truth)), "{} of {play}", encoder - truth);
                let (turned, moved) = (encoder - last.0, truth - last.1);
                prop_assert!(moved * turned >= -(BACK_DEG * BACK_DEG), "{moved} {turned}");
                prop_assert!(moved.abs() <= turned.abs() + BACK_DEG, "{moved} {turned}");
                last = (encoder, truth);
            }
        }
    }

    /// A drive never moves against its command nor faster than twice the command.
    #[test]
    fn noise_turns_nothing_round(
        parameters in rough(),
        commanded in prop::collection::vec(((1i64..1_500), -0.5f64..0.5, -60f64..60.0), 1..8),
    ) {
        let mut exact = base(BaseParameters::default());
        let mut noisy = base(parameters);
        let mut now = Timestamp::ZERO;
        for (millis, m_per_s, deg_per_s) in commanded {
            for base in [&mut exact, &mut noisy] {
                let drive = Acceleration::from_m_per_s2(0.4);
                let steer = AngularAcceleration::from_deg_per_s2(15.0);
                base.request(now, Request::SetAcceleration { drive, steer });
                base.request(now, velocity(m_per_s, deg_per_s));
            }
            for _ in 0..millis {
                now += Span::from_millis(1);
                exact.wake(now);
                noisy.wake(now);
                let (commanded, goes) = (exact.kinematics.rates_at(now), noisy.kinematics.rates_at(now));
                for (commanded, goes) in [(commanded.0, goes.0), (commanded.1, goes.1)] {
                    prop_assert!(commanded * goes >= -1e-9, "{commanded} {goes}");
                    prop_assert!(goes.abs() <= 2.0 * commanded.abs() + 1e-6, "{commanded} {goes}");
                }
            }
        }
    }

    /// A phase ends at a draw, where a level is passed, or where play is taken up: a few times in 100 ms.
    #[test]
    fn phases_are_few(
        parameters in rough(), requests in prop::collection::vec((1i64..2_000_000_000, any_request()), 1..8),
    ) {
        let mut base = base(parameters);
        let mut now = Timestamp::ZERO;
        for (gap, request) in requests {
            base.request(now, request);
            let until = now + Span::from_nanos(gap);
            let mut phases = 0;
            while base.next_change() <= until {
                phases += 1;
                base.wake(base.next_change());
            }
            prop_assert!(phases <= 100, "{phases} in {gap} ns");
            now = until;
            base.wake(now);
        }
    }

    /// The state does not depend on how often it is read, to the last bit.
    #[test]
    fn looking_changes_nothing(
        parameters in rough(),
        requests in prop::collection::vec((1i64..2_000_000_000, any_request()), 1..8),
        looks in prop::collection::vec(1i64..50_000_000, 1..20),
    ) {
        looked_at(parameters, requests, &looks)?;
    }
}
