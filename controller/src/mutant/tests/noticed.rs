//! Input faults that the controller must notice.

use super::{
    Mutant, only_with,
    plant::{Plant, Spoil},
    straight, turn,
};
use crate::mission::{BiasTest, Command};
use std::boxed::Box;
use wire::base::Request;
use wire::gyro::{GyroOutput, GyroSample};
use wire::time::Span;
use wire::units::{AngularRate, Temperature};

fn add(sample: &mut GyroSample, deg_per_s: f64) {
    if let GyroOutput::Rate(rate) = &mut sample.output {
        *rate += AngularRate::from_deg_per_s(deg_per_s);
    }
}

/// A different value for each sample, evenly spread over about +-0.04 deg/s.
fn noise(n: u32) -> f64 {
    (f64::from(n.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 - 0.5) * 0.08
}

#[test]
fn stuck_readings_believed() {
    only_with(Mutant::StuckReadingsBelieved, |plant: &mut Plant| {
        plant.spoil = Box::new(|sample, n| add(sample, noise(n)));
        plant.command(Command::BiasTest(BiasTest { duration_s: 2.0 }));
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(2));
        assert!(plant.is_told_to_move(), "noise is no fault");
        plant.spoil = Box::new(|sample, _| {
            sample.output = GyroOutput::Rate(AngularRate::from_deg_per_s(29.0));
        });
        plant.run(Span::from_millis(150));
        plant.is_told_to_move()
    });
}

#[test]
fn jump_believed() {
    only_with(Mutant::JumpBelieved, |plant| {
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(1));
        plant.spoil = Box::new(|sample, n| add(sample, if n % 20 == 0 { 70.0 } else { 0.0 }));
        plant.run(Span::from_secs(1));
        plant.spoil = Box::new(|_, _| {});
        plant.heading_error().abs() > 1f64.to_radians()
    });
}

#[test]
fn headings_not_compared() {
    only_with(Mutant::HeadingsNotCompared, |plant| {
        plant.spoil = Box::new(|sample, _| {
            if let GyroOutput::Rate(rate) = &mut sample.output {
                *rate = *rate * 0.9;
            }
        });
        plant.command(turn(90.0, 30.0));
        assert!(plant.heading_error().abs() > 5f64.to_radians());
        plant.is_well()
    });
}

#[test]
fn temperature_believed() {
    only_with(Mutant::TemperatureBelieved, |plant| {
        let told = |celsius| -> Spoil {
            Box::new(move |sample, _| sample.temperature = Some(Temperature::from_celsius(celsius)))
        };
        plant.spoil = told(25.0);
        plant.run(Span::from_secs(3));
        assert!(plant.is_well());
        plant.spoil = told(60.0);
        plant.run(Span::from_secs(3));
        plant.is_well()
    });
}

#[test]
fn a_frozen_temperature_believed() {
    only_with(Mutant::TemperatureBelieved, |plant| {
        plant.spoil = Box::new(|sample, _| {
            sample.temperature = Some(Temperature::from_celsius(22.0));
            sample.status.warming_up = true;
        });
        plant.run(Span::from_secs(55));
        assert!(plant.is_well());
        plant.run(Span::from_secs(10));
        plant.is_well()
    });
}

#[test]
fn lagging_odometer_believed() {
    only_with(Mutant::LaggingOdometerBelieved, |plant| {
        plant.begin(straight());
        plant.run(Span::from_secs(2));
        plant.odometer_stands = true;
        plant.run(Span::from_millis(360));
        plant.odometer_stands = false;
        plant.run(Span::from_millis(40));
        plant.is_well()
    });
}

#[test]
fn bump_ignored() {
    only_with(Mutant::BumpIgnored, |plant| {
        plant.run(Span::from_secs(1));
        plant.spoil = Box::new(|sample, _| add(sample, 2.5));
        plant.run(Span::from_millis(200));
        plant.heading += 0.5f64.to_radians();
        plant.spoil = Box::new(|_, _| {});
        plant.run(Span::from_secs(1));
        // A bias test clears a bias that seems to have moved, but not a heading.
        plant.command(Command::BiasTest(BiasTest { duration_s: 1.0 }));
        plant.is_well()
    });
}

#[test]
fn moved_bias_ignored() {
    only_with(Mutant::MovedBiasIgnored, |plant| {
        plant.spoil = Box::new(|sample, _| add(sample, 0.1));
        plant.command(straight());
        plant.is_well()
    });
}

#[test]
fn bias_test_forgives() {
    only_with(Mutant::BiasTestForgives, |plant| {
        plant.begin(turn(90.0, 30.0));
        plant.run(Span::from_secs(3));
        plant.gyro_speaks = false;
        plant.run(Span::from_millis(60));
        plant.gyro_speaks = true;
        plant.run(Span::from_secs(5));
        assert!(!plant.is_well());
        plant.command(Command::BiasTest(BiasTest { duration_s: 1.0 }));
        plant.is_well()
    });
}

#[test]
fn a_pose_that_is_set_makes_well() {
    let mut plant = Plant::ready(None);
    plant.gyro_speaks = false;
    plant.run(Span::from_millis(60));
    plant.gyro_speaks = true;
    plant.run(Span::from_secs(1));
    assert!(!plant.is_well());
    plant.command(Command::SetPose(wire::units::Pose::default()));
    assert!(plant.is_well());
}

/// Found by a campaign: the base's last word was from before the order, that it stands.
#[test]
fn a_base_that_was_ordered_to_move_stands_when_it_says_so_and_not_before() {
    for (unheard_ms, aborts) in [(100, false), (270, true)] {
        let mut plant = Plant::ready(None);
        plant.base_speaks = false;
        plant.begin(straight());
        plant.run(Span::from_millis(unheard_ms));
        assert_eq!(plant.is_well(), !aborts);
        plant.begin(Command::Stop);
        plant.run(Span::from_millis(30));
        assert!(plant.drive > 0.0 && !plant.is_said_to_stand(), "after {unheard_ms} ms");
        plant.run(Span::from_secs(1));
        assert!(!plant.is_said_to_stand() && !plant.is_well(), "nobody knows whether it stands");
        plant.base_speaks = true;
        plant.run(Span::from_millis(100));
        assert!(plant.is_said_to_stand() && plant.is_well());
    }
}

/// Found by a campaign: the orders were late by more than the base's time-out, and the base said meanwhile that it stands.
#[test]
fn a_base_that_was_not_seen_to_follow_may_still_be_on_the_way() {
    let mut plant = Plant::ready(None);
    plant.requests_late = Span::from_millis(600);
    plant.begin(straight());
    plant.run(Span::from_millis(100));
    plant.begin(Command::Stop);
    plant.run(Span::from_millis(60));
    assert!(!plant.is_told_to_move() && !plant.is_well(), "the order is on its way");
    plant.run(Span::from_millis(500));
    assert!(plant.is_told_to_move() && !plant.is_well());
    plant.run(Span::from_secs(1));
    plant.requests_late = Span::ZERO;
    assert!(plant.is_said_to_stand() && !plant.is_well(), "the pose is lost until it is set");
    plant.command(Command::SetPose(wire::units::Pose::default()));
    assert!(plant.is_well());
}

/// Found by a campaign: the ramps were lost on the bus, and a base with its own is slower to stop.
#[test]
fn ramps_are_sent_again_until_the_base_moves_and_with_each_stop() {
    for base_speaks in [true, false] {
        let mut plant = Plant::ready(None);
        plant.base_speaks = base_speaks;
        plant.begin(straight());
        plant.run(Span::from_millis(110));
        assert_eq!(plant.ramps_sent, if base_speaks { 1 } else { 5 });
        plant.begin(Command::Stop);
        plant.run(Span::from_millis(60));
        assert_eq!(plant.ramps_sent, if base_speaks { 3 } else { 7 });
        assert_eq!(plant.last, Some(Request::Stop), "what the base hears last");
    }
}
