//! The error state of a controller on a bus.

use core::fmt;
use serde::{Deserialize, Serialize};

crate::words! {
    /// The error state of a controller (ISO 11898-1, fault confinement), the worst last.
    #[derive(
        Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
    )]
    #[serde(rename_all = "kebab-case")]
    pub enum BusState {
        /// Both error counters are below 96.
        #[default]
        Active = "error-active",
        /// One counter is at least 96.
        Warning = "error-warning",
        /// One counter is at least 128: the controller sends no more active error flags.
        Passive = "error-passive",
        /// The transmit counter is at least 256: the controller left the bus.
        BusOff = "bus-off",
    }
}

impl fmt::Display for BusState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
