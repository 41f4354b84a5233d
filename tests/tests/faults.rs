//! Faults in whole runs: each kind acts, each run is repeatable, and runs without faults are not affected.

mod effects;
mod kinds;

use harness::operator::Answers;
use harness::run::{Ended, Prepared, simulate};
use record::outcome::Outcome;
use record::sink::{FileSink, Level, MemorySink};
use record::{FaultEvent, FaultRecord, FaultSummary};
use record::{Record, RecordKind};
use std::collections::BTreeMap;
use tests::devices::shipped;
use tests::plans;

/// Rests, drives and turns, after asking for a number.
const ROBOT: &str = r#"
steps = [
    { operator_prompt = { text = "Read it", answer = { name = "mass", unit = "kg", range = [-1e9, 1e9] } } },
    { bias_test = { duration_s = 2 } },
    { straight = { distance_m = 1 } },
    { repeat = { times = 2, steps = [{ turn = { angle_deg = 45 } }] }, label = "turning" },
    { wait = { duration_s = 1 } },
]
[[measurement]]
name = "mass"
doc = "What was answered"
quantity = "operator.mass"
unit = "kg"
check = { all_within = [-1e9, 1e9] }
"#;

/// Turns the table.
const TABLE: &str = r#"
steps = [{ bias_test = { duration_s = 2 } }, { table_turn = { angle_deg = 30 } }]
[[measurement]]
name = "angle"
doc = "What the gyro turned"
quantity = "table.angle"
unit = "deg"
check = { all_within = [-1e9, 1e9] }
"#;

/// Prepares a plan on these devices, with faults as in a file.
fn prepared(devices: &str, faults: &str) -> Prepared {
    let steps = if devices == "paper-table" { TABLE } else { ROBOT };
    let text =
        format!("name = \"faulty\"\ntitle = \"\"\ndevices = \"{devices}\"\n{steps}\n{faults}");
    plans::prepared(&text, shipped(devices))
}

fn answers() -> Answers {
    Answers::from(BTreeMap::from([("mass".to_owned(), 3.0)]))
}

/// Returns a run and its events.
fn run(prepared: &Prepared) -> (Ended, Vec<Record>) {
    let mut sink = MemorySink::new(Level::Events);
    let run = simulate(prepared, 5, &answers(), &mut sink, &mut |_| true);
    (run, sink.into_records())
}

/// Returns the complete record of a run.
fn bytes(prepared: &Prepared) -> Vec<u8> {
    let mut out = Vec::new();
    let mut sink =
        FileSink::new(&mut out, &prepared.header(5), Level::Full).expect("a vector takes all");
    simulate(prepared, 5, &answers(), &mut sink, &mut |_| true);
    drop(sink);
    out
}

fn told(records: &[Record]) -> Vec<(f64, &FaultRecord)> {
    let faults = records.iter().filter_map(|record| match &record.kind {
        RecordKind::Fault(fault) => Some((record.at.as_secs_f64(), &**fault)),
        _ => None,
    });
    faults.collect()
}

#[test]
fn a_run_without_faults_is_the_run_with_one_that_never_happens() {
    let without = prepared("paper", "");
    assert!(without.plan.faults.is_empty());
    let (plain, records) = run(&without);
    assert!(plain.ending.outcome == Outcome::Passed && plain.faults.is_empty());
    let spared = "[[fault]]\ntarget = \"gyro\"\nwhat = { drop = { loss_percent = 50 } }\n\
                  probability = 1e-12";
    let (never, mut with) = run(&prepared("paper", spared));
    let last = with.pop().unwrap();
    let said = FaultEvent::NeverHappened { why: "drawn not to".to_owned() };
    assert!(matches!(last.kind, RecordKind::Fault(fault) if fault.event == said));
    assert_eq!(with, records);
    let name = "drop of gyro".to_owned();
    assert_eq!(never.faults, [FaultSummary { index: 0, name, begun: false, acted: 0 }]);
}

#[test]
fn one_fault_shifts_no_other() {
    let at = |second: u32| {
        format!(
            "[[fault]]\ntarget = \"gyro\"\nwhat = {{ noise_burst = {{ rms_deg_per_s = 1 }} }}\n\
             when = {{ at_s = {second} }}\nduration_s = 0.5\n"
        )
    };
    let drop = "[[fault]]\ntarget = \"base\"\ntoward = \"host\"\n\
                what = { drop = { loss_percent = 30 } }\nwhen = { at_s = 2 }\nduration_s = 1\n";
    let lost = |faults: &str| run(&prepared("paper", faults)).0.faults[0].acted;
    // The same random numbers strike the same frames of the base.
    assert_eq!(lost(&format!("{drop}{}", at(100))), lost(&format!("{drop}{}", at(0))));
}

#[test]
fn a_plan_with_faults_runs_twice_to_the_same_bytes() {
    for (devices, faults) in [
        ("paper", "target = \"base\"\nwhat = { bit_errors = { bit_error_rate = 0.0005 } }"),
        ("paper", "target = \"gyro\"\nwhat = { flip = { flip_percent = 2 } }"),
        ("paper-serial", "target = \"base\"\nwhat = { framing_slip = { slip_percent = 5 } }"),
        ("paper", "target = \"host\"\nwhat = { scheduler_stall = { for_s = 0.2 } }"),
    ] {
        let faulty = prepared(devices, &format!("[[fault]]\n{faults}"));
        let first = bytes(&faulty);
        assert!(first == bytes(&faulty), "{faults}");
        assert!(first != bytes(&prepared(devices, "")), "{faults}");
    }
}
