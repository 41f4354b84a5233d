//! A quantity that the plan measures: what was seen of it, and where it is meant to lie.

use super::series::Series;
use crate::record::Observation;
use crate::record::header::{Band, Quantity};
use wire::time::Timestamp;

/// A quantity that the plan measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauge {
    /// Name, unit, meaning and bands, as in the header of the record.
    pub quantity: Quantity,
    /// Its values.
    pub series: Series,
    /// Values outside a band that is meant for them.
    pub outside: u64,
    /// Least and greatest value.
    pub range: Option<(f64, f64)>,
}

impl Gauge {
    pub(super) fn new(quantity: &Quantity) -> Self {
        let quantity = quantity.clone();
        Self { quantity, series: Series::default(), outside: 0, range: None }
    }

    pub(super) fn take(&mut self, at: Timestamp, observation: &Observation) {
        let value = observation.value;
        self.series.push(at.as_secs_f64(), value);
        self.range = Some(
            self.range.map_or((value, value), |(least, most)| (least.min(value), most.max(value))),
        );
        let meant = self.quantity.bands.iter().filter(|band| {
            band.tags.iter().all(|(name, wanted)| observation.tags.get(name) == Some(wanted))
        });
        if meant.into_iter().any(|band| !lies_within(band, value)) {
            self.outside += 1;
        }
    }

    /// The last value.
    pub fn last(&self) -> Option<f64> {
        self.series.last().map(|(_, value)| value)
    }

    /// The band that is meant for all values: the first that asks for no tag, else the first.
    pub fn band(&self) -> Option<&Band> {
        let bands = &self.quantity.bands;
        bands.iter().find(|band| band.tags.is_empty()).or_else(|| bands.first())
    }
}

fn lies_within(band: &Band, value: f64) -> bool {
    band.lower.is_none_or(|lower| value >= lower) && band.upper.is_none_or(|upper| value <= upper)
}
