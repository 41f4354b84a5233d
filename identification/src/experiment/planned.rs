//! The rows that a programme would yield, in the fields of the existing data. Measured values are unknown and set to
//! nominal: only causes and times matter.

use super::timeline::{Motion, Phase};
use crate::dataset::{Axis, Column, Dataset, Dimension, Kind, Role, Unit};
use std::collections::BTreeMap;

/// Maximum rows of a planned series; each row of a longer one stands for the mean of several.
const ROWS_MAX: usize = 6000;
/// Time from row to row of a driven path, s (assumption).
const ODOMETRY_INTERVAL_S: f64 = 0.5;
/// Angle of a lap, rad.
const LAP: f64 = std::f64::consts::TAU;

/// State in one row, SI.
struct Row {
    time: f64,
    duration: f64,
    angle: f64,
    rate: f64,
    speed: f64,
    heading: f64,
    position: (f64, f64),
    celsius: f64,
    ambient: f64,
    direction: f64,
    /// Whether the pose is measured here.
    measured: bool,
    run: usize,
    levels: Vec<(String, f64)>,
}

impl Row {
    /// At `time` within `phase`.
    fn new(phase: &Phase, time: f64, celsius: f64) -> Self {
        Self {
            time,
            duration: phase.duration,
            angle: 0.0,
            rate: phase.rate(),
            speed: phase.speed(),
            heading: phase.heading + phase.rate() * (time - phase.start),
            position: (0.0, 0.0),
            celsius,
            ambient: phase.ambient,
            direction: phase.rate().signum(),
            measured: false,
            run: phase.run,
            levels: phase.levels.clone(),
        }
    }
}

pub(super) struct Planned {
    /// As a data set.
    pub dataset: Dataset,
    /// Number of samples of the existing data that each row is the mean of.
    pub samples: f64,
}

/// The rows of `phases`, in the fields of `existing`, whose rows are `interval` apart. Rotation is about `axis`. `None`
/// if the kind of data does not show the programme.
pub(super) fn planned(
    existing: &Dataset,
    interval: f64,
    axis: Option<Axis>,
    phases: &[Phase],
    celsius: impl Fn(&Phase, f64) -> f64,
) -> Option<Planned> {
    let (rows, samples) = match existing.kind {
        Kind::Turns => (turns(phases, &celsius), 1.0),
        Kind::Laps => (laps(phases, &celsius), 1.0),
        Kind::Odometry => (drive(phases, &celsius), 1.0),
        Kind::Series => series(phases, interval, &celsius),
        // No bench of this project moves what a custom sensor measures.
        Kind::Sensor => return None,
    };
    if rows.is_empty() {
        return None;
    }
    let step = rows.get(1).map_or(1.0, |second| second.time - rows[0].time);
    let columns =
        existing.columns.iter().map(|column| fill(existing, column, axis, &rows, step)).collect();
    // Runs are counted from 0 without gaps.
    let mut known: BTreeMap<usize, usize> = BTreeMap::new();
    let run_of_row: Vec<usize> = rows
        .iter()
        .map(|row| {
            let next = known.len();
            *known.entry(row.run).or_insert(next)
        })
        .collect();
    Some(Planned {
        dataset: Dataset {
            name: "planned".to_owned(),
            kind: existing.kind,
            drive: existing.drive,
            constants: existing.constants.clone(),
            columns,
            run_labels: known.keys().map(ToString::to_string).collect(),
            run_of_row,
            notices: Vec::new(),
        },
        samples,
    })
}

fn turns(phases: &[Phase], celsius: &impl Fn(&Phase, f64) -> f64) -> Vec<Row> {
    phases
        .iter()
        .filter_map(|phase| {
            let Motion::Turn { angle, rate } = phase.motion else { return None };
            let mut row = Row::new(phase, phase.end(), celsius(phase, phase.end()));
            // The heading before the turn, and the commanded rate.
            (row.heading, row.angle, row.rate) = (phase.heading, angle, rate);
            Some(row)
        })
        .collect()
}

fn laps(phases: &[Phase], celsius: &impl Fn(&Phase, f64) -> f64) -> Vec<Row> {
    let driven: Vec<&Phase> = phases.iter().filter(|phase| phase.lap.is_some()).collect();
    driven
        .chunk_by(|a, b| a.lap == b.lap)
        .filter_map(|lap| {
            let (first, last) = (lap.first()?, lap.last()?);
            let mut row = Row::new(last, last.end(), celsius(last, last.end()));
            row.direction = first.lap?.1;
            row.duration = last.end() - first.start;
            row.angle = row.direction * LAP;
            row.rate = row.angle / row.duration;
            // The way back to the start.
            row.heading = 0.0;
            Some(row)
        })
        .collect()
}

fn series(
    phases: &[Phase],
    interval: f64,
    celsius: &impl Fn(&Phase, f64) -> f64,
) -> (Vec<Row>, f64) {
    let end = phases.last().map_or(0.0, Phase::end);
    let samples = (end / interval / ROWS_MAX as f64).ceil().max(1.0);
    let step = samples * interval;
    let mut rows = Vec::new();
    let mut at = 0;
    let mut time = 0.5 * step;
    while time < end {
        while phases[at].end() <= time && at + 1 < phases.len() {
            at += 1;
        }
        let mut row = Row::new(&phases[at], time, celsius(&phases[at], time));
        // One recording, whatever happens in it.
        row.run = 0;
        row.angle = row.rate * step;
        rows.push(row);
        time += step;
    }
    (rows, samples)
}

fn drive(phases: &[Phase], celsius: &impl Fn(&Phase, f64) -> f64) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut position = (0.0, 0.0);
    let mut run = usize::MAX;
    for phase in phases.iter().filter(|phase| phase.motion != Motion::Rest) {
        if phase.run != run {
            (run, position) = (phase.run, (0.0, 0.0));
        }
        let count = (phase.duration / ODOMETRY_INTERVAL_S).ceil();
        // Pauses between the motions are skipped.
        let step = phase.duration / count;
        for k in 0..=count as usize {
            let time = phase.start + k as f64 * step;
            if k == 0 && rows.last().is_some_and(|last| last.run == run && last.time >= time) {
                continue;
            }
            let mut row = Row::new(phase, time, celsius(phase, time));
            let way = phase.speed() * (time - phase.start);
            row.position =
                (position.0 + way * phase.heading.cos(), position.1 + way * phase.heading.sin());
            row.measured = k == 0 || k == count as usize;
            rows.push(row);
        }
        position = rows.last().map_or(position, |last| last.position);
    }
    rows
}

/// The values of one field, in its unit.
fn fill(
    existing: &Dataset,
    column: &Column,
    axis: Option<Axis>,
    rows: &[Row],
    step: f64,
) -> Column {
    let turns = Axis::agree(column.axis, axis);
    let usual = mean(&column.values);
    let dense =
        2 * column.values.iter().filter(|value| value.is_finite()).count() > column.values.len();
    let track = existing
        .constants
        .iter()
        .find(|(name, _)| ["wheelbase", "track", "track_width"].contains(&name.as_str()));
    let half = track.map_or(0.0, |(_, constant)| constant.si() / 2.0);
    // The wheels report speeds, whatever they reported before: the constants for counts are not needed.
    let unit = match column.role {
        Role::WheelLeft | Role::WheelRight | Role::DriveDistance => Unit::MetrePerSecond,
        Role::SteerAngle => Unit::RadianPerSecond,
        Role::GyroCounts => Unit::RadianPerSecond,
        _ => column.unit,
    };
    let pose = |row: &Row, value: f64| {
        if dense || row.measured || existing.kind == Kind::Laps { value } else { f64::NAN }
    };
    let si = |row: &Row, number: usize| -> Option<f64> {
        let about = |value: f64| if turns { value } else { 0.0 };
        Some(match column.role {
            Role::Time if column.unit == Unit::One => number as f64,
            Role::Time => row.time,
            Role::Direction => row.direction,
            Role::GyroAngle | Role::ReferenceAngle => row.angle,
            Role::GyroRate | Role::GyroCounts | Role::ReferenceRate => about(row.rate),
            Role::GyroAngleIncrement => about(row.rate * step),
            Role::TableRate => row.rate,
            Role::Duration => row.duration,
            Role::Heading => row.heading,
            Role::ReferenceHeading if existing.kind == Kind::Laps => 0.0,
            Role::ReferenceHeading => pose(row, row.heading),
            Role::ReferenceX => pose(row, row.position.0),
            Role::ReferenceY => pose(row, row.position.1),
            Role::OdometryX | Role::OdometryY | Role::OdometryHeading => 0.0,
            Role::Temperature => row.celsius,
            Role::Auxiliary if column.unit.dimension() == Dimension::Temperature => row.ambient,
            Role::WheelLeft => row.speed - half * row.rate,
            Role::WheelRight => row.speed + half * row.rate,
            Role::DriveDistance => row.speed,
            Role::SteerAngle => row.rate,
            _ => return None,
        })
    };
    let values = rows
        .iter()
        .enumerate()
        .map(|(number, row)| {
            let set = row.levels.iter().find(|(field, _)| *field == column.name);
            set.map(|(_, value)| *value)
                .or_else(|| si(row, number).map(|value| value / unit.si()))
                .unwrap_or(usual)
        })
        .collect();
    Column { unit, values, name: column.name.clone(), role: column.role, axis: column.axis }
}

fn mean(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    finite.iter().sum::<f64>() / finite.len().max(1) as f64
}
