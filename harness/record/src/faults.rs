//! What a fault leaves in the record, and in `summary.json`.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Something that a fault did.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Its place in the schedule.
    pub index: u32,
    /// Its kind and target: `burst_loss of gyro`.
    pub name: String,
    /// What it did.
    pub event: FaultEvent,
}

/// What a fault can do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaultEvent {
    /// It begins.
    Began,
    /// It is over, having changed something so often.
    Ended {
        /// Bytes, frames, outputs, commands or answers.
        acted: u64,
    },
    /// The run is over, and it never began.
    NeverHappened {
        /// Why.
        why: String,
    },
    /// The fault confinement of a node of the bus changed its state.
    Confinement {
        /// `controller` or `base`.
        node: String,
        /// `error-active`, `error-passive` or `bus-off`.
        state: String,
        /// Transmit error counter.
        tec: u16,
        /// Receive error counter.
        rec: u16,
    },
}

/// What became of a fault, in `summary.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultSummary {
    /// Its place in the schedule.
    pub index: usize,
    /// Its kind and target: `burst_loss of gyro`.
    pub name: String,
    /// It has begun.
    pub begun: bool,
    /// How often it changed anything: bytes, frames, outputs, commands, answers.
    pub acted: u64,
}

/// `fault 0 begins: burst_loss of gyro`.
impl fmt::Display for FaultRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { index, name, event } = self;
        let name = name.escape_debug();
        match event {
            FaultEvent::Began => write!(f, "fault {index} begins: {name}"),
            FaultEvent::Ended { acted } => {
                write!(f, "fault {index} ends: {name}, acted {acted} times")
            }
            FaultEvent::NeverHappened { why } => {
                write!(f, "fault {index} never happened: {name}, {}", why.escape_debug())
            }
            FaultEvent::Confinement { node, state, tec, rec } => {
                let (node, state) = (node.escape_debug(), state.escape_debug());
                write!(f, "fault {index}: {node} is {state}, TEC {tec}, REC {rec}")
            }
        }
    }
}
