//! Compact storage for the observations of a run.
//!
//! A signal at 1 kHz gives 3.6 million observations per hour, and only time and value change between them. So a row
//! stores these two, and rows with equal uncertainty and tags share one copy of those.

use super::Observation;
use std::collections::BTreeMap;
use std::fmt;

/// The tag that changes with every observation.
const TIME: &str = "time";

/// A signal at 1 kHz takes 0.7 GiB in a night.
const BYTES_MAX: usize = 1 << 30;

/// The observations of a run by quantity, each in the order in which they were made.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    of: BTreeMap<String, Series>,
    bytes: usize,
    bytes_max: usize,
}

/// The storage is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full {
    bytes_max: usize,
}

impl fmt::Display for Full {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "observations take more than {} MiB", self.bytes_max >> 20)
    }
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Series {
    rows: Vec<Row>,
    shapes: Vec<Shape>,
    /// Uncertainty and tag values of rows, one after another.
    numbers: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
struct Shape {
    is_timed: bool,
    /// All tags except the time, sorted.
    names: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    time: f64,
    value: f64,
    shape: u32,
    /// Index of its first number.
    numbers: u32,
}

/// One observation of a quantity.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    series: &'a Series,
    row: &'a Row,
}

impl Default for Observations {
    fn default() -> Self {
        Self::in_bytes(BYTES_MAX)
    }
}

impl Observations {
    fn in_bytes(bytes_max: usize) -> Self {
        Self { of: BTreeMap::new(), bytes: 0, bytes_max }
    }

    /// The memory that the observations take.
    pub const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Stores an observation.
    ///
    /// # Errors
    /// [`Full`]; the observation is not stored.
    pub fn push(&mut self, observation: &Observation) -> Result<(), Full> {
        let full = Full { bytes_max: self.bytes_max };
        if self.bytes >= self.bytes_max {
            return Err(full);
        }
        let series = match self.of.get_mut(&observation.quantity) {
            Some(series) => series,
            None => self.of.entry(observation.quantity.clone()).or_default(),
        };
        self.bytes += series.push(observation);
        Ok(())
    }

    /// Number of observations.
    pub fn len(&self) -> usize {
        self.of.values().map(|series| series.rows.len()).sum()
    }

    /// Whether there are no observations.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// The quantities with observations.
    pub fn quantities(&self) -> impl Iterator<Item = &str> {
        self.of.keys().map(String::as_str)
    }

    /// The observations of a quantity.
    pub fn of(&self, quantity: &str) -> impl ExactSizeIterator<Item = Observed<'_>> + Clone {
        static NONE: Series = Series { rows: Vec::new(), shapes: Vec::new(), numbers: Vec::new() };
        let series = self.of.get(quantity).unwrap_or(&NONE);
        series.rows.iter().map(|row| Observed { series, row })
    }

    /// All observations, by quantity.
    pub fn iter(&self) -> impl Iterator<Item = Observation> {
        self.quantities().flat_map(|quantity| self.of(quantity).map(|one| one.named(quantity)))
    }
}

/// As many as fit.
impl<'a> FromIterator<&'a Observation> for Observations {
    fn from_iter<I: IntoIterator<Item = &'a Observation>>(all: I) -> Self {
        let mut kept = Self::default();
        let _full = all.into_iter().try_for_each(|one| kept.push(one));
        kept
    }
}

impl Series {
    /// Returns the number of bytes that this takes.
    fn push(&mut self, observation: &Observation) -> usize {
        let others = || observation.tags.iter().filter(|(name, _)| *name != TIME);
        let time = observation.tag(TIME);
        let is_of = |shape: &Shape| {
            shape.is_timed == time.is_some()
                && shape.names.iter().eq(others().map(|(name, _)| name))
        };
        let mut bytes = size_of::<Row>();
        let shape = self.shapes.iter().rposition(is_of).unwrap_or_else(|| {
            let names: Vec<String> = others().map(|(name, _)| name.clone()).collect();
            bytes += size_of::<Shape>()
                + names.iter().map(|name| size_of::<String>() + name.len()).sum::<usize>();
            self.shapes.push(Shape { is_timed: time.is_some(), names });
            self.shapes.len() - 1
        }) as u32;
        let numbers = || [observation.uncertainty].into_iter().chain(others().map(|(_, tag)| *tag));
        let as_before = self.rows.last().filter(|last| {
            let before = &self.numbers[last.numbers as usize..];
            // Compared by bits, so that NaN equals itself.
            last.shape == shape
                && numbers().map(f64::to_bits).eq(before.iter().map(|n| n.to_bits()))
        });
        let numbers = match as_before {
            Some(last) => last.numbers,
            None => {
                let begin = self.numbers.len();
                self.numbers.extend(numbers());
                bytes += (self.numbers.len() - begin) * size_of::<f64>();
                begin as u32
            }
        };
        let (time, value) = (time.unwrap_or_default(), observation.value);
        self.rows.push(Row { time, value, shape, numbers });
        bytes
    }
}

impl<'a> Observed<'a> {
    /// The value.
    pub const fn value(&self) -> f64 {
        self.row.value
    }

    /// Standard uncertainty.
    pub fn uncertainty(&self) -> f64 {
        self.series.numbers[self.row.numbers as usize]
    }

    fn shape(&self) -> &'a Shape {
        &self.series.shapes[self.row.shape as usize]
    }

    /// Time of the observation.
    pub fn time(&self) -> Option<f64> {
        self.shape().is_timed.then_some(self.row.time)
    }

    /// All tags except the time.
    pub fn others(&self) -> impl Iterator<Item = (&'a str, f64)> + use<'a> {
        let names = &self.shape().names;
        let begin = self.row.numbers as usize + 1;
        let numbers = &self.series.numbers[begin..begin + names.len()];
        names.iter().map(String::as_str).zip(numbers.iter().copied())
    }

    /// The value of a tag.
    pub fn tag(&self, name: &str) -> Option<f64> {
        if name == TIME {
            return self.time();
        }
        let place = self.shape().names.binary_search_by(|known| known.as_str().cmp(name)).ok()?;
        Some(self.series.numbers[self.row.numbers as usize + 1 + place])
    }

    /// A separate observation with the name of its quantity.
    pub fn named(&self, quantity: &str) -> Observation {
        let mut tags: BTreeMap<String, f64> =
            self.others().map(|(name, tag)| (name.to_owned(), tag)).collect();
        tags.extend(self.time().map(|time| (TIME.to_owned(), time)));
        let (value, uncertainty) = (self.value(), self.uncertainty());
        Observation { quantity: quantity.to_owned(), value, uncertainty, tags }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Observation;
    use super::{Full, Observations, TIME};
    use proptest::prelude::*;

    fn at(time: f64, value: f64) -> Observation {
        let tags = [(TIME, time), ("during:log", 1.0), ("run", 3.0)];
        Observation {
            quantity: "signal.Angle".to_owned(),
            value,
            uncertainty: 0.1,
            tags: tags.map(|(name, tag)| (name.to_owned(), tag)).into(),
        }
    }

    #[test]
    fn minutes_of_a_signal_of_1_khz_take_little() {
        let mut kept = Observations::default();
        let count = 360_000;
        for index in 0..count {
            kept.push(&at(f64::from(index) / 1_000.0, f64::from(index % 7))).unwrap();
        }
        assert_eq!(kept.len(), count as usize);
        let series = &kept.of["signal.Angle"];
        assert_eq!((series.numbers.len(), series.shapes.len()), (3, 1));
        assert!(kept.bytes < 25 * count as usize, "{}", kept.bytes);
        let last = kept.of("signal.Angle").last().unwrap();
        assert_eq!((last.time(), last.tag("run")), (Some(359.999), Some(3.0)));
    }

    #[test]
    fn there_is_an_end_to_it() {
        let mut kept = Observations::in_bytes(1 << 20);
        let refused = (0..1 << 20).find_map(|index| kept.push(&at(f64::from(index), 0.0)).err());
        assert_eq!(refused, Some(Full { bytes_max: 1 << 20 }));
        assert!(kept.bytes < (1 << 20) + 1000);
        assert_eq!(refused.unwrap().to_string(), "observations take more than 1 MiB");
    }

    fn observation() -> impl Strategy<Value = Observation> {
        let tag = prop_oneof![Just(TIME), Just("run"), Just("angle"), Just("zone")];
        let number = prop_oneof![Just(0.0), Just(-0.0), Just(1.0), Just(f64::INFINITY), -9.0..9.0];
        let tags = prop::collection::btree_map(tag.prop_map(str::to_owned), number, 0..4);
        let quantity = prop_oneof![Just("a"), Just("b")].prop_map(str::to_owned);
        (quantity, -1.0..1.0, prop_oneof![Just(0.0), Just(0.5)], tags).prop_map(
            |(quantity, value, uncertainty, tags)| Observation {
                quantity,
                value,
                uncertainty,
                tags,
            },
        )
    }

    proptest! {
        #[test]
        fn what_is_kept_is_what_was_made(mut made in prop::collection::vec(observation(), 0..40)) {
            let kept: Observations = made.iter().collect();
            for one in &made {
                let found = kept.of(&one.quantity).any(|kept| {
                    let tags = ["angle", "run", TIME, "zone"];
                    kept.value() == one.value && tags.iter().all(|tag| kept.tag(tag) == one.tag(tag))
                });
                prop_assert!(found);
            }
            made.sort_by(|a, b| a.quantity.cmp(&b.quantity));
            prop_assert_eq!(kept.iter().collect::<Vec<_>>(), made);
        }
    }
}
