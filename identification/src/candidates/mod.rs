//! Candidate shapes that a model might lack, in families, each with its share of the risk of a false alarm.

mod cycles;
mod library;
mod names;
mod reference;
mod shapes;

use crate::dataset::Unit;
use crate::model::{Driver, Form, Shape, Wrap};
use crate::problem::{Block, Channels};
use crate::robust;
pub use library::library;
pub(crate) use names::constant;
pub use shapes::{narrow_on, pairs, periodic, products, smooth, steps};

/// A family of candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Named effects.
    Library,
    /// Effects with a memory: lags and hysteresis.
    Memory,
    /// Any smooth function of a driver.
    Smooth,
    /// A hinge, a bump or a sigmoid.
    Narrow,
    /// Any function of two drivers.
    Pair,
    /// An unknown period.
    Periodic,
    /// A step at an unknown time.
    Step,
}

impl Family {
    /// Share of the risk of a false alarm, and the equivalent number of independent tests (measured on noise; the
    /// memory and narrow families overlap heavily).
    const fn risk(self) -> (f64, f64) {
        match self {
            Self::Library => (0.40, 30.0),
            Self::Memory => (0.15, 25.0),
            Self::Smooth => (0.10, 16.0),
            Self::Narrow => (0.10, 120.0),
            Self::Pair => (0.05, 20.0),
            Self::Periodic => (0.10, 1.0),
            Self::Step => (0.10, 40.0),
        }
    }

    /// Penalty for multiple testing, subtracted from a surprise, in nats. `tests` replaces the usual number of tests if
    /// the data determine it.
    pub fn toll(self, tests: Option<f64>) -> f64 {
        let (share, usual) = self.risk();
        (tests.unwrap_or(usual).max(1.0) / share).ln()
    }

    /// Equivalent number of independent tests of these candidates: neighbours on a grid overlap.
    pub fn tests<'a>(self, candidates: impl Iterator<Item = &'a Candidate>) -> f64 {
        let mut labels: Vec<String> = Vec::new();
        let mut members = 0_usize;
        for candidate in candidates.filter(|candidate| candidate.family == self) {
            members += 1;
            let label = candidate.shape.label();
            if !labels.contains(&label) {
                labels.push(label);
            }
        }
        let neighbours = (members - labels.len()) as f64;
        (labels.len() as f64 + GRID_OVERLAP * neighbours).max(self.risk().1)
    }
}

/// Fraction of an independent test that each further grid point adds.
const GRID_OVERLAP: f64 = 0.2;

/// A shape that may be missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    pub shape: Shape,
    pub family: Family,
}

/// Every candidate tried in each round.
pub fn all(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let mut found = library(block, channels);
    found.extend(smooth(block, channels));
    found.extend(products(block, channels));
    found.extend(steps(block, channels));
    if !lasts(channels) {
        found.retain(|candidate| !follows_time(&candidate.shape));
    }
    found
}

/// Shortest record in which a device's memory can show: below it, time merely stands for what was driven (assumption;
/// gyros of this class warm up for 5 to 30 minutes). A time without a unit is not checked.
const MEMORY_MIN_S: f64 = 300.0;

/// Whether the record is long enough for a device to change by itself.
fn lasts(channels: &Channels) -> bool {
    let (first, last) = robust::ends(channels.time.iter().copied());
    channels.time_unit != Unit::Second || last - first >= MEMORY_MIN_S
}

/// Whether the shape follows time alone, and slowly.
fn follows_time(shape: &Shape) -> bool {
    let slowly = |driver: &Driver| matches!(driver.wrap, Wrap::Step | Wrap::Trend);
    shape.form == Form::Exponential || shape.drivers.iter().any(slowly)
}
