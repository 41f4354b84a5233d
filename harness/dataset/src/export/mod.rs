//! Exports a recorded run as a data set: the data that a user of a real bench could have noted down.
//!
//! | kind | one row | source |
//! |---|---|---|
//! | `turns` | one turn of the table | observations of the table's turns |
//! | `laps` | one lap | observations of laps |
//! | `odometry` | one state of the controller during a lap: path and heading by the base | states, observations of laps |
//! | `series` | one state of the controller: the mean raw rate since the state before | states, table turns |
//! | `sensor` | one message with the measured signal of a node | messages of the nodes ([`sensor`]) |
//!
//! Time is bench time since the start of the run. In turns and laps a run of the data set is a repetition of the plan,
//! in odometry a lap; a series is a single recording without gaps. The export uses nothing that only an emulator knows:
//! neither [`RecordKind::Truth`] nor a swept parameter.

pub mod columns;
pub mod laps;
mod odometry;
pub mod sensor;
mod series;
pub mod turns;

use crate::DatasetError;
use controller::mission::{Command, HeadingSource};
use identification::dataset::{Dataset, Drive, Kind};
use odometry::Drives;
use plan::observation::Observation;
use record::reader::RecordError;
use record::run_folder::{RECORD, RunFolder, RunFolderError};
use record::{Record, RecordKind};
use series::Course;
use std::path::Path;

/// The most observations taken from one run.
const OBSERVATIONS_MAX: usize = 4_000_000;

/// Why a run cannot be exported.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ExportError {
    /// The run cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// It contains nothing of this kind.
    #[error("{run} holds no {what}")]
    #[diagnostic(help(
        "a data package holds table turns, laps or gyro rates; for your own device, use `--kind sensor --measured \
         NODE.SIGNAL --reference NODE.SIGNAL`"
    ))]
    Nothing {
        /// The run folder.
        run: String,
        /// `turns`, `laps`, ...
        what: &'static str,
    },
    /// It lacks data of a driven path.
    #[error("{run} makes no data set of kind odometry: {why}")]
    #[diagnostic(help(
        "run a plan with laps on a base, as `hil run umbmark` does; of one lap only its ends, `hil export --kind laps`"
    ))]
    NoPath {
        /// The run folder.
        run: String,
        /// The missing data.
        why: String,
    },
    /// The rig has no signal of that name.
    #[error("{message}")]
    #[diagnostic(help("{help}"))]
    NoSignal {
        /// What is wrong.
        message: String,
        /// What to write, or the names of nodes or signals.
        help: String,
    },
    /// The signals make no data set.
    #[error("the run makes no data set of kind sensor: {why}")]
    #[diagnostic(help(
        "run the plan with --record full: messages that nothing judges are not recorded otherwise"
    ))]
    Sensor {
        /// The missing data.
        why: String,
    },
    /// Its rows do not make a valid data set.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Data(#[from] DatasetError),
}

/// The parts of a record that data sets are made from.
#[derive(Debug, Default)]
pub struct Recorded {
    turns: Vec<Observation>,
    laps: Vec<(Observation, HeadingSource)>,
    course: Course,
    drives: Drives,
    heading_source: HeadingSource,
    corrected: bool,
}

impl Recorded {
    /// Reads records to their end.
    ///
    /// # Errors
    /// Those of the reader: a truncated record is no basis for findings.
    pub fn of(
        records: impl IntoIterator<Item = Result<Record, RecordError>>,
    ) -> Result<Self, RecordError> {
        let mut recorded = Self::default();
        for record in records {
            recorded.take(&record?);
        }
        Ok(recorded)
    }

    fn take(&mut self, record: &Record) {
        self.course.take(record);
        self.drives.take(record);
        match &record.kind {
            RecordKind::Command(command) => match &**command {
                Command::SetHeadingSource(source) => self.heading_source = *source,
                Command::SetCalibration(calibration) => {
                    self.corrected |=
                        *calibration != controller::calibration::Calibration::default();
                }
                _ => {}
            },
            RecordKind::Observation(observation) => self.observe(observation),
            _ => {}
        }
    }

    fn observe(&mut self, observation: &Observation) {
        if self.turns.len() + self.laps.len() >= OBSERVATIONS_MAX {
            return;
        }
        if observation.quantity == turns::QUANTITY.name {
            self.turns.push(observation.clone());
        } else if laps::is_of_lap(&observation.quantity) {
            self.laps.push((observation.clone(), self.heading_source));
        }
    }

    /// The richest kind available: turns, then laps, then the series.
    pub fn kind(&self) -> Kind {
        match (self.turns.is_empty(), self.laps.is_empty()) {
            (false, _) => Kind::Turns,
            (true, false) => Kind::Laps,
            (true, true) => Kind::Series,
        }
    }

    /// The data set of this kind; `None` if nothing of it was recorded. Errors name `file`.
    ///
    /// # Errors
    /// When the rows do not make a valid data set.
    pub fn dataset(
        &self,
        kind: Kind,
        name: &str,
        file: &Path,
    ) -> Result<Option<Dataset>, DatasetError> {
        let columns = match kind {
            Kind::Turns => turns::columns(&self.turns),
            Kind::Laps => laps::columns(&self.laps),
            Kind::Series => self.course.columns(),
            Kind::Odometry => self.drives.columns(),
            // A record has no reference for a custom sensor.
            Kind::Sensor => return Ok(None),
        };
        if columns.is_empty() {
            return Ok(None);
        }
        let mut dataset = columns.dataset(kind, name, file)?;
        if kind == Kind::Odometry {
            dataset.drive = Some(Drive::Synchro);
            dataset.notices.extend(self.drives.notice());
        } else if self.corrected && kind != Kind::Series {
            let notice =
                "a calibration was in force in a part of the run: gyro_angle is corrected by it";
            dataset.notices.push(notice.to_owned());
        }
        Ok(Some(dataset))
    }
}

/// The data set of a recorded run, of the requested kind or the richest available.
///
/// # Errors
/// When the run cannot be read to its end, or contains nothing of the kind.
pub fn export(folder: &RunFolder, kind: Option<Kind>) -> Result<Dataset, ExportError> {
    let records = folder.records()?;
    let (plan, seed) = (records.header().plan.clone(), records.header().seed);
    let recorded = Recorded::of(records).map_err(|source| folder.unreadable(source))?;
    let kind = kind.unwrap_or_else(|| recorded.kind());
    let name = format!("{plan}-seed{seed}");
    recorded.dataset(kind, &name, &folder.file(RECORD))?.ok_or_else(|| {
        let run = folder.path().display().to_string();
        if kind == Kind::Odometry {
            return ExportError::NoPath { run, why: recorded.drives.why_not() };
        }
        let what = if kind == Kind::Series {
            "readings of a gyro, which `hil identify` would need"
        } else {
            kind.name()
        };
        ExportError::Nothing { run, what }
    })
}
