//! Requests of the engine to its owner, and how it ends.

use controller::calibration::Calibration;
use controller::mission::Mission;
use identification::finding::Compensation;
use plan::made::{Found, Made};
use plan::{Order, PhaseEvent};
use record::outcome::Outcome;
use record::{Device, RecordKind};
use wire::table;

#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Mission(Box<Mission>),
    Table(table::Command),
    /// Measure the pose by the absolute measurement; answer with `Engine::absolute`.
    MeasureAbsolute,
    /// Look at the true pose of the base and at its odometry; answer with `Engine::looked`.
    Look,
    /// Carry out an order; answer with `Engine::answered` or `Engine::broke`, or with `Engine::answered_with` if the
    /// order asks for a number. A sent message is not answered.
    Order(Order),
    /// Make a node correct a signal before it sends it, or stop doing so; answer with `Engine::answered` or
    /// `Engine::broke`.
    Correct {
        node: String,
        signal: String,
        /// Steps of the correction; `None` to stop.
        compensation: Option<Box<Compensation>>,
    },
    /// Keep a calibration in the run folder and for later plans.
    SaveCalibration {
        name: String,
        calibration: Box<Calibration>,
    },
    /// Keep an identified model in the run folder and for later plans.
    KeepFound {
        name: String,
        found: Box<Found>,
    },
    /// A phase of the plan began or ended; sent only if the plan has faults that may wait for it.
    Phase(PhaseEvent),
    Record(Device, RecordKind),
}

impl Action {
    /// Puts the result into `made`, if the action keeps one.
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

/// How a run ended, with a reason unless it simply ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ending {
    /// `Passed` here means that every step was carried out; the checks follow.
    pub outcome: Outcome,
    /// One sentence.
    pub reason: Option<String>,
    /// It ended because a program under test did.
    pub lost: bool,
}
