//! What the engine asks of the world.

use controller::calibration::Calibration;
use controller::mission::Mission;
use identification::finding::Compensation;
use plan::made::{Found, Made};
use plan::{Order, PhaseEvent};
use record::{Device, RecordKind};
use wire::table;

/// One thing to be done by the world, at once.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Give the controller a mission.
    Mission(Box<Mission>),
    /// Send the table a command.
    Table(table::Command),
    /// Measure the pose by the absolute measurement; answer with `Engine::absolute`.
    MeasureAbsolute,
    /// Look where the base is, and where it believes to be; answer with `Engine::looked`.
    Look,
    /// Have it done; answer with `Engine::answered` or `Engine::broke`, where a number is asked for with
    /// `Engine::answered_with`. What is sent is not answered.
    Order(Order),
    /// Have a node take errors off a signal before it sends it, or no longer; answer with `Engine::answered` or
    /// `Engine::broke`.
    Correct {
        /// The node.
        node: String,
        /// Its signal.
        signal: String,
        /// By which steps.
        compensation: Option<Box<Compensation>>,
    },
    /// Keep a calibration in the run folder and for later plans.
    SaveCalibration {
        /// Its name.
        name: String,
        /// What it holds.
        calibration: Box<Calibration>,
    },
    /// Keep a model that was identified in the run folder and for later plans.
    KeepFound {
        /// Its name.
        name: String,
        /// The finding and the model.
        found: Box<Found>,
    },
    /// A phase of the plan began or ended; only where the plan has faults that may wait for it.
    Phase(PhaseEvent),
    /// Write this into the record.
    Record(Device, RecordKind),
}

impl Action {
    /// Puts what is to be kept into `made`.
    pub fn keep_in(&self, made: &mut Made) {
        match self {
            Self::SaveCalibration { name, calibration } => {
                made.calibrations.insert(name.clone(), (**calibration).clone());
            }
            Self::KeepFound { name, found } => {
                made.models.insert(name.clone(), found.model.clone());
                made.findings.insert(name.clone(), found.finding.clone());
            }
            _ => {}
        }
    }
}
