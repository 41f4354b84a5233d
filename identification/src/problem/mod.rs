//! A data set as equations: for each observed quantity, measured minus nominal, and the contribution of each kind of
//! term per unit.

mod channels;
mod course;
mod driven;
mod gyro;
mod heading;
mod laps;
mod path;
mod pose;
mod rate;
mod reference;
mod segments;
mod sensor;
mod series;
mod turning;
mod wheels;

use crate::dataset::{Axis, Column, Dataset, Kind, Unit};
use crate::error::IdentifyError;
pub use channels::{Channel, Channels};
pub use laps::Closing;
pub use path::{Added, Path, PathError};
pub use pose::{Component, Moves, Pose};
use schemars::JsonSchema;
pub use segments::{clusters, runs, segments};
use serde::{Deserialize, Serialize};
use std::rc::Rc;
pub use turning::{Over, Turning};
pub(crate) use wheels::{TRACK, motion};

/// How rows accumulate to observations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aggregate {
    /// An observation depends on its row alone.
    Row,
    /// An observation is the sum over its run up to its row: a heading, a travelled distance.
    Level,
    /// An observation is a heading, an x or a y of a driven path with an uncertain start.
    Pose,
}

/// A unit for display: its text and one of it in SI.
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

    /// That of a plain number.
    pub fn one() -> Self {
        Unit::One.into()
    }
}

impl From<Unit> for DisplayUnit {
    fn from(unit: Unit) -> Self {
        Self::new(unit.text(), unit.si())
    }
}

/// What a term acts on.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the contract's words")]
pub enum Acts {
    Bias,
    Scale,
    Delay,
    Clock,
    Axis,
    Saturation,
    Quantisation,
    DeadZone,
    Noise,
    Drive,
    Turn,
    Curvature,
    Slip,
    Reference,
}

/// Effect of one kind of term on an observation.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    /// The kind of term.
    pub acts: Acts,
    /// Contribution of one unit of the term in each row, in SI.
    pub per_row: Vec<f64>,
    /// Unit of the term's values.
    pub unit: DisplayUnit,
}

impl Exposure {
    fn new(acts: Acts, per_row: Vec<f64>, unit: DisplayUnit) -> Self {
        Self { acts, per_row, unit }
    }
}

/// A term that the plain model already has; its value is fitted.
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
    /// Name of the quantity for display: `gyro_z`, `heading`.
    pub label: String,
    /// Axis of a gyro.
    pub axis: Option<Axis>,
    /// The label again, if terms of this block apply to no other.
    pub apart: Option<String>,
    /// How rows accumulate.
    pub aggregate: Aggregate,
    /// Row of each observation.
    pub rows: Vec<usize>,
    /// Measured minus nominal, one per observation, in SI.
    pub residual: Vec<f64>,
    /// The measurement as written (its lattice shows there), one per observation.
    pub raw: Vec<f64>,
    /// One of `raw`, in SI.
    pub raw_si: f64,
    /// Noise of each observation relative to the others, if it is known to differ; infinite for one without
    /// information. Empty if all are equal.
    pub spread: Vec<f64>,
    /// Contribution of each kind of term.
    pub exposures: Vec<Exposure>,
    /// Constants that the plain model fits.
    pub constants: Vec<Constant>,
    /// Whether the readings show nothing of what their reference does: the residual then is all that they say.
    pub is_blind: bool,
    /// Unit of the residual.
    pub unit: DisplayUnit,
    /// Random walk that each row adds, in units of activity (seconds, or metres driven); `None` if rows are
    /// independent.
    pub activity: Option<Vec<f64>>,
    /// Geometry of the path, for poses.
    pub pose: Option<Pose>,
    /// Relation of the readings, for the ends of laps.
    pub closing: Option<Closing>,
    /// Channels of this block, if they differ from those of the others: the rotation about its own axis.
    pub own: Option<Rc<Channels>>,
}

/// What a model contributes to data besides its terms.
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
    /// Channels that effects can depend on.
    pub channels: Channels,
    /// The observed quantities.
    pub blocks: Vec<Block>,
    /// The driven path, for `odometry`.
    pub path: Option<Path>,
    /// Counts per rad/s, if the gyro reports counts.
    pub counts_per_unit: Option<f64>,
    /// Half a side of the square, for `laps` whose ends lie as a square's do, m.
    pub closing_lever_m: Option<f64>,
    /// Notes for the reader.
    pub notices: Vec<String>,
}

impl Problem {
    /// The equations of `dataset`. Values that are not `known` come from the data.
    ///
    /// # Errors
    ///
    /// When it lacks what its kind needs.
    pub fn new(dataset: &Dataset, known: Known) -> Result<Self, IdentifyError> {
        let channels = Channels::new(dataset);
        let mut problem = match dataset.kind {
            Kind::Turns => gyro::turns(dataset, channels),
            Kind::Series => series::series(dataset, channels, known.counts_per_unit),
            Kind::Odometry => driven::odometry(dataset, channels),
            Kind::Laps => laps::laps(dataset, channels, known),
            Kind::Sensor => sensor::sensor(dataset, channels),
        }?;
        leave_out_lonely(&mut problem, dataset);
        Ok(problem)
    }

    /// Blocks without a path, whose scale and whose lever are known.
    fn of(kind: Kind, channels: Channels, blocks: Vec<Block>) -> Self {
        Self {
            kind,
            channels,
            blocks,
            path: None,
            counts_per_unit: None,
            closing_lever_m: None,
            notices: Vec::new(),
        }
    }

    /// Channels that effects of `block` depend on.
    pub fn channels_of<'a>(&'a self, block: &'a Block) -> &'a Channels {
        block.own.as_deref().unwrap_or(&self.channels)
    }

    /// Values that a model of these data must carry over to others.
    pub const fn known(&self) -> Known {
        Known { counts_per_unit: self.counts_per_unit, closing_lever_m: self.closing_lever_m }
    }
}

impl Block {
    /// Observations of single rows, without any yet.
    pub fn new(label: &str, unit: DisplayUnit) -> Self {
        Self {
            label: label.to_owned(),
            axis: None,
            apart: None,
            aggregate: Aggregate::Row,
            rows: Vec::new(),
            residual: Vec::new(),
            raw: Vec::new(),
            raw_si: 1.0,
            spread: Vec::new(),
            exposures: Vec::new(),
            constants: Vec::new(),
            is_blind: false,
            unit,
            activity: None,
            pose: None,
            closing: None,
            own: None,
        }
    }

    /// Readings in these rows of `column`, each with its `error`.
    fn of_readings(
        column: &Column,
        rows: Vec<usize>,
        error: impl Fn(usize) -> f64,
        unit: DisplayUnit,
    ) -> Self {
        Self {
            axis: column.axis,
            residual: rows.iter().map(|&row| error(row)).collect(),
            raw: rows.iter().map(|&row| column.values[row]).collect(),
            raw_si: column.unit.si(),
            rows,
            ..Self::new(&column.name, unit)
        }
    }

    /// The measurement at an observation, in SI, for observations of single rows.
    pub fn measured(&self, observation: usize) -> f64 {
        self.raw[observation] * self.raw_si
    }

    /// Contribution of one unit of a term of that kind in each row.
    pub fn exposure(&self, acts: Acts) -> Option<&Exposure> {
        self.exposures.iter().find(|exposure| exposure.acts == acts)
    }

    /// Sums or selects `per_row`, the contribution of a term that `acts` so, into observations. `runs` is the run of
    /// each row.
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

/// Leaves runs of which a single reading is left, once those without a reference and those that are wrong are set aside, out
/// of `problem`, with a notice: such a reading shows no change, and as a run of its own it would count as much as all others.
fn leave_out_lonely(problem: &mut Problem, dataset: &Dataset) {
    if !matches!(problem.kind, Kind::Series | Kind::Sensor) || dataset.run_labels.len() < 2 {
        return;
    }
    let run = &problem.channels.run;
    for block in problem.blocks.iter_mut().filter(|block| block.aggregate == Aggregate::Row) {
        let mut left = vec![0_usize; dataset.run_labels.len()];
        block.rows.iter().for_each(|&row| left[run[row]] += 1);
        let keeps: Vec<bool> = block.rows.iter().map(|&row| left[run[row]] > 1).collect();
        if keeps.iter().all(|keeps| *keeps) || !keeps.contains(&true) {
            continue;
        }
        keep(block, &keeps);
        let alone = left.iter().zip(&dataset.run_labels).filter(|(left, _)| **left == 1);
        let names: Vec<&str> = alone.map(|(_, name)| name.as_str()).collect();
        problem.notices.push(format!(
            "run {} is left out of `{}`: one reading with a reference is left of it",
            names.join(", "),
            block.label
        ));
    }
}

/// Keeps these observations of `block`.
fn keep(block: &mut Block, keeps: &[bool]) {
    fn kept<T: Copy>(of: &mut Vec<T>, keeps: &[bool]) {
        let mut keeps = keeps.iter();
        of.retain(|_| keeps.next().copied().unwrap_or(true));
    }
    kept(&mut block.rows, keeps);
    kept(&mut block.residual, keeps);
    kept(&mut block.raw, keeps);
    kept(&mut block.spread, keeps);
}

/// Takes the jumps of whole turns out of an angle, rad; missing values stay missing.
pub fn unwrap(values: &mut [f64]) {
    let mut last: Option<f64> = None;
    for value in values.iter_mut().filter(|value| value.is_finite()) {
        if let Some(last) = last {
            *value = last + wrap(*value - last);
        }
        last = Some(*value);
    }
}

/// `angle` to within half a turn of zero, in (-pi, pi].
pub fn wrap(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let rest = angle.rem_euclid(turn);
    if rest > std::f64::consts::PI { rest - turn } else { rest }
}

/// Driver name of the rotation itself, if no field has it.
pub const ROTATION: &str = "reference_rate";
