//! A driven path: heading and distance from the wheels, against the reference.

use super::channels::Channels;
use super::path::{Path, bulges, chord};
use super::segments::runs;
use super::wheels::{self, Motion};
use super::{
    Acts, Aggregate, Block, Component, DisplayUnit, Exposure, Pose, Problem, heading, wrap,
};
use crate::dataset::{Constant, Dataset, Drive, Role, Unit};
use crate::error::IdentifyError;
use std::ops::Range;

/// Distance driven that adds as much random walk of the heading as a turn of one radian, m (assumption: half the track
/// of a small robot; it only distributes noise among rows).
const METRES_PER_RADIAN: f64 = 0.1;

/// Maximum number of pose observations; a denser reference is averaged.
const OBSERVATIONS_MAX: usize = 6000;

pub(super) fn odometry(
    dataset: &Dataset,
    mut channels: Channels,
) -> Result<Problem, IdentifyError> {
    let mut motion = wheels::motion(dataset, &channels)?;
    if let Some(delay) = dataset.constants.get(Constant::REFERENCE_DELAY) {
        motion.delay(delay.si(), &channels);
    }
    let reference = |role, what| -> Result<Vec<f64>, IdentifyError> {
        Ok(dataset.required(role, what)?.si().collect())
    };
    let mut reference = [
        reference(Role::ReferenceX, "reference x")?,
        reference(Role::ReferenceY, "reference y")?,
        reference(Role::ReferenceHeading, "reference heading")?,
    ];
    let ahead = wheels::length(dataset, &["reference_ahead_of_axle"]).unwrap_or(0.0);
    let left = wheels::length(dataset, &[Constant::REFERENCE_LEFT]).unwrap_or(0.0);
    if (ahead, left) != (0.0, 0.0) {
        on_the_axle(&mut reference, ahead, left);
    }
    let mut notices = Vec::new();
    let is_known = |row: usize| reference.iter().all(|values| values[row].is_finite());
    let known = (0..dataset.rows()).filter(|&row| is_known(row)).count();
    let is_dense = 2 * known >= dataset.rows();
    let whole: Vec<Range<usize>> = runs(&channels.run).collect();
    let judged = windows(&channels, whole.clone(), known, &mut notices);
    let mut path = Path {
        reference,
        // Where poses are few, each tells of all that was driven before it.
        runs: if is_dense { judged.clone() } else { whole },
        distance: motion.distance.clone(),
        turn: motion.turn.clone(),
        bulge: bulges(&motion.distance, &motion.turn, &channels),
    };
    let heading = dense_heading(&path);
    add_channels(dataset, &mut channels, &motion, &heading);
    if let Some((name, angle)) = &motion.steer {
        channels.add(name, Role::SteerAngle, Unit::Radian, angle.clone());
    }
    let activity: Vec<f64> = motion
        .distance
        .iter()
        .zip(&motion.turn)
        .map(|(distance, turn)| distance.abs() + METRES_PER_RADIAN * turn.abs())
        .collect();
    let mut blocks = vec![pose_block(&path, &heading, &activity)];
    if let Some(pose) = &mut blocks[0].pose {
        pose.half_track = wheels::half_track(dataset);
    }
    if blocks[0].rows.len() < 3 * path.runs.len() + 8 {
        return Err(IdentifyError::missing("reference in enough rows"));
    }
    path.runs = judged;
    blocks.extend(heading::beside_odometry(dataset, &mut channels));
    Ok(Problem { path: Some(path), notices, ..Problem::of(dataset.kind, channels, blocks) })
}

/// Moves the position of a reference that sits `ahead` of the middle of the axle and to its `left`, m, there.
fn on_the_axle(reference: &mut [Vec<f64>; 3], ahead: f64, left: f64) {
    let [xs, ys, headings] = reference;
    for ((x, y), heading) in xs.iter_mut().zip(ys).zip(headings) {
        *x -= ahead * heading.cos() - left * heading.sin();
        *y -= ahead * heading.sin() + left * heading.cos();
    }
}

/// Minimum number of runs; with fewer, windows of them are judged, since so few ends carry little information.
const RUNS_MIN: usize = 5;
/// Maximum and minimum number of windows: of three in a fold, one lies in it as a whole.
const WINDOWS_MAX: usize = 24;
const WINDOWS_MIN: usize = 15;
/// Minimum number of rows in a window, and of known poses on the mean.
const WINDOW_ROWS_MIN: usize = 10;

/// The runs; if they are few, cut into windows of equal duration, as far as the number of `known` poses goes.
fn windows(
    channels: &Channels,
    runs: Vec<Range<usize>>,
    known: usize,
    notices: &mut Vec<String>,
) -> Vec<Range<usize>> {
    let count = WINDOWS_MAX.min(known / WINDOW_ROWS_MIN);
    if runs.len() >= RUNS_MIN || count < WINDOWS_MIN {
        return runs;
    }
    let lasts = |run: &Range<usize>| channels.time[run.end - 1] - channels.time[run.start];
    let each = runs.iter().map(lasts).sum::<f64>() / count as f64;
    let mut found = Vec::new();
    for run in &runs {
        let mut start = run.start;
        for row in run.clone() {
            let is_last = row + 1 == run.end;
            let is_full = channels.time[row] - channels.time[start] >= each
                && run.end - row > WINDOW_ROWS_MIN;
            if is_last || is_full {
                found.push(start..row + 1);
                start = row;
            }
        }
    }
    let few = match runs.len() {
        1 => "one run is".to_owned(),
        count => format!("{count} runs are"),
    };
    notices.push(format!(
        "{few} few: errors are those at the ends of {} windows of about {each:.1} s, each from where the reference says \
         that it begins",
        found.len()
    ));
    found
}

/// Heading at every row: the references, and the odometry between them with its error distributed evenly.
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
            // How fast it is where the record begins, no row says but the next: it need not begin at rest.
            if range.len() > 1 {
                found[range.start] = found[range.start + 1];
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
    // Only the wheels of a synchro drive turn. What one of them does wrong follows their angle to the base, which keeps
    // its attitude for a run.
    if dataset.drive == Some(Drive::Synchro)
        && let Some(steering) = dataset.column(Role::SteerAngle)
    {
        let mut steered = motion.turn.clone();
        for row in 0..steered.len() {
            let is_start = row == 0 || channels.run[row] != channels.run[row - 1];
            steered[row] = if is_start { 0.0 } else { steered[row] + steered[row - 1] };
        }
        channels.add(&steering.name, Role::Heading, Unit::Degree, steered);
    }
}

/// Turn of the heading in each row.
fn turned(heading: &[f64], runs: &[Range<usize>]) -> Vec<f64> {
    let mut found = vec![0.0; heading.len()];
    for row in runs.iter().flat_map(|run| run.start + 1..run.end) {
        found[row] = wrap(heading[row] - heading[row - 1]);
    }
    found
}

/// The poses of all runs against dead reckoning from the start of each.
fn pose_block(path: &Path, true_heading: &[f64], activity: &[f64]) -> Block {
    let n = path.distance.len();
    let mut pose = Pose {
        references: Vec::new(),
        references_of_run: Vec::new(),
        groups: Vec::new(),
        component: Vec::new(),
        of_run: Vec::new(),
        starts: Vec::new(),
        displacement: [vec![0.0; n], vec![0.0; n]],
        direction: [vec![0.0; n], vec![0.0; n]],
        half_track: None,
    };
    let mut errors = Vec::new();
    let mut by_component: [Vec<f64>; 3] = Default::default();
    for run in &path.runs {
        let Some(start) = path.first_whole(run) else {
            continue;
        };
        let first = errors.len();
        let reckoned = path.reckon(start, run.end);
        let mut off = 0.0;
        for row in start + 1..run.end {
            let believed = reckoned[row - start].2 - path.turn[row] / 2.0;
            let turned = wrap(true_heading[row] - true_heading[row - 1]);
            let known = true_heading[row - 1] + turned / 2.0;
            // A path that is off by turns is off by the chord: the sine of half the error, not half the error.
            off += wrap(known - believed - off);
            let between = believed + off / 2.0;
            let way = path.distance[row] * chord(off) * chord(turned);
            pose.displacement[0][row] = way * between.cos();
            pose.displacement[1][row] = way * between.sin();
            pose.direction[0][row] = known.cos();
            pose.direction[1][row] = known.sin();
        }
        for component in [Component::Heading, Component::X, Component::Y] {
            let which = component as usize;
            let reference = &path.reference[[2, 0, 1][which]];
            let mut last: Option<f64> = None;
            for row in start..run.end {
                if !reference[row].is_finite() {
                    continue;
                }
                let (x, y, heading) = reckoned[row - start];
                let error = match component {
                    Component::Heading => {
                        let error = reference[row] - heading;
                        last.map_or_else(|| wrap(error), |last| last + wrap(error - last))
                    }
                    Component::X => reference[row] - x,
                    Component::Y => reference[row] - y,
                };
                if let Some(last) = last {
                    by_component[which].push((error - last) * std::f64::consts::FRAC_1_SQRT_2);
                }
                last = Some(error);
                errors.push(error);
                pose.references.push((row, component));
            }
        }
        pose.starts.push(start);
        pose.references_of_run.push(first..errors.len());
    }
    // Noise of each component, between consecutive references.
    let heading = crate::robust::spread(&by_component[0]).max(1e-9);
    let position =
        crate::robust::spread(&[by_component[1].clone(), by_component[2].clone()].concat())
            .max(1e-9);
    pose.group(errors.len().div_ceil(OBSERVATIONS_MAX));
    let spread = pose
        .component
        .iter()
        .map(|component| match component {
            Component::Heading => 1.0,
            _ => position / heading,
        })
        .collect();
    let rows = pose
        .groups
        .iter()
        .map(|group| pose.references[(group.start + group.end - 1) / 2].0)
        .collect();
    let residual = pose.means(&errors);
    let curvature = DisplayUnit::new("deg/m", Unit::Degree.si());
    // A reference ahead of the axle moves sideways as the robot turns.
    let aside = turned(true_heading, &path.runs);
    Block {
        aggregate: Aggregate::Pose,
        raw: residual.clone(),
        rows,
        residual,
        spread,
        exposures: vec![
            Exposure::new(Acts::Turn, path.turn.clone(), DisplayUnit::one()),
            Exposure::new(Acts::Curvature, path.distance.clone(), curvature),
            Exposure::new(Acts::Drive, path.distance.clone(), DisplayUnit::one()),
            Exposure::new(Acts::Reference, aside, Unit::Metre.into()),
        ],
        activity: Some(activity.to_vec()),
        pose: Some(pose),
        ..Block::new("pose", Unit::Degree.into())
    }
}
