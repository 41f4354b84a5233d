//! The paper's procedures can be written as plans with the intended meaning.

use crate::check::AllWithin;
use crate::{Action, Band, Check, Condition, Plan, Step};
use std::num::NonZeroU32;
use wire::time::Span;
use wire::units::{Angle, AngularAcceleration, AngularRate};

fn plan(text: &str) -> Plan {
    Plan::parse("plan.toml", text)
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

#[test]
fn the_verification_of_fig_6() {
    let plan = plan(include_str!("verification.toml"));
    assert_eq!(plan.name.as_str(), "verification");
    assert_eq!(plan.steps.len(), 3);
    let Action::Repeat(repeat) = &plan.steps[2].action else { panic!("a repeat") };
    assert_eq!((repeat.times, repeat.period), (20, Some(Span::from_secs(120))));
    let Action::TableTurn(turn) = &repeat.steps[1].action else { panic!("a turn") };
    assert_eq!(turn.angle, Angle::from_deg(-360.0));
    assert_eq!(turn.rate, AngularRate::from_deg_per_s(30.0));
    assert_eq!(turn.acceleration, AngularAcceleration::from_deg_per_s2(15.0));
    let cw = &plan.measurements[0];
    assert_eq!(cw.check, Check::AllWithin(AllWithin(Band::new(-0.25, 0.25).unwrap())));
    assert_eq!(cw.observations_min, NonZeroU32::new(20).unwrap());
    // 10 + 7,210 + 20 x (30 + 52 + 52) + 10, because the limits of a round exceed its period.
    assert_eq!(plan.time_limit(), Span::from_secs(9_910));
}

#[test]
fn every_step_and_every_check_can_be_written() {
    let plan = plan(include_str!("everything.toml"));
    let mut written = Vec::new();
    collect(&plan.steps, &mut written);
    let of_device = self::plan(include_str!("device.toml"));
    collect(&of_device.steps, &mut written);
    let asks = Action::words().into_iter().find(|word| word.name == "uds").unwrap().example;
    let measured = "[[measurement]]\nname = \"m\"\ndoc = \"m\"\nquantity = \"step.duration\"\nunit = \"s\"\n\
                    check = { all_within = [0, 1] }\n";
    let of_ecu = format!("name = \"p\"\ntitle = \"p\"\nrig = \"r\"\nsteps = [{asks}]\n{measured}");
    collect(&self::plan(&of_ecu).steps, &mut written);
    let of_canopen = self::plan(include_str!("canopen.toml"));
    collect(&of_canopen.steps, &mut written);
    for name in Action::NAMES {
        assert!(written.contains(name), "no step `{name}`");
    }
    insta::assert_snapshot!(titles(&plan.steps, 0));
    let checks: Vec<_> = plan.measurements.iter().map(|m| m.check.name()).collect();
    insta::assert_snapshot!(checks.join(" "), @"all_within never_outside share_within all_but_within all_but_in_square mean_within rms_within rms_ratio_within slope_within slope_within intercept_within correlation_within eventually_within umbmark_within umbmark_within all_within all_within");
}

#[test]
fn waiting_for_a_steady_temperature() {
    let plan = plan(include_str!("everything.toml"));
    let Action::WaitUntil(Condition::Steady { quantity, change_at_most, over }) =
        &plan.steps[1].action
    else {
        panic!("a condition");
    };
    assert_eq!(quantity.as_str(), "gyro.temperature");
    assert_eq!((*change_at_most, *over), (0.1, Span::from_secs(600)));
}

fn collect(steps: &[Step], names: &mut Vec<&'static str>) {
    for step in steps {
        names.push(step.action.name());
        collect(step.action.steps(), names);
    }
}

fn titles(steps: &[Step], depth: usize) -> String {
    let line = |step: &Step| {
        let limit = step.time_limit().as_secs_f64();
        let within = titles(step.action.steps(), depth + 1);
        format!("{:depth$}{step}  [{limit:.0} s]\n{within}", "", depth = 2 * depth)
    };
    steps.iter().map(line).collect()
}
