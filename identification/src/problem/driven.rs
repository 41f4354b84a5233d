//! A driven path: the heading and the distance that the wheels tell, against the reference.

use super::channels::Channels;
use super::gyro::{self, missing};
use super::path::Path;
use super::wheels::{self, Motion};
use super::{Aggregate, Block, DisplayUnit, Exposure, Problem, wrap};
use crate::dataset::{Dataset, Role, Unit};
use crate::identify::IdentifyError;
use crate::model::Acts;
use std::ops::Range;

/// Metres driven that bring as much random walk of the heading as a turn of one radian (assumption: half the track
/// of a small robot; it only shares out noise between rows).
const METRES_PER_RADIAN: f64 = 0.1;

pub(super) fn odometry(dataset: &Dataset, mut channels: Channels) -> Result<Problem, IdentifyError> {
    let motion = wheels::motion(dataset, &channels)?;
    let reference = |role, what| {
        dataset.column(role).map(|column| column.si().collect::<Vec<f64>>()).ok_or_else(|| missing(what))
    };
    let path = Path {
        reference: [
            reference(Role::ReferenceX, "reference x")?,
            reference(Role::ReferenceY, "reference y")?,
            reference(Role::ReferenceHeading, "reference heading")?,
        ],
        runs: runs(&channels.run),
        distance: motion.distance.clone(),
        turn: motion.turn.clone(),
    };
    let heading = dense_heading(&path);
    add_channels(dataset, &mut channels, &motion, &heading);
    let activity: Vec<f64> = motion
        .distance
        .iter()
        .zip(&motion.turn)
        .map(|(distance, turn)| distance.abs() + METRES_PER_RADIAN * turn.abs())
        .collect();
    let mut blocks = vec![
        heading_block(&path, &activity),
        forward_block(&path, &heading, &activity),
    ];
    blocks.retain(|block| block.rows.len() > block.exposures.len() + 2);
    if blocks.is_empty() {
        return Err(missing("reference in enough rows"));
    }
    blocks.extend(gyro::beside_odometry(dataset, &mut channels));
    Ok(Problem { kind: dataset.kind, channels, blocks, path: Some(path), counts_per_unit: None, notices: Vec::new() })
}

fn runs(run_of_row: &[usize]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for row in 1..=run_of_row.len() {
        if row == run_of_row.len() || run_of_row[row] != run_of_row[row - 1] {
            found.push(start..row);
            start = row;
        }
    }
    found
}

/// Heading at every row: the references, and the odometry between them with its error shared out evenly.
fn dense_heading(path: &Path) -> Vec<f64> {
    let headings = &path.reference[2];
    let mut dense = vec![0.0; headings.len()];
    for rows in &path.runs {
        let known: Vec<usize> = rows.clone().filter(|&row| headings[row].is_finite()).collect();
        let Some((&first, &last)) = known.first().zip(known.last()) else {
            continue;
        };
        dense[first] = headings[first];
        for row in (rows.start..first).rev() {
            dense[row] = dense[row + 1] - path.turn[row + 1];
        }
        for pair in known.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let turned: f64 = path.turn[from + 1..=to].iter().sum();
            let missing = wrap(headings[to] - headings[from] - turned);
            let share = missing / (to - from) as f64;
            for row in from + 1..=to {
                dense[row] = dense[row - 1] + path.turn[row] + share;
            }
        }
        for row in last + 1..rows.end {
            dense[row] = dense[row - 1] + path.turn[row];
        }
    }
    dense
}

fn add_channels(dataset: &Dataset, channels: &mut Channels, motion: &Motion, heading: &[f64]) {
    let rate = |values: &[f64]| -> Vec<f64> {
        let mut found = vec![0.0; values.len()];
        for range in &channels.segments {
            for row in range.start + 1..range.end {
                found[row] = values[row] / (channels.time[row] - channels.time[row - 1]);
            }
        }
        found
    };
    let speed = rate(&motion.distance);
    let turn_rate = rate(&motion.turn);
    let level = channels.smooth(&speed);
    channels.rotation = channels.smooth(&turn_rate).level;
    channels.direction_name.get_or_insert_with(|| "direction".to_owned());
    channels.add("speed", Role::Auxiliary, Unit::MetrePerSecond, level.level);
    channels.add("acceleration", Role::Auxiliary, Unit::MetrePerSecondSquared, level.slope);
    if channels.of(Role::Heading).is_none() {
        let name = dataset
            .column(Role::ReferenceHeading)
            .map_or("heading", |column| column.name.as_str())
            .to_owned();
        channels.add(&name, Role::Heading, Unit::Degree, heading.to_vec());
    }
}

fn heading_block(path: &Path, activity: &[f64]) -> Block {
    let headings = &path.reference[2];
    let (mut rows, mut residual, mut raw) = (Vec::new(), Vec::new(), Vec::new());
    for run in &path.runs {
        let (mut odometry, mut last) = (0.0, None::<f64>);
        for row in run.clone() {
            odometry += path.turn[row];
            if headings[row].is_finite() {
                let difference = headings[row] - odometry;
                let unwrapped =
                    last.map_or_else(|| wrap(difference), |last| last + wrap(difference - last));
                last = Some(unwrapped);
                rows.push(row);
                residual.push(unwrapped);
                raw.push(headings[row]);
            }
        }
    }
    let degree = Unit::Degree.si();
    Block {
        label: "heading".to_owned(),
        axis: None,
        aggregate: Aggregate::Level,
        rows,
        residual,
        raw,
        raw_si: 1.0,
        spread: Vec::new(),
        exposures: vec![
            Exposure { acts: Acts::Turn, per_row: path.turn.clone(), unit: DisplayUnit::new("1", 1.0) },
            Exposure {
                acts: Acts::Curvature,
                per_row: path.distance.clone(),
                unit: DisplayUnit::new("deg/m", degree),
            },
        ],
        constants: Vec::new(),
        unit: DisplayUnit::new("deg", degree),
        activity: Some(activity.to_vec()),
    }
}

/// Distance between references, along the displacement that the odometry gives between them.
fn forward_block(path: &Path, heading: &[f64], activity: &[f64]) -> Block {
    let [xs, ys, _] = &path.reference;
    let mut per_row = vec![0.0; path.distance.len()];
    let (mut rows, mut residual, mut raw) = (Vec::new(), Vec::new(), Vec::new());
    for run in &path.runs {
        let known: Vec<usize> =
            run.clone().filter(|&row| xs[row].is_finite() && ys[row].is_finite()).collect();
        let mut sum = 0.0;
        if let Some(&first) = known.first() {
            rows.push(first);
            residual.push(0.0);
            raw.push(xs[first]);
        }
        for pair in known.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let step = |row: usize| {
                let middle = (heading[row - 1] + heading[row]) / 2.0;
                (middle.cos() * path.distance[row], middle.sin() * path.distance[row])
            };
            let (mut dx, mut dy) = (0.0, 0.0);
            for row in from + 1..=to {
                let (x, y) = step(row);
                (dx, dy) = (dx + x, dy + y);
            }
            let length = dx.hypot(dy);
            // Standing still or back where it began: along the heading.
            let along = if length > 1e-9 { (dx / length, dy / length) } else { (heading[to].cos(), heading[to].sin()) };
            for row in from + 1..=to {
                let (x, y) = step(row);
                per_row[row] = x * along.0 + y * along.1;
            }
            sum += (xs[to] - xs[from]) * along.0 + (ys[to] - ys[from]) * along.1
                - (dx * along.0 + dy * along.1);
            rows.push(to);
            residual.push(sum);
            raw.push(xs[to]);
        }
    }
    Block {
        label: "distance".to_owned(),
        axis: None,
        aggregate: Aggregate::Level,
        rows,
        residual,
        raw,
        raw_si: 1.0,
        spread: Vec::new(),
        exposures: vec![Exposure { acts: Acts::Drive, per_row, unit: DisplayUnit::new("1", 1.0) }],
        constants: Vec::new(),
        unit: DisplayUnit::new("m", 1.0),
        activity: Some(activity.to_vec()),
    }
}
