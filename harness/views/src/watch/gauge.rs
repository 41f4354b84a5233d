//! A quantity that the plan measures: its observations and bands.

use super::series::Series;
use plan::quantities::during_tag;
use plan::{self, Filter, Plan};
use record::Observation;
use record::header::{Band, Quantity};
use wire::time::Timestamp;

#[derive(Debug, Clone, PartialEq)]
pub struct Gauge {
    /// Name, unit, meaning and bands, as in the header of the record.
    pub quantity: Quantity,
    pub series: Series,
    /// Number of values outside a band that must contain every value.
    pub outside: u64,
    /// Whether the last value is one of those that such a band must contain.
    pub is_last_judged: bool,
    pub range: Option<(f64, f64)>,
    strict: Vec<Strict>,
}

/// Band of a check that allows no value outside.
#[derive(Debug, Clone, PartialEq)]
struct Strict {
    filter: Filter,
    during: Option<String>,
    band: plan::Band,
}

impl Gauge {
    pub(super) fn new(quantity: &Quantity, plan: &Plan) -> Self {
        let quantity = quantity.clone();
        let judges = plan.measurements.iter();
        let judges = judges.filter(|declared| declared.quantity.as_str() == quantity.name);
        let strict = judges.filter_map(|declared| {
            let check = declared.check.kind().facts();
            let band = check.value_band.filter(|_| check.needs_every_value)?;
            let during = check.during.map(during_tag);
            Some(Strict { filter: declared.filter.clone(), during, band })
        });
        let strict = strict.collect();
        Self {
            quantity,
            series: Series::default(),
            outside: 0,
            is_last_judged: false,
            range: None,
            strict,
        }
    }

    pub(super) fn take(&mut self, at: Timestamp, observation: &Observation) {
        if self.quantity.is_undecided(observation) {
            return;
        }
        let value = observation.value;
        self.series.push(at.as_secs_f64(), value);
        self.range = Some(
            self.range.map_or((value, value), |(least, most)| (least.min(value), most.max(value))),
        );
        let has = |tag: &String| observation.tags.get(tag).is_some_and(|&value| value != 0.0);
        let is_meant = |one: &&Strict| {
            one.during.as_ref().is_none_or(has) && one.filter.matches(|tag| observation.tag(tag))
        };
        let mut meant = self.strict.iter().filter(is_meant).peekable();
        self.is_last_judged = meant.peek().is_some();
        self.outside += u64::from(meant.any(|one| !one.band.contains(value)));
    }

    pub fn last(&self) -> Option<f64> {
        self.series.last().map(|(_, value)| value)
    }

    /// Returns the band for all values: the first without tags, else the first.
    pub fn band(&self) -> Option<&Band> {
        let bands = &self.quantity.bands;
        bands.iter().find(|band| band.tags.is_empty()).or_else(|| bands.first())
    }
}
