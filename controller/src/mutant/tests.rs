//! Each mutant misbehaves; the same scenario without it does not.

mod noticed;
mod plant;

use super::Mutant;
use crate::calibration::{Calibration, Factor};
use crate::mission::{
    AbortReason, BiasTest, Command, MissionResult, Refusal, Report, Straight, Turn,
};
use plant::Plant;
use std::vec::Vec;
use wire::time::Span;
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

fn turn(deg: f64, deg_per_s: f64) -> Command {
    Command::Turn(Turn {
        angle: Angle::from_deg(deg),
        rate: AngularRate::from_deg_per_s(deg_per_s),
    })
}

fn straight() -> Command {
    Command::Straight(Straight { distance: Length::from_m(2.0), speed: Speed::from_m_per_s(0.4) })
}

/// `misbehaves` runs the scenario and tells whether the controller misbehaved.
fn only_with(mutant: Mutant, misbehaves: fn(&mut Plant) -> bool) {
    assert!(misbehaves(&mut Plant::ready(Some(mutant))), "{mutant:?} shows nothing");
    assert!(!misbehaves(&mut Plant::ready(None)), "it shows without {mutant:?}");
}

#[test]
fn stale_heading() {
    only_with(Mutant::StaleHeading, |plant| {
        plant.begin(straight());
        plant.run(Span::from_secs(2));
        plant.gyro_speaks = false;
        plant.run(Span::from_secs(1));
        plant.drive > 0.0
    });
}

#[test]
fn ccw_sign() {
    only_with(Mutant::CcwSign, |plant| {
        let factors = [Factor::Constant(1.01)].into_iter().collect();
        plant.command(Command::SetCalibration(Calibration { factors, ..Calibration::default() }));
        let before = plant.heading;
        plant.command(turn(-90.0, 30.0));
        let cw = before - plant.heading;
        let before = plant.heading;
        plant.command(turn(90.0, 30.0));
        let ccw = plant.heading - before;
        (cw - ccw).abs() > 1f64.to_radians()
    });
}

#[test]
fn watchdog_off_by_ten() {
    only_with(Mutant::WatchdogOffByTen, |plant| {
        plant.begin(straight());
        plant.run(Span::from_secs(2));
        plant.base_speaks = false;
        plant.run(Span::from_millis(1_500));
        plant.drive > 0.0
    });
}

#[test]
fn bias_test_while_moving() {
    only_with(Mutant::BiasTestWhileMoving, |plant| {
        plant.begin(turn(180.0, 30.0));
        plant.run(Span::from_secs(3));
        plant.begin(Command::Stop);
        let report = plant.command(Command::BiasTest(BiasTest { duration_s: 1.0 }));
        assert!(matches!(
            report,
            Report::Done { .. } | Report::Refused { reason: Refusal::Moving, .. }
        ));
        matches!(report, Report::Done { .. })
    });
}

#[test]
fn wrap_at_360() {
    only_with(Mutant::WrapAt360, |plant| {
        let turned = |report| match report {
            Report::Done { result: MissionResult::Turn(turn), .. } => turn.gyro_angle.deg(),
            other => panic!("{other:?}"),
        };
        let angles: Vec<f64> = (0..4).map(|_| turned(plant.command(turn(90.0, 30.0)))).collect();
        angles.iter().any(|angle| (angle - 90.0).abs() > 1.0)
    });
}

#[test]
fn missed_sequence_gap() {
    only_with(Mutant::MissedSequenceGap, |plant| {
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(3));
        plant.gyro_speaks = false;
        plant.run(Span::from_millis(60));
        plant.gyro_speaks = true;
        plant.run(Span::from_secs(5));
        plant.heading_error().abs() > 1f64.to_radians()
    });
}

#[test]
fn pose_written_in_motion() {
    only_with(Mutant::PoseWrittenInMotion, |plant| {
        plant.command(straight());
        plant.written_in_motion > 0
    });
}

#[test]
fn overflow_after_long_runs() {
    only_with(Mutant::OverflowAfterLongRuns, |plant| {
        // The count overflows at 21,474.8 deg.
        plant.heading = 21_400f64.to_radians();
        let heading = Angle::from_rad(plant.heading);
        plant.command(Command::SetPose(Pose { heading, ..Pose::default() }));
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(4));
        plant.heading_error().abs() > 1.0
    });
}

#[test]
fn over_range_ignored() {
    only_with(Mutant::OverRangeIgnored, |plant| {
        plant.gyro_range = 80f64.to_radians();
        match plant.command(turn(720.0, 100.0)) {
            Report::Aborted { reason, .. } => {
                assert_eq!(reason, AbortReason::GyroFault);
                false
            }
            _ => true,
        }
    });
}

#[test]
fn repeated_sample_counted() {
    only_with(Mutant::RepeatedSampleCounted, |plant| {
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(1));
        plant.gyro_stutters = true;
        plant.run(Span::from_secs(1));
        plant.gyro_stutters = false;
        plant.heading_error().abs() > 1f64.to_radians()
    });
}

#[test]
fn names_are_their_own() {
    let mut names: Vec<_> = Mutant::ALL.iter().map(|mutant| mutant.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Mutant::ALL.len());
}
