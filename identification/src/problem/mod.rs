//! A data set as equations: for each observed quantity, measured minus nominal, and what each kind of term would
//! add to it per unit.

mod channels;
mod closing;
mod driven;
mod gyro;
mod laps;
mod path;
mod pose;
mod segments;
mod sensor;
mod series;
mod turning;
mod wheels;

use crate::dataset::{Axis, Dataset, Kind};
use crate::identify::IdentifyError;
use crate::model::{Acts, Driver};
pub use channels::{Channel, Channels};
pub use closing::Closing;
pub use path::{Added, Path, PathError};
pub use pose::{Component, Moves, Pose};
use std::rc::Rc;
pub use turning::{Over, Turning};

/// How rows add up to observations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aggregate {
    /// An observation is of its row alone.
    Row,
    /// An observation is the sum over its run up to its row: a heading, a travelled distance.
    Level,
    /// An observation is a heading, an x or a y of a driven path, which began at a pose that nobody knows exactly.
    Pose,
}

/// A unit for people: its text and what one of it is in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayUnit {
    /// As the contract writes it.
    pub text: String,
    /// In SI.
    pub si: f64,
}

impl DisplayUnit {
    /// That unit.
    pub fn new(text: &str, si: f64) -> Self {
        Self { text: text.to_owned(), si }
    }
}

/// What one kind of term does to an observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    /// The kind of term.
    pub acts: Acts,
    /// What a unit of the term adds in each row, in SI.
    pub per_row: Vec<f64>,
    /// Unit of the term's values.
    pub unit: DisplayUnit,
}

/// Terms that the plain model has already; their values are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Constant {
    /// What it acts on.
    pub acts: Acts,
    /// Its name.
    pub name: &'static str,
}

/// One observed quantity over all rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// What is observed, for people: `gyro_z`, `heading`.
    pub label: String,
    /// Which axis of a gyro.
    pub axis: Option<Axis>,
    /// The label again, where terms of this block are of no other.
    pub apart: Option<String>,
    /// How rows add up.
    pub aggregate: Aggregate,
    /// Row of each observation.
    pub rows: Vec<usize>,
    /// Measured minus nominal, one an observation, in SI.
    pub residual: Vec<f64>,
    /// What was measured, as it was written (its lattice shows there), one an observation, and its unit in SI.
    pub raw: Vec<f64>,
    /// What one of `raw` is in SI.
    pub raw_si: f64,
    /// Noise of each observation over that of the others, where it is known to differ; infinite for one that says
    /// nothing. Empty where all are alike.
    pub spread: Vec<f64>,
    /// What terms of each kind add.
    pub exposures: Vec<Exposure>,
    /// What the plain model fits.
    pub constants: Vec<Constant>,
    /// Unit of the residual.
    pub unit: DisplayUnit,
    /// How much of the random walk each row brings (seconds, or metres driven); `None` where rows are alone.
    pub activity: Option<Vec<f64>>,
    /// Where the path lies, for poses.
    pub pose: Option<Pose>,
    /// How readings go together, for the ends of laps.
    pub closing: Option<Closing>,
    /// What effects of this block see, where it is not what those of all others do: the rotation about its own axis.
    pub own: Option<Rc<Channels>>,
}

/// What a model brings to data beside its terms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Known {
    /// Counts per rad/s of the gyro.
    pub counts_per_unit: Option<f64>,
    /// Half a side of the square that laps were, m.
    pub closing_lever_m: Option<f64>,
}

/// A data set as equations.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// What one row is.
    pub kind: Kind,
    /// What effects can see.
    pub channels: Channels,
    /// What is observed.
    pub blocks: Vec<Block>,
    /// The driven path, for `odometry`.
    pub path: Option<Path>,
    /// Counts per rad/s, where the gyro tells counts.
    pub counts_per_unit: Option<f64>,
    /// Half a side of the square, for `laps` whose ends lie as a square's do, m.
    pub closing_lever_m: Option<f64>,
    /// What a reader should know.
    pub notices: Vec<String>,
}

impl Problem {
    /// The equations of `dataset`. What is not `known` is what the data say.
    ///
    /// # Errors
    ///
    /// When it lacks what its kind needs.
    pub fn new(dataset: &Dataset, known: Known) -> Result<Self, IdentifyError> {
        let channels = Channels::new(dataset);
        match dataset.kind {
            Kind::Turns => gyro::turns(dataset, channels),
            Kind::Series => series::series(dataset, channels, known.counts_per_unit),
            Kind::Odometry => driven::odometry(dataset, channels),
            Kind::Laps => laps::laps(dataset, channels, known),
            Kind::Sensor => sensor::sensor(dataset, channels),
        }
    }
}

impl Problem {
    /// What effects of `block` see.
    pub fn channels_of<'a>(&'a self, block: &'a Block) -> &'a Channels {
        block.own.as_deref().unwrap_or(&self.channels)
    }

    /// What a model of these data has to bring to others.
    pub const fn known(&self) -> Known {
        Known { counts_per_unit: self.counts_per_unit, closing_lever_m: self.closing_lever_m }
    }
}

impl Block {
    /// What was measured at an observation, in SI, where observations are of rows.
    pub fn measured(&self, observation: usize) -> f64 {
        self.raw[observation] * self.raw_si
    }

    /// What a unit of a term of that kind adds in each row.
    pub fn exposure(&self, acts: Acts) -> Option<&Exposure> {
        self.exposures.iter().find(|exposure| exposure.acts == acts)
    }

    /// Sums or picks what a term that `acts` so adds `per_row` into observations. `runs` is the run of each row.
    pub fn observe(&self, acts: Acts, per_row: Vec<f64>, runs: &[usize]) -> Vec<f64> {
        match self.aggregate {
            Aggregate::Pose => {
                let moves = Moves::of(acts);
                self.pose.as_ref().map_or_else(Vec::new, |pose| pose.observe(&per_row, moves))
            }
            Aggregate::Row if self.rows.iter().copied().eq(0..per_row.len()) => per_row,
            Aggregate::Row => self.rows.iter().map(|&row| per_row[row]).collect(),
            Aggregate::Level => {
                let mut sum = 0.0;
                let mut at = 0;
                let mut observed = Vec::with_capacity(self.rows.len());
                for &row in &self.rows {
                    while at <= row {
                        if at > 0 && runs[at] != runs[at - 1] {
                            sum = 0.0;
                        }
                        sum += per_row[at];
                        at += 1;
                    }
                    observed.push(sum);
                }
                observed
            }
        }
    }
}

/// `angle` to within half a turn of zero, in (-pi, pi].
pub fn wrap(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let rest = angle.rem_euclid(turn);
    if rest > std::f64::consts::PI { rest - turn } else { rest }
}

/// The driver that is the rotation itself, where no field has it.
pub const ROTATION: &str = "reference_rate";

/// A driver over the rotation.
pub fn rotation_driver(channels: &Channels) -> Driver {
    Driver::plain(&channels.rotation_name)
}
