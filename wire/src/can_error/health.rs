//! Bus health from a series of events.

use super::{CanErrorEvent, ErrorCounters, ErrorKind};
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

impl BusState {
    /// The smallest value of the larger error counter in this state (`linux/can/error.h`).
    pub const fn least_counter(self) -> u16 {
        match self {
            Self::Active => 0,
            Self::Warning => 96,
            Self::Passive => 128,
            Self::BusOff => 256,
        }
    }
}

impl fmt::Display for BusState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The state of a bus after the events so far, and the count of each kind of problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct BusHealth {
    state: BusState,
    worst: BusState,
    counters: Option<ErrorCounters>,
    events: u64,
    counts: [u64; ErrorKind::ALL.len()],
}

impl BusHealth {
    /// Takes an event.
    pub fn observe(&mut self, event: &CanErrorEvent) {
        self.events = self.events.saturating_add(1);
        self.state = event.bus_state().unwrap_or(self.state);
        self.worst = self.worst.max(self.state);
        self.counters = event.counters.or(self.counters);
        for (kind, count) in ErrorKind::ALL.into_iter().zip(&mut self.counts) {
            *count = count.saturating_add(u64::from(event.reports(kind)));
        }
    }

    /// The current state.
    pub const fn state(&self) -> BusState {
        self.state
    }

    /// The worst state so far.
    pub const fn worst(&self) -> BusState {
        self.worst
    }

    /// The error counters of the last event that contained them.
    pub const fn counters(&self) -> Option<ErrorCounters> {
        self.counters
    }

    /// Number of events so far.
    pub const fn events(&self) -> u64 {
        self.events
    }

    /// Number of events that reported `kind`.
    pub const fn count(&self, kind: ErrorKind) -> u64 {
        self.counts[kind as usize]
    }
}

/// The state, the worst state if different, the counters, and the count of each kind.
impl fmt::Display for BusHealth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.state)?;
        if self.worst != self.state {
            write!(f, " (was {})", self.worst)?;
        }
        if let Some(counters) = self.counters {
            write!(f, ", {counters}")?;
        }
        for (kind, count) in ErrorKind::ALL.into_iter().zip(self.counts) {
            if count > 0 {
                write!(f, ", {count} x {kind}")?;
            }
        }
        Ok(())
    }
}
