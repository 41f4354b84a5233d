//! Inapplicable faults are rejected at their place.

use super::errors::rendered;
use crate::Plan;
use crate::faults::Lines;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};

const PLAN: &str = r#"name = "p"
title = "a plan"
devices = "paper"
steps = [
  { repeat = { times = 3, steps = [
      { bias_test = {} },
      { lap = { direction = "cw" }, label = "round" },
  ] } },
]
[[measurement]]
name = "m"
doc = "d"
quantity = "lap.gyro_error"
unit = "deg"
check = { all_within = [-1, 1] }
"#;

fn with(fault: &str) -> String {
    format!("{PLAN}\n[[fault]]\n{fault}\n")
}

#[test]
fn phases_are_counted_through_repeats_and_laps() {
    let plan = Plan::parse("p.toml", PLAN).unwrap();
    let phases: Vec<_> = plan.phases().into_iter().collect();
    assert_eq!(
        phases,
        [("bias_test", 3), ("lap", 3), ("repeat", 3), ("round", 3), ("straight", 12), ("turn", 12)]
    );
    let twelfth = "target = \"gyro\"\nwhat = { stuck = { for_s = 1 } }\n\
                   when = { during = \"turn\", number = 12 }";
    assert!(Plan::parse("p.toml", &with(twelfth)).is_ok());
}

#[test]
fn what_cannot_apply_is_shown_in_place() {
    let stuck = "target = \"gyro\"\nwhat = { stuck = { for_s = 1 } }\n";
    let drop = "target = \"gyro\"\nwhat = { drop = { loss_percent = 1 } }\n";
    let cases = [
        ("an unknown kind", "target = \"gyro\"\nwhat = { stcuk = { for_s = 1 } }".to_owned()),
        ("an unknown parameter", "target = \"gyro\"\nwhat = { drop = { share = 1 } }".to_owned()),
        ("too much", "target = \"gyro\"\nwhat = { drop = { loss_percent = 101 } }".to_owned()),
        ("no number", "target = \"gyro\"\nwhat = { drop = { loss_percent = nan } }".to_owned()),
        ("a wrong target", "target = \"base\"\nwhat = { stuck = { for_s = 1 } }".to_owned()),
        ("a direction of no line", format!("{stuck}toward = \"host\"")),
        ("a duration twice", format!("{stuck}duration_s = 2")),
        ("a phase that is none", format!("{drop}when = {{ during = \"lpa\" }}")),
        ("a phase too many", format!("{drop}when = {{ step = \"turn\", number = 13 }}")),
        ("two times at once", format!("{drop}when = {{ at_s = 1, step = \"lap\" }}")),
        ("the zeroth", format!("{drop}when = {{ step = \"lap\", number = 0 }}")),
        ("after the end", format!("{drop}when = {{ at_s = 1e6 }}")),
        ("never at all", format!("{drop}probability = 0")),
        ("long after the end", format!("{drop}when = {{ step = \"lap\", after_s = 1e6 }}")),
        (
            "two that may contradict",
            format!(
                "{stuck}when = {{ step = \"bias_test\" }}\n[[fault]]\ntarget = \"gyro\"\n\
                 what = {{ restart = {{ for_s = 2 }} }}\nwhen = {{ during = \"bias_test\" }}"
            ),
        ),
        (
            "two that contradict",
            format!(
                "{stuck}when = {{ at_s = 10 }}\n[[fault]]\ntarget = \"gyro\"\n\
                 what = {{ restart = {{ for_s = 2 }} }}\nwhen = {{ at_s = 9 }}"
            ),
        ),
    ];
    let shown: Vec<String> = cases
        .iter()
        .map(|(title, fault)| {
            let error = Plan::parse("p.toml", &with(fault)).expect_err(title);
            format!("## {title}\n{}", rendered(&error))
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

const NAVIGATOR: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

#[test]
fn a_property_of_what_the_bench_has_not_is_shown_in_place() {
    let cases = [
        ("no bus", "sometimes = \"bus_off\"", Lines::SERIAL_BASE),
        ("no base", "sometimes = \"base_silent\"", Lines::TABLE),
        (
            "a heading of the future",
            "always = { fresh_heading = { age_s_max = 0.001 } }",
            Lines::CAN_BASE,
        ),
    ];
    let shown: Vec<String> = cases
        .iter()
        .map(|(title, property, lines)| {
            let text = format!("{PLAN}\n[[property]]\n{property}\n");
            let plan = Plan::parse("p.toml", &text).unwrap();
            let error = plan.check_lines("p.toml", &text, lines, Some(NAVIGATOR)).expect_err(title);
            format!("## {title}\n{}", rendered(&error))
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn what_the_bench_has_not_is_shown_in_place() {
    let cases = [
        ("a base", "target = \"base\"\nwhat = { drop = { loss_percent = 1 } }", Lines::TABLE),
        ("a table", "target = \"table\"\nwhat = { lost_steps = { steps = 8 } }", Lines::CAN_BASE),
        (
            "a bus",
            "target = \"base\"\nwhat = { babble = { frames_per_s = 1 } }",
            Lines::SERIAL_BASE,
        ),
        (
            "a serial line",
            "target = \"base\"\nwhat = { flip = { flip_percent = 1 } }",
            Lines::CAN_BASE,
        ),
    ];
    let shown: Vec<String> = cases
        .iter()
        .map(|(title, fault, lines)| {
            let text = with(fault);
            let plan = Plan::parse("p.toml", &text).unwrap();
            let error = plan.check_lines("p.toml", &text, lines, Some(NAVIGATOR)).expect_err(title);
            format!("## {title}\n{}", rendered(&error))
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}
