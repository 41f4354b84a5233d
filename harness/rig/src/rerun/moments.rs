//! What a record knows of the moments of its run.

use super::Clock;
use record::reader::RecordError;
use record::{BUS_OPENED, Device, Record, RecordKind};
use std::collections::BTreeSet;

/// What a record knows of the moments of its run.
#[derive(Debug, Clone)]
pub struct Moments {
    pub clock: Clock,
    /// Ends of lines at which the program opened the bus during the run. It did not hear what came before.
    pub(super) closed: BTreeSet<Device>,
}

impl Moments {
    /// Of the records of a run with this clock.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn of(
        clock: Clock,
        records: impl IntoIterator<Item = Result<Record, RecordError>>,
    ) -> Result<Self, RecordError> {
        let mut moments = Self::from(clock);
        if clock == Clock::Virtual {
            return Ok(moments);
        }
        for record in records {
            let Record { device, kind, .. } = record?;
            if matches!(kind, RecordKind::Note(text) if text.ends_with(BUS_OPENED)) {
                moments.closed.insert(device);
            }
        }
        Ok(moments)
    }
}

/// Of a run in which all buses were open from the start.
impl From<Clock> for Moments {
    fn from(clock: Clock) -> Self {
        Self { clock, closed: BTreeSet::new() }
    }
}
