//! The filter by itself.

use super::matrix::{STATES, Symmetric};
use super::travel::Travel;
use super::{Angle, AngularRate, Fault, HEADING, Kalman, Length, Step, Timestamp, X, Y};
use proptest::prelude::*;
use wire::time::Span;

const PERIOD_S: f64 = 0.01;

fn filter() -> Kalman {
    let mut kalman = Kalman::new(AngularRate::from_deg_per_s(0.0138), PERIOD_S);
    kalman.place();
    kalman
}

fn at(s: f64) -> Timestamp {
    Timestamp::from_secs_f64(s)
}

fn step(now_s: f64, passed_s: f64) -> Step {
    Step {
        now: at(now_s),
        passed_s,
        free_s: passed_s,
        gaps_s4: 0.0,
        turned: Angle::ZERO,
        bias: AngularRate::ZERO,
        path: Length::ZERO,
        heading: Angle::ZERO,
    }
}

fn at_rest(kalman: &mut Kalman, bias_deg: f64, seconds: u32) {
    for n in 0..seconds * 10 {
        let now = kalman.last.unwrap_or(Timestamp::ZERO) + Span::from_millis(100);
        let held = Step { now, free_s: 0.0, ..step(0.0, 0.1) };
        kalman.go_on(&held).unwrap();
        let noise = if n % 2 == 0 { 0.004 } else { -0.004 };
        kalman.at_rest(AngularRate::from_deg_per_s(bias_deg + noise), 10).unwrap();
    }
}

#[test]
fn a_bias_test_finds_the_bias_and_a_lap_loses_it_slowly() {
    let mut kalman = filter();
    at_rest(&mut kalman, 0.03, 20);
    assert!((kalman.bias().deg_per_s() - 0.03).abs() < 0.002, "{:?}", kalman.bias());
    let last = kalman.last.unwrap();
    for n in 1..=640 {
        let now = last + Span::from_millis(100) * n;
        kalman.go_on(&Step { now, ..step(0.0, 0.1) }).unwrap();
    }
    // The effect of the data sheet's drift and a 20 s test over 64 s: 0.18 deg.
    let heading = kalman.uncertainty().heading.deg();
    assert!((0.12..0.24).contains(&heading), "{heading}");
}

/// The first half of a drive uses a wrong bias, which the following standstill shows: the heading is corrected.
#[test]
fn a_standstill_mends_what_was_driven_before_it() {
    let mut kalman = filter();
    at_rest(&mut kalman, 0.0, 20);
    let last = kalman.last.unwrap();
    for n in 1..=100 {
        let now = last + Span::from_millis(100) * n;
        kalman.go_on(&Step { now, ..step(0.0, 0.1) }).unwrap();
    }
    let before = kalman.uncertainty().heading;
    let correction = kalman.at_rest(AngularRate::from_deg_per_s(0.008), 25).unwrap();
    assert!(correction.heading.deg() < -0.01, "{correction:?}");
    assert!(kalman.uncertainty().heading < before * 0.9);
}

#[test]
fn what_cannot_be_believed_is_let_go_and_too_much_of_it_is_said() {
    let mut kalman = filter();
    at_rest(&mut kalman, 0.0, 20);
    let before = kalman;
    assert_eq!(
        kalman.at_rest(AngularRate::from_deg_per_s(5.0), 25),
        Ok(super::Correction { is_foreign: true, ..Default::default() })
    );
    assert_eq!(kalman.believed, before.believed);
    let said = (0..20).find_map(|_| kalman.at_rest(AngularRate::from_deg_per_s(5.0), 25).err());
    assert_eq!(said, Some(Fault::Diverged));
}

/// Four standard deviations once are chance, and three times in a row are not, whatever the odometry says in between.
#[test]
fn a_bias_that_is_never_as_expected_has_moved() {
    let mut kalman = filter();
    at_rest(&mut kalman, 0.0, 200);
    let spread = {
        let mut seen = [0.0; STATES];
        seen[super::DRIFT..=super::CONSTANT].fill(1.0);
        let known = super::matrix::dot(&seen, &kalman.covariance.times(&seen));
        (known + kalman.reading_variance / 10.0).sqrt()
    };
    let off = kalman.bias() + AngularRate::from_rad_per_s(4.0 * spread);
    let foreign = [0.0, 0.01, 0.02].map(|apart_deg| {
        kalman.travel(&Travel::new(Angle::from_rad(1.0), Length::ZERO, Angle::ZERO));
        kalman.odometry(Angle::from_deg(apart_deg)).unwrap();
        kalman.at_rest(off, 10).unwrap().is_foreign
    });
    assert_eq!(foreign, [false, false, true]);
}

#[test]
fn a_drive_errs_along_its_way_by_a_millimetre() {
    for (heading_deg, along, across) in [(0.0, X, Y), (90.0, Y, X)] {
        let mut kalman = filter();
        at_rest(&mut kalman, 0.0, 20);
        kalman.place();
        let drive = Travel::new(Angle::ZERO, Length::from_m(4.0), Angle::from_deg(heading_deg));
        kalman.travel(&drive);
        kalman.odometry(Angle::ZERO).unwrap();
        let deviation = |state| kalman.covariance.variance(state).sqrt();
        assert!((deviation(along) - 0.001).abs() < 1e-9, "{}", deviation(along));
        assert!(deviation(across) < 1e-9, "{}", deviation(across));
    }
}

#[test]
fn each_thing_that_must_not_be_has_its_name() {
    let mut kalman = filter();
    kalman.go_on(&step(5.0, 0.1)).unwrap();
    assert_eq!(kalman.go_on(&step(4.0, 0.1)), Err(Fault::TimeRanBack));
    assert_eq!(kalman.go_on(&step(6.0, -0.1)), Err(Fault::TimeRanBack));
    assert_eq!(kalman.go_on(&step(6.0, f64::NAN)), Err(Fault::NotANumber));
    assert_eq!(kalman.at_rest(AngularRate::from_rad_per_s(f64::NAN), 9), Err(Fault::NotANumber));
    assert_eq!(kalman.odometry(Angle::from_rad(f64::INFINITY)), Err(Fault::NotANumber));
    let wrapped = Step { path: Length::from_m(-400_000.0), ..step(6.0, 0.1) };
    assert_eq!(kalman.go_on(&wrapped), Err(Fault::PathJumped));
    kalman.covariance.set_variance(HEADING, -1.0);
    assert_eq!(kalman.go_on(&step(6.0, 0.1)), Err(Fault::NotPositive));
    // A step without elapsed time is not a fault and changes nothing.
    let mut kalman = filter();
    kalman.go_on(&step(5.0, 0.1)).unwrap();
    let before = kalman;
    kalman.go_on(&step(5.0, 0.0)).unwrap();
    assert_eq!(kalman, before);
}

#[test]
fn a_covariance_is_kept_symmetric() {
    let mut covariance = Symmetric::default();
    (0..STATES).for_each(|state| covariance.set_variance(state, 1.0 + state as f64));
    covariance.add_to(0, &[(1, 2.0), (2, -3.0)]);
    // 1 + 4 * 2 + 9 * 3
    assert_eq!(covariance.variance(0), 36.0);
    let mut first = [0.0; STATES];
    first[1] = 1.0;
    assert_eq!(covariance.times(&first)[0], 4.0);
    assert!(covariance.is_positive());
}

proptest! {
    /// For any input: no panic, and a state that it calls valid is a covariance.
    #[test]
    fn it_survives_anything(
        feed in prop::collection::vec((0u8..4, any::<f64>(), -3.0f64..3.0, 0.0f64..2.0), 1..200),
    ) {
        let mut kalman = filter();
        let mut now = 0.0;
        for (what, wild, tame, passed_s) in feed {
            now += passed_s;
            let value = if what == 3 { wild } else { tame };
            let came = match what {
                0 => kalman.go_on(&Step {
                    turned: Angle::from_rad(value),
                    gaps_s4: value.abs(),
                    path: Length::from_m(value * 0.1),
                    ..step(now, passed_s)
                }),
                1 => kalman.at_rest(AngularRate::from_rad_per_s(value * 1e-3), 10),
                2 => kalman.odometry(Angle::from_rad(value * 0.01)),
                _ => kalman.bridge(Angle::from_rad(value), Length::from_m(tame), Angle::ZERO),
            };
            if came.is_err() {
                break;
            }
            prop_assert!(kalman.covariance.is_positive() && kalman.bias().is_finite());
        }
    }
}
