//! What happened in a run. Checks, reports and identification read this and nothing else.
//!
//! * [`header`]: what a record file says about itself. [`blocks`], [`writer`], [`reader`]: the file.
//! * [`sink`]: where a running world puts its records. [`kept`]: so that a run that is killed loses none. [`text`]: a record as one line to read.
//! * [`outcome`]: how a run ended. [`run_folder`]: what it leaves behind. [`figures`]: how numbers are written.
//! * [`reading`]: long files that say how much of them was read.

pub mod blocks;
mod encoding;
mod faults;
pub mod figures;
pub mod header;
pub mod kept;
pub mod outcome;
mod progress;
pub mod reader;
pub mod reading;
mod reply;
pub mod run_folder;
#[cfg(any(test, feature = "samples"))]
pub mod samples;
pub mod sink;
#[cfg(test)]
mod tests;
pub mod text;
mod violation;
pub mod writer;

pub use encoding::RECORD_BYTES_MAX;
pub use faults::{FaultEvent, FaultRecord, FaultSummary};
pub use progress::Progress;
pub use reply::{Number, Reply, Through};
pub use violation::Violation;

use controller::mission::{Command, Report};
use described::{Decoded, Decoder};
use plan::faults::Target;
pub use plan::observation::Observation;
use plan::{DEVICE, Rig, Speaker};
use serde::{Deserialize, Serialize};
use wire::can::CanFrame;
use wire::time::Timestamp;
use wire::units::Pose;

/// Version of the harness.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Whose event it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Device {
    /// The engine that runs the plan.
    Plan,
    /// The controller: the device under test.
    Controller,
    /// The gyro.
    Gyro,
    /// The mobile base.
    Base,
    /// The rotary table.
    Table,
    /// The absolute measurement.
    Absolute,
    /// The only device of a plan.
    Device,
    /// A node of a rig, by its place among those of the header.
    Node(u8),
}

/// Whose event a fault is.
impl From<Target> for Device {
    fn from(target: Target) -> Self {
        match target {
            Target::Gyro => Self::Gyro,
            Target::Base => Self::Base,
            Target::Table => Self::Table,
            Target::Host => Self::Controller,
            Target::Operator => Self::Plan,
            Target::Device | Target::Node(_) => Self::Device,
        }
    }
}

impl Device {
    /// Every one, but for the nodes of rigs.
    pub const ALL: [Self; 7] = [
        Self::Plan,
        Self::Controller,
        Self::Gyro,
        Self::Base,
        Self::Table,
        Self::Absolute,
        Self::Device,
    ];

    /// As whose the record has what a node sends on a line: by its place among the ends of the rig.
    pub fn of_node(rig: &Rig, node: usize, line: usize) -> Self {
        if rig.is_short {
            let is_device = rig.nodes[node].name == DEVICE;
            return if is_device { Self::Device } else { Self::Plan };
        }
        let end = rig.ends().position(|end| end == (node, line));
        Self::Node(end.and_then(|end| u8::try_from(end).ok()).unwrap_or(u8::MAX))
    }

    /// As whose the record has what a speaker of the rig says; none where no node is of its name.
    pub fn of_speaker(rig: &Rig, speaker: &Speaker) -> Option<Self> {
        let node = rig.nodes.iter().position(|node| node.name == speaker.node)?;
        Some(Self::of_node(rig, node, speaker.line))
    }
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// When, in bench time.
    pub at: Timestamp,
    /// Whose.
    pub device: Device,
    /// What.
    pub kind: RecordKind,
}

impl Record {
    /// Hands over each message that its bytes or its frame complete.
    pub fn messages(&self, decoder: &mut Decoder, each: &mut impl FnMut(Decoded<'_>)) {
        match &self.kind {
            RecordKind::Bytes(bytes) => decoder.bytes(bytes, each),
            RecordKind::Frame(frame) => {
                decoder.frame(frame).into_iter().for_each(each);
            }
            _ => {}
        }
    }
}

/// What happened. `Bytes` and `Frame` are kept only in a full record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum RecordKind {
    /// The device put these bytes on its serial line; they had arrived at `at`.
    Bytes(Vec<u8>),
    /// The device put this frame on the bus; it had arrived at `at`.
    Frame(CanFrame),
    /// A step of the plan began.
    StepBegan {
        /// Where it stands in the plan, e.g. `steps[2].repeat[1]`.
        path: String,
        /// What it is, in words.
        title: String,
    },
    /// A step of the plan ended.
    StepEnded {
        /// Where it stands in the plan.
        path: String,
    },
    /// The plan gave the controller this command. Boxed: a calibration is ten times as large as
    /// anything else, and records are rarely commands.
    Command(Box<Command>),
    /// The controller sent this report.
    Report(Report),
    /// Something was measured.
    Observation(Observation),
    /// What is really so, which only an emulator can tell. Never judged by the paper's plans.
    Truth {
        /// True pose of the base; its heading is that of the turret.
        pose: Pose,
        /// True bias of the gyro, rad/s.
        bias_rad_per_s: f64,
        /// True temperature of the coil.
        coil_celsius: f64,
    },
    /// Something went wrong, was dropped or was mended.
    Note(String),
    /// A person answered a question, or did what was asked for. Boxed: it is long and rare.
    Reply(Box<Reply>),
    /// A fault began, ended, or did what has to be told.
    Fault(Box<FaultRecord>),
}
