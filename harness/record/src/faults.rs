//! The traces of a fault in the record and in `summary.json`.

use crate::figures;
use crate::text::OneLine;
use serde::{Deserialize, Serialize};
use std::fmt;

/// An event of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Index in the schedule.
    pub index: u32,
    /// Its kind and target: `burst_loss of gyro`.
    pub name: String,
    /// The event.
    pub event: FaultEvent,
}

/// The events of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaultEvent {
    /// The fault began.
    Began,
    /// The fault ended.
    Ended {
        /// Number of changed bytes, frames, outputs, commands or answers.
        acted: u64,
    },
    /// The run ended before the fault began.
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

/// Result of a fault, in `summary.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultSummary {
    /// Index in the schedule.
    pub index: usize,
    /// Its kind and target: `burst_loss of gyro`.
    pub name: String,
    /// Whether it began.
    pub begun: bool,
    /// Number of changed bytes, frames, outputs, commands or answers.
    pub acted: u64,
}

/// `fault 0 begins: burst_loss of gyro`.
impl fmt::Display for FaultRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { index, name, event } = self;
        let name = OneLine(name);
        match event {
            FaultEvent::Began => write!(f, "fault {index} begins: {name}"),
            FaultEvent::Ended { acted } => {
                write!(f, "fault {index} ends: {name}, acted {}", figures::times(*acted))
            }
            FaultEvent::NeverHappened { why } => {
                write!(f, "fault {index} never happened: {name}, {}", OneLine(why))
            }
            FaultEvent::Confinement { node, state, tec, rec } => {
                let (node, state) = (OneLine(node), OneLine(state));
                write!(f, "fault {index}: {node} is {state}, TEC {tec}, REC {rec}")
            }
        }
    }
}
