//! Effects of faults of host, operator, bus and phases on a run.

use super::{FaultEvent, Record, RecordKind, prepared, run, told};
use controller::mission::Report;
use record::Device;
use wire::time::Span;

fn fault(text: &str) -> String {
    format!("[[fault]]\n{text}\n")
}

/// Times at which the controller reported anything.
fn reported(records: &[Record]) -> Vec<f64> {
    let reports = records.iter().filter(|record| {
        record.device == Device::Controller && matches!(record.kind, RecordKind::Report(_))
    });
    reports.map(|record| record.at.as_secs_f64()).collect()
}

fn reasons(records: &[Record]) -> String {
    let texts = records
        .iter()
        .map(|record| record::text::Line(record, &record::header::Header::default()).to_string());
    texts.filter(|text| !text.contains("state")).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_controller_that_is_not_scheduled_says_nothing_and_then_all() {
    let stall =
        fault("target = \"host\"\nwhat = { scheduler_stall = { for_s = 1 } }\nwhen = { at_s = 3 }");
    let (run, records) = run(&prepared("paper", &stall));
    let spoken = reported(&records);
    assert!(!spoken.iter().any(|at| (3.000_1..3.999_9).contains(at)), "{}", reasons(&records));
    assert!(spoken.iter().any(|at| (2.0..3.0).contains(at)));
    assert!(spoken.contains(&4.0), "all at once when it goes on");
    // 100 samples of the gyro, and the messages of the base.
    assert!(run.faults[0].acted > 100);
}

/// Found by campaigns: nothing could say that the base stood, and the run ended in an error.
#[test]
fn a_stall_that_outlasts_the_plan_ends_with_it() {
    let calm = run(&prepared("paper", "")).0;
    let stall = fault(&format!(
        "target = \"host\"\nwhat = {{ scheduler_stall = {{ for_s = 60 }} }}\nwhen = {{ at_s = {} }}",
        calm.end.as_secs_f64() - 0.3
    ));
    let (run, records) = run(&prepared("paper", &stall));
    assert!(
        run.faults[0].begun && run.end - calm.end < Span::from_secs(1),
        "{}",
        reasons(&records)
    );
    assert_eq!(run.ending.outcome, calm.ending.outcome);
}

#[test]
fn a_clock_that_steps_back_and_forth_makes_no_panic_and_the_run_ends() {
    for step_s in [-3_600.0, -0.5, 0.02, 3_600.0] {
        let step = fault(&format!(
            "target = \"host\"\nwhat = {{ clock_step = {{ step_s = {step_s:?} }} }}\n\
             when = {{ at_s = 3 }}\nduration_s = 1"
        ));
        let (run, records) = run(&prepared("paper", &step));
        assert_eq!((run.faults[0].begun, run.faults[0].acted), (true, 1), "{}", reasons(&records));
        assert!(run.end.as_secs_f64() < 120.0);
    }
}

#[test]
fn a_person_in_another_unit_and_with_the_wrong_sign() {
    let faults = fault("target = \"operator\"\nwhat = { wrong_unit = { factor = 1000 } }")
        + &fault("target = \"operator\"\nwhat = { wrong_sign = { wrong_percent = 100 } }");
    let (run, records) = run(&prepared("paper", &faults));
    let mass = run.observations.of("operator.mass").next().unwrap();
    assert_eq!(mass.value(), -3_000.0);
    let replied = records.iter().find_map(|record| match &record.kind {
        RecordKind::Reply(reply) => reply.number.as_ref().map(|number| number.value),
        _ => None,
    });
    assert_eq!(replied, Some(-3_000.0), "the record says what was answered");
    assert_eq!([run.faults[0].acted, run.faults[1].acted], [1, 1]);
}

#[test]
fn a_fault_during_the_second_turn_is_on_then_and_no_longer() {
    let during = fault(
        "target = \"gyro\"\nwhat = { bias_step = { deg_per_h = 1 } }\n\
         when = { during = \"turn\", number = 2 }",
    );
    let (_, records) = run(&prepared("paper", &during));
    let turned = |record: &Record| match &record.kind {
        RecordKind::Command(command) => {
            matches!(**command, controller::mission::Command::Turn(_)).then_some(record.at)
        }
        _ => None,
    };
    let turns: Vec<f64> = records.iter().filter_map(turned).map(|at| at.as_secs_f64()).collect();
    let done = records.iter().filter(|record| {
        matches!(record.kind, RecordKind::Report(Report::Done { .. }))
            && record.at.as_secs_f64() > turns[1]
    });
    let done = done.map(|record| record.at.as_secs_f64()).next().unwrap();
    let told = told(&records);
    assert_eq!((told[0].0, told[1].0), (turns[1], done));
    assert!(matches!(told[1].1.event, FaultEvent::Ended { acted } if acted > 100));
}

#[test]
fn the_second_round_of_a_label_begins_after_the_first() {
    let of_label = |number: u32| {
        fault(&format!(
            "target = \"gyro\"\nwhat = {{ stuck = {{ for_s = 0.1 }} }}\n\
             when = {{ step = \"turning\", number = {number}, after_s = 0.25 }}"
        ))
    };
    let (_, records) = run(&prepared("paper", &(of_label(1) + &of_label(2))));
    let began: Vec<f64> = told(&records)
        .iter()
        .filter(|(_, fault)| fault.event == FaultEvent::Began)
        .map(|(at, _)| *at)
        .collect();
    assert!(began.len() == 2 && began[1] > began[0] + 1.0, "{began:?}");
}

#[test]
fn a_bus_full_of_errors_takes_the_base_off_and_the_record_says_so() {
    let errors = fault(
        "target = \"base\"\ntoward = \"host\"\nwhat = { bit_errors = { bit_error_rate = 0.02 } }\n\
         when = { at_s = 3 }\nduration_s = 1",
    );
    let (_, records) = run(&prepared("paper", &errors));
    let states: Vec<String> = told(&records)
        .iter()
        .filter_map(|(_, fault)| match &fault.event {
            FaultEvent::Confinement { node, state, .. } if node == "base" => Some(state.clone()),
            _ => None,
        })
        .collect();
    assert!(states.len() >= 3, "{states:?}");
    assert_eq!(states[..3], ["error-passive", "bus-off", "error-active"]);
}

#[test]
fn a_table_that_loses_steps_turns_less_than_it_says() {
    let lost = fault("target = \"table\"\nwhat = { lost_steps = { steps = 80 } }");
    let angle = |faults: &str| {
        let (run, _) = run(&prepared("paper-table", faults));
        run.observations.of("table.angle").next().unwrap().value()
    };
    let difference = angle(&lost) - angle("");
    assert!((difference + 1.0).abs() < 0.05, "80 steps of 0.0125 deg: {difference}");
}
