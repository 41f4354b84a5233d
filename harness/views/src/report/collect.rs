//! Data of a record for the page, collected in one pass.

use super::bus_load::BusLoad;
use super::fault_spans::FaultSpans;
use super::observed::{Conditions, Direction, Sample, Series, is_drawable};
use super::path::Path;
use super::phases::Phases;
use super::steps::Steps;
use super::trouble::Troubles;
use controller::mission::Report;
use plan::quantities::OPEN_TAG;
use record::header::Header;
use record::reader::RecordError;
use record::{Observation, Record, RecordKind};
use std::collections::BTreeMap;

/// Maximum observations of one quantity: a 16-hour log at 17 Hz.
const SAMPLES_MAX: usize = 1_000_000;

const QUANTITIES_MAX: usize = 256;

#[derive(Debug, Default)]
pub(super) struct Collected {
    pub series: BTreeMap<String, Series>,
    /// Number of observations of quantities beyond [`QUANTITIES_MAX`].
    pub series_overflowed: u64,
    /// Path estimated by the controller.
    pub believed: Path,
    pub truth: Path,
    pub steps: Steps,
    pub troubles: Troubles,
    pub faults: FaultSpans,
    pub phases: Phases,
    pub load: BusLoad,
    pub under: Conditions,
    pub records: u64,
    pub end_s: f64,
    /// Why the record could not be read to its end.
    pub cut: Option<String>,
}

impl Collected {
    pub(super) fn of(
        header: &Header,
        records: impl IntoIterator<Item = Result<Record, RecordError>>,
    ) -> Self {
        let mut collected = Self::default();
        for record in records {
            match record {
                Ok(record) => collected.add(header, &record),
                Err(error) => {
                    collected.cut = Some(error.to_string());
                    break;
                }
            }
        }
        collected
    }

    fn add(&mut self, header: &Header, record: &Record) {
        let at_s = record.at.as_secs_f64();
        self.records += 1;
        self.end_s = self.end_s.max(at_s);
        self.troubles.add(record);
        self.load.add(header, record);
        match &record.kind {
            RecordKind::Observation(observation) => {
                let is_undecided = observation.tags.contains_key(OPEN_TAG)
                    && header.quantities.iter().any(|quantity| {
                        quantity.name == observation.quantity && quantity.is_undecided(observation)
                    });
                if !is_undecided {
                    self.observe(at_s, observation);
                }
            }
            RecordKind::Fault(fault) => self.faults.add(at_s, fault),
            RecordKind::Command(command) => self.under.told(command),
            RecordKind::Truth { pose, .. } => self.truth.add(*pose),
            RecordKind::Report(Report::State(state)) => self.believed.add(state.pose),
            RecordKind::StepBegan { path, title } => {
                self.steps.begin(at_s, path, title, header.step(path));
            }
            RecordKind::StepEnded { path } => self.steps.end(at_s, path),
            _ => {}
        }
    }

    /// Returns the observations of this quantity; none if it was not observed.
    pub(super) fn samples(&self, quantity: &str) -> &[Sample] {
        self.series.get(quantity).map_or(&[], |series| &series.samples)
    }

    fn observe(&mut self, at_s: f64, observation: &Observation) {
        let Observation { quantity, value, uncertainty, tags } = observation;
        let phases = self.phases.add(at_s, tags);
        if !self.series.contains_key(quantity) {
            if self.series.len() >= QUANTITIES_MAX {
                self.series_overflowed += 1;
                return;
            }
            self.series.insert(quantity.clone(), Series::default());
        }
        let Some(series) = self.series.get_mut(quantity) else {
            return;
        };
        let tag = |name: &str| tags.get(name).copied().filter(|value| is_drawable(*value));
        if !is_drawable(*value) {
            series.not_numbers += 1;
        } else if series.samples.len() >= SAMPLES_MAX {
            series.overflowed += 1;
        } else {
            let direction = tag("direction").filter(|sign| *sign != 0.0);
            series.samples.push(Sample {
                at_s,
                value: *value,
                uncertainty: if is_drawable(*uncertainty) { uncertainty.abs() } else { 0.0 },
                direction: direction.map(
                    |sign| {
                        if sign < 0.0 { Direction::Cw } else { Direction::Ccw }
                    },
                ),
                run: tag("run"),
                temperature: tag("temperature"),
                angle: tag("angle"),
                under: self.under,
                phases,
            });
        }
    }
}
