//! What a model might lack: candidate shapes in families, each with its share of the risk of a false alarm.

mod library;
mod names;
mod shapes;
mod timed;

use crate::dataset::Unit;
use crate::model::{Driver, Form, Shape, Wrap};
use crate::problem::{Block, Channels};
pub use library::library;
pub use shapes::{narrow_on, pairs, products, smooth};
pub use timed::{periodic, steps};

/// A family of candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Effects with a name.
    Library,
    /// Effects with a memory: lags and hysteresis.
    Memory,
    /// Any smooth function of a driver.
    Smooth,
    /// A hinge, a bump or a sigmoid.
    Narrow,
    /// Any function of two drivers.
    Pair,
    /// A period that nobody knows.
    Periodic,
    /// A step at a moment that nobody knows.
    Step,
}

impl Family {
    /// Its share of the risk of a false alarm, and how many independent tests it is worth (measured on noise; the
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

    /// What is taken off a surprise for having looked at so many candidates, in nats. `tests` replaces the usual
    /// number where the data say it.
    pub fn toll(self, tests: Option<f64>) -> f64 {
        let (share, usual) = self.risk();
        (tests.unwrap_or(usual).max(1.0) / share).ln()
    }

    /// How many independent tests so many candidates are worth: neighbours on a grid overlap.
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

/// What a further place on a grid is worth, as an independent test.
const GRID_OVERLAP: f64 = 0.2;

/// A shape that may be missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// What it looks like.
    pub shape: Shape,
    /// Where it comes from.
    pub family: Family,
}

/// Every candidate that is tried in each round.
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

/// A memory of a device takes minutes: over less, time stands for whatever was driven (assumption; gyros of this class
/// warm up for 5 to 30 minutes). A time without a unit says nothing of it.
const MEMORY_MIN_S: f64 = 300.0;

/// Do the data last so long that a device could change by itself?
fn lasts(channels: &Channels) -> bool {
    let first = channels.time.iter().copied().fold(f64::INFINITY, f64::min);
    let last = channels.time.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    channels.time_unit != Unit::Second || last - first >= MEMORY_MIN_S
}

/// Does it follow time alone, and slowly?
fn follows_time(shape: &Shape) -> bool {
    let slowly = |driver: &Driver| matches!(driver.wrap, Wrap::Step | Wrap::Trend);
    shape.form == Form::Exponential || shape.drivers.iter().any(slowly)
}
