//! Plans given as text, run in the simulated world, and their records.

mod at_rest;

use emulators::device_file::Devices;
use harness::operator::Answers;
use harness::run::{Ended, Prepared, simulate};
use plan::Plan;
use plan::Rig;
use plan::calibrations;
use plan::library::Library;
use record::header::Header;
use record::sink::{FileSink, Level, MemorySink};
use record::{Device, Record, RecordKind};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns a plan with these steps that judges nothing: its measurement accepts any value.
pub fn plan_of(steps: &str) -> String {
    plan_measuring(steps, "health.degraded", "1")
}

/// Returns a plan with observations of this quantity, in its unit.
pub fn plan_measuring(steps: &str, quantity: &str, unit: &str) -> String {
    format!(
        r#"
name = "scenario"
title = "A scenario"
devices = "none"
steps = [{steps}]

[[measurement]]
name = "{}"
doc = "A plan must measure something"
quantity = "{quantity}"
unit = "{unit}"
check = {{ all_within = {{ at_least = -1e9 }} }}
"#,
        quantity.replace('.', "_")
    )
}

/// Prepares a plan given as text, on these devices, with the calibrations that ship.
///
/// # Panics
///
/// When the text is not a plan.
pub fn prepared(text: &str, devices: Devices) -> Prepared {
    let plan = match Plan::parse("scenario", text) {
        Ok(plan) => plan,
        Err(error) => panic!("{error}: {:?}", &text[error.range()]),
    };
    // If a calibration does not ship, the run reports it as missing.
    let calibrations =
        calibrations::load(&plan, &Library::shipped(), &BTreeMap::new()).unwrap_or_default();
    let models = BTreeMap::new();
    Prepared::new(Arc::new(plan), Rig::of_robot(devices), calibrations, models)
}

/// A run and its full record.
#[derive(Debug)]
pub struct Run {
    /// Its result.
    pub simulated: Ended,
    /// Its records.
    pub records: Vec<Record>,
}

/// Runs it without answers, to its end.
pub fn run(prepared: &Prepared, seed: u64) -> Run {
    run_with(prepared, seed, &BTreeMap::new())
}

/// Runs it with these answers of the operator.
pub fn run_with(prepared: &Prepared, seed: u64, answers: &BTreeMap<String, f64>) -> Run {
    let mut sink = MemorySink::new(Level::Full);
    let simulated = simulate(prepared, seed, &answers.clone().into(), &mut sink, &mut |_| true);
    assert_eq!(sink.overflowed(), 0, "a scenario fits the memory");
    Run { simulated, records: sink.into_records() }
}

/// Returns the bytes of a run's record file, at the full level.
///
/// # Panics
///
/// When they cannot be written, which does not happen in memory.
pub fn record_file(prepared: &Prepared, seed: u64) -> Vec<u8> {
    let mut file = Vec::new();
    // Without the seed in the header, so that files differ only in their events.
    let header = Header { plan: prepared.plan.name.as_str().to_owned(), ..Header::default() };
    let mut sink =
        FileSink::new(&mut file, &header, Level::Full).expect("memory takes what is written");
    simulate(prepared, seed, &Answers::default(), &mut sink, &mut |_| true);
    drop(sink);
    file
}

impl Run {
    /// Returns what the device sent on its lines, in order.
    pub fn sent_by(&self, device: Device) -> Vec<&Record> {
        let sent = |record: &&Record| {
            record.device == device
                && matches!(record.kind, RecordKind::Bytes(_) | RecordKind::Frame(_))
        };
        self.records.iter().filter(sent).collect()
    }

    /// Returns the observed values of this quantity, in order.
    pub fn observed(&self, quantity: &str) -> Vec<f64> {
        self.simulated.observations.of(quantity).map(|one| one.value()).collect()
    }
}
