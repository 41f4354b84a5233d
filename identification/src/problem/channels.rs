//! Channels that effects can depend on, at every row, with slopes on demand.

use super::Turning;
use super::segments::segments;
use crate::dataset::{Dataset, Dimension, Kind, Role, Unit};
use crate::robust;
use crate::signal::{self, Bends, Smooth};
use std::cell::OnceCell;
use std::ops::Range;

/// A field that may be a cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the field.
    pub name: String,
    pub role: Role,
    /// Unit as in the file.
    pub unit: Unit,
    /// SI where the contract has an SI unit; missing values are bridged.
    pub values: Vec<f64>,
    /// Level and slope without sensor noise.
    pub smooth: Smooth,
    /// Smallest and largest value.
    pub range: (f64, f64),
}

impl Channel {
    /// Largest less smallest value.
    pub fn span(&self) -> f64 {
        self.range.1 - self.range.0
    }

    /// Whether it takes more than `count` values.
    pub fn has_more_than(&self, count: usize) -> bool {
        let mut seen: Vec<f64> = Vec::new();
        for value in &self.values {
            if !seen.contains(value) {
                seen.push(*value);
            }
            if seen.len() > count {
                return true;
            }
        }
        false
    }

    /// Whether it is an angle that repeats after a turn.
    pub fn is_angle(&self) -> bool {
        self.unit.dimension() == Dimension::Angle
    }
}

/// Channels at every row.
#[derive(Debug, Clone, PartialEq)]
pub struct Channels {
    /// Time of each row, s (or sample number).
    pub time: Vec<f64>,
    /// Unit of `time`: seconds, or 1 where the data have no times and rows count.
    pub time_unit: Unit,
    /// Name of the field of time.
    pub time_name: String,
    /// Run of each row.
    pub run: Vec<usize>,
    /// Ranges in which time advances without a break.
    pub segments: Vec<Range<usize>>,
    /// Fields that may be a cause and are not constant.
    pub channels: Vec<Channel>,
    /// The rotation itself, rad/s; empty without a rotation. Filled according to the kind of data.
    pub rotation: Vec<f64>,
    /// Standard deviation of the white noise of the rotation, as far as it is known; otherwise zero.
    pub rotation_noise: f64,
    /// Driver name of the rotation.
    pub rotation_name: String,
    /// Unit in which the rotation is stated.
    pub rotation_unit: Unit,
    /// Name of the direction field, if there is one.
    pub direction_name: Option<String>,
    /// Rate and heading within the turn of each row; `None` if rows are not turns.
    pub turning: Option<Turning>,
    /// Whether rows are samples, so that delays and clocks can show.
    pub sampled: bool,
    /// Whether the rotation stands for the measured quantity of any sensor.
    pub of_sensor: bool,
    /// How much its readings rise for one of what is measured, at first sight: they may be in another unit. Of a gyro 1.
    pub gain: f64,
    /// Typical time from row to row, once it was asked for.
    pub(crate) interval: OnceCell<f64>,
    /// How the rotation is bent between rows, once it was asked for: every delay and lag of it needs that.
    pub(crate) bends: OnceCell<Vec<Bends>>,
}

/// Roles that count as causes.
const CAUSES: [Role; 5] =
    [Role::Temperature, Role::Heading, Role::Auxiliary, Role::Bias, Role::Duration];

impl Channels {
    /// Whether zero rotation means that nothing moves. The angle of a turn counts from its beginning; the zero of a sensor's
    /// reference may be a matter of choice.
    pub const fn rotation_has_zero(&self) -> bool {
        !self.of_sensor || self.rotation_unit.dimension().has_own_zero()
    }

    /// The channels of `dataset`.
    pub fn new(dataset: &Dataset) -> Self {
        let rows = dataset.rows();
        let (time, time_unit, time_name): (Vec<f64>, Unit, String) =
            match dataset.column(Role::Time) {
                Some(column) => (column.si().collect(), column.unit, column.name.clone()),
                None => ((0..rows).map(|row| row as f64).collect(), Unit::One, "time".to_owned()),
            };
        let run = dataset.run_of_row.clone();
        let stretches = segments(&time, &run);
        let mut found = Self {
            time,
            time_unit,
            time_name,
            run,
            segments: stretches,
            channels: Vec::new(),
            rotation: Vec::new(),
            rotation_noise: 0.0,
            rotation_name: super::ROTATION.to_owned(),
            rotation_unit: Unit::DegreePerSecond,
            direction_name: dataset.column(Role::Direction).map(|column| column.name.clone()),
            turning: None,
            sampled: matches!(dataset.kind, Kind::Series | Kind::Sensor),
            of_sensor: dataset.kind == Kind::Sensor,
            gain: 1.0,
            interval: OnceCell::new(),
            bends: OnceCell::new(),
        };
        for column in &dataset.columns {
            if CAUSES.contains(&column.role) {
                let values: Vec<f64> = column.si().collect();
                found.add(&column.name, column.role, column.unit, values);
            }
        }
        found
    }

    /// Adds a field that may be a cause. A constant field cannot be one, and is left out.
    pub fn add(&mut self, name: &str, role: Role, unit: Unit, mut values: Vec<f64>) {
        let wraps = unit.dimension() == Dimension::Angle;
        if wraps {
            self.unwrap_angle(&mut values);
        }
        let smooth = self.smooth(&values);
        for (value, level) in values.iter_mut().zip(&smooth.level) {
            if !value.is_finite() {
                *value = *level;
            }
        }
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let range @ (low, high) = robust::ends(finite);
        if !(high > low) || values.iter().any(|value| !value.is_finite()) {
            return;
        }
        self.channels.push(Channel { name: name.to_owned(), role, unit, values, smooth, range });
    }

    /// Unwraps an angle, stretch by stretch.
    pub(super) fn unwrap_angle(&self, values: &mut [f64]) {
        for range in &self.segments {
            super::unwrap(&mut values[range.clone()]);
        }
    }

    /// Level and slope of `values`, stretch by stretch.
    pub fn smooth(&self, values: &[f64]) -> Smooth {
        let mut whole = Smooth { level: Vec::new(), slope: Vec::new() };
        for range in &self.segments {
            let part = signal::smooth(&self.time[range.clone()], &values[range.clone()]);
            whole.level.extend(part.level);
            whole.slope.extend(part.slope);
        }
        whole
    }

    /// Index of the segment of each row.
    pub fn segment_of_rows(&self) -> Vec<usize> {
        let mut found = vec![0; self.time.len()];
        for (index, range) in self.segments.iter().enumerate() {
            found[range.clone()].fill(index);
        }
        found
    }

    pub fn named(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The first channel with that role.
    pub fn of(&self, role: Role) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.role == role)
    }

    /// Applies `f` to each stretch of time of `values`, with its times.
    pub fn by_segment(&self, values: &[f64], f: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> Vec<f64> {
        self.segments
            .iter()
            .flat_map(|range| f(&self.time[range.clone()], &values[range.clone()]))
            .collect()
    }

    /// How `values` are bent in the interval that ends at each row.
    pub fn bends(&self, values: &[f64]) -> Vec<Bends> {
        let of =
            |range: &Range<usize>| signal::bends(&self.time[range.clone()], &values[range.clone()]);
        self.segments.iter().flat_map(of).collect()
    }

    /// How the rotation is.
    pub fn bends_of_rotation(&self) -> &[Bends] {
        self.bends.get_or_init(|| self.bends(&self.rotation))
    }

    /// Typical time from row to row.
    pub fn interval(&self) -> f64 {
        *self.interval.get_or_init(|| {
            let steps = |range: &Range<usize>| {
                self.time[range.clone()].windows(2).map(|pair| pair[1] - pair[0])
            };
            let mut steps: Vec<f64> = self.segments.iter().flat_map(steps).collect();
            steps.sort_by(f64::total_cmp);
            steps.get(steps.len() / 2).copied().unwrap_or(1.0)
        })
    }

    /// Longest stretch of time.
    pub fn span(&self) -> f64 {
        self.segments
            .iter()
            .map(|range| self.time[range.end - 1] - self.time[range.start])
            .fold(0.0, f64::max)
    }
}
