//! The record of a run. Checks, reports and identification read nothing else.
//!
//! * [`header`]: the description of a record in its file. [`blocks`], [`writer`], [`reader`]: the file.
//! * [`sink`]: takes the records of a running world. [`kept`]: a sink that loses none when a run is killed. [`text`]: a
//!   record as a line of text.
//! * [`outcome`]: the result of a run. [`run_folder`]: the files of a run. [`figures`]: number formats.
//! * [`reading`]: files that report how much of them has been read.

mod bench;
pub mod blocks;
mod ear;
mod encoding;
mod faults;
pub mod figures;
pub mod header;
mod input;
pub mod kept;
pub mod locked;
pub mod outcome;
mod progress;
pub mod reader;
pub mod reading;
mod record_file;
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

pub use bench::Bench;
pub use ear::Ear;
pub use encoding::RECORD_BYTES_MAX;
pub use faults::{FaultEvent, FaultRecord, FaultSummary};
pub use progress::Progress;
pub use reply::{Number, Reply, Through};
pub use violation::Violation;

use controller::mission::{Command, Report};
use plan::faults::Target;
pub use plan::observation::Observation;
use plan::{DEVICE, Rig};
use serde::{Deserialize, Serialize};
use wire::can::CanFrame;
use wire::time::Timestamp;
use wire::units::Pose;

/// Version of the harness.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The end of a note on an emulated adapter: from then on, the program at its other side hears the bus.
pub const BUS_OPENED: &str = "the other side has opened the bus";

/// The end of a note on an emulated adapter: from then on, nobody hears the bus there.
pub const BUS_CLOSED: &str = "the other side has closed the bus";

/// The source of an event.
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
    /// A node of a rig, by its index in the header.
    Node(u8),
}

/// The device that a fault acts on.
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
    /// All devices except the nodes of rigs.
    pub const ALL: [Self; 7] = [
        Self::Plan,
        Self::Controller,
        Self::Gyro,
        Self::Base,
        Self::Table,
        Self::Absolute,
        Self::Device,
    ];

    /// The device under which a node's traffic on a line is recorded: its index among the ends of the rig.
    pub fn of_node(rig: &Rig, node: usize, line: usize) -> Self {
        if rig.is_short {
            let is_device = rig.nodes[node].name == DEVICE;
            return if is_device { Self::Device } else { Self::Plan };
        }
        let end = rig.ends().position(|end| end == (node, line));
        Self::Node(end.and_then(|end| u8::try_from(end).ok()).unwrap_or(u8::MAX))
    }

    /// The device under which frames of a rig's bus are recorded that a fault made, by the bus's index in the header: they
    /// are of none of the nodes, whose indices begin at the other end.
    pub fn stranger(bus: usize) -> Self {
        Self::Node(u8::try_from(bus).map_or(0, |bus| u8::MAX - bus))
    }
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Bench time.
    pub at: Timestamp,
    /// Source.
    pub device: Device,
    /// Content.
    pub kind: RecordKind,
}

/// Content of an event. Only a full record keeps `Bytes` and `Frame`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum RecordKind {
    /// The device sent these bytes on its serial line; `at` is their time of arrival.
    Bytes(Vec<u8>),
    /// The device sent this frame on the bus; `at` is its time of arrival.
    Frame(CanFrame),
    /// A step of the plan began.
    StepBegan {
        /// Path in the plan, e.g. `steps[2].repeat[1]`.
        path: String,
        /// Description of the step.
        title: String,
    },
    /// A step of the plan ended.
    StepEnded {
        /// Path in the plan.
        path: String,
    },
    /// The plan gave the controller this command. Boxed, because a calibration is ten times as large as anything else
    /// and commands are rare.
    Command(Box<Command>),
    /// The controller sent this report.
    Report(Report),
    /// Something was measured.
    Observation(Observation),
    /// True values, which only an emulator knows. The plans of the paper never judge them.
    Truth {
        /// True pose of the base; its heading is that of the turret.
        pose: Pose,
        /// True bias of the gyro, rad/s.
        bias_rad_per_s: f64,
        /// True temperature of the coil.
        coil_celsius: f64,
    },
    /// Something failed, was dropped or was repaired.
    Note(String),
    /// A person answered a question or did the requested task. Boxed, because it is long and rare.
    Reply(Box<Reply>),
    /// A fault began, ended, or caused an event worth recording.
    Fault(Box<FaultRecord>),
}
