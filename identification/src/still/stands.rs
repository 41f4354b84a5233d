//! Readings that move beside a reference that stands still, and readings that stand still beside one that moves. Such fields do
//! not belong together, and nothing that is wrong with a sensor explains it.

use super::course::is_course;
use super::{Wrong, is_read, is_still, leave_out};
use crate::corrections::{Correction, Poses, applied, heading_of, turned};
use crate::dataset::{Axis, Column, Dataset, Dimension, Kind, Role};
use crate::error::IdentifyError;
use crate::linear::{Basis, dot};
use crate::problem::{Channels, motion, runs, unwrap, wrap};
use crate::robust::{self, median, root_mean_square, squared_correlation};

/// Rows are taken together over this time: vibration is no motion, s.
const BLOCK: f64 = 0.25;
/// Motion of the field that stands, over that of the one that moves.
const STANDS: f64 = 0.05;
/// Squared correlation from which readings follow a reference all the same, in another unit.
const FOLLOWS: f64 = 0.5;
/// Share of the blocks that are no farther off than the others can be: a wild reading is no motion.
const WILD: f64 = 0.98;
/// Motion over the noise of a block of rows.
const NOISE: f64 = 4.0;
/// Least motion of a gyro that no bias of one explains, rad/s: 1 deg/s about its median, there and back at least that many times
/// (gyros at rest on a bench: 0.1 deg/s; the one that is cooled and heated by 90 K: 1 deg/s, there and back once).
const TURNS: f64 = 0.02;
const TIMES: usize = 8;
/// The same of counts, whose unit nothing tells without a reference that moves, over the noise of a row.
const COUNTS: f64 = 30.0;
/// Least motion of an angle that no error of a sensor explains, rad, and of any other sensor, as a share of its reference.
const ANGLE: f64 = 0.5;
const SHARE: f64 = 0.2;
/// The same beside a reference near zero, and of an angle, over the noise of a block: nothing else tells what is large.
const FAR: f64 = 10.0;
/// Share of the motion that what warms a sensor or feeds it may leave for a cause.
const LEAVES: f64 = 0.5;

/// Takes readings out of `dataset` that do not belong to their reference. `right` says which field is which.
///
/// # Errors
///
/// When no other readings are left.
pub(crate) fn without(dataset: &mut Dataset, right: &[Correction]) -> Result<(), IdentifyError> {
    let right = applied(dataset, right);
    let readings = right.columns.iter().filter(|column| is_read(column));
    let wrong = |column: &Column| {
        let [told, advice] = told(&right, column)?;
        Some(Wrong { name: column.name.clone(), told, advice: Some(advice) })
    };
    leave_out(dataset, readings.filter_map(wrong).collect())
}

/// What is wrong with the readings in `column`, if they and their reference do not move together, and what to do.
fn told(dataset: &Dataset, column: &Column) -> Option<[String; 2]> {
    let mine = |one: &&Column| Axis::agree(one.axis, column.axis);
    let [first, second] = match dataset.kind {
        Kind::Sensor => [Role::Reference; 2],
        Kind::Series | Kind::Odometry => [Role::ReferenceRate, Role::ReferenceHeading],
        _ => return None,
    };
    let find = |role| dataset.columns_of(role).find(mine);
    let reference = find(first).or_else(|| find(second))?;
    let [read, truth] = [column, reference].map(|one| Course::new(dataset, one));
    if read.blocks.is_empty() || truth.blocks.is_empty() {
        return None;
    }
    // A reading at the moment of a sparse heading is not the mean since the one before.
    let follows = match heading_of(dataset, column) {
        Some(heading) => {
            let [truth, read] = turned(dataset, column, heading);
            squared_correlation(&read, &truth)
        }
        None => squared_correlation(&read.values, &truth.values),
    };
    if follows > FOLLOWS {
        return None;
    }
    let is_count = column.unit.dimension() == Dimension::Count;
    let truth_moves = truth.moves() > NOISE * truth.noise;
    if truth_moves && !is_count && read.moves() < STANDS * truth.moves() {
        let (read, reference) = (&column.name, &reference.name);
        let (span, unit) = (truth.span() / truth.unit.1, &truth.unit.0);
        return Some([
            format!(
                "`{read}` does not move while its reference `{reference}` moves by {span:.3} {unit}"
            ),
            format!(
                "check the wiring of `{read}`, or name the column that belongs to `{reference}`"
            ),
        ]);
    }
    let stands = if is_count { !truth_moves } else { truth.moves() < STANDS * read.moves() };
    (stands && is_motion(dataset, column, &read, median(truth.values.clone()))).then(|| {
        let verb = if dataset.kind == Kind::Sensor { "moves" } else { "turns" };
        let (moves, still) = (&column.name, &reference.name);
        let (span, unit) = (read.span() / read.unit.1, &read.unit.0);
        [
            format!("the reference `{still}` does not move while `{moves}` {verb} by {span:.3} {unit}"),
            format!(
                "give the column that measures what `{moves}` does as its reference, or, if the device was at rest, what \
                 moved it as a temperature or an auxiliary"
            ),
        ]
    })
}

/// Number of legs of a path.
const LEGS: usize = 60;
/// Most turn of a leg, rad: beyond, the ends of a way do not tell its length.
const BENT: f64 = 1.0;

/// Refuses a path whose reference stands still while the wheels turn, or the reverse.
///
/// # Errors
///
/// That one.
pub(super) fn path(dataset: &Dataset, poses: &Poses) -> Result<(), IdentifyError> {
    let legs = poses.legs(LEGS);
    let Ok(motion) = motion(dataset, &Channels::new(dataset)) else { return Ok(()) };
    let [way, turn] =
        [&motion.distance, &motion.turn].map(|per_row| poses.sums(&legs, per_row, 0.0));
    let straight: Vec<usize> = (0..legs.len()).filter(|&leg| turn[leg].abs() < BENT).collect();
    let size =
        |of: &dyn Fn(usize) -> f64| straight.iter().map(|&leg| of(leg).powi(2)).sum::<f64>().sqrt();
    let wheels = [size(&|leg| way[leg]), size(&|leg| turn[leg])];
    let robot =
        [size(&|leg| legs[leg].along.hypot(legs[leg].aside)), size(&|leg| legs[leg].turned)];
    let along = |leg: &usize| legs[*leg].along;
    let [way, along]: [Vec<f64>; 2] =
        [straight.iter().map(|&leg| way[leg]).collect(), straight.iter().map(along).collect()];
    if straight.len() < LEGS / 4 || squared_correlation(&way, &along) > FOLLOWS {
        return Ok(());
    }
    let stands = |one: [f64; 2], other: [f64; 2]| {
        other[0] > 0.0 && one[0] < STANDS * other[0] && one[1] <= STANDS * other[1]
    };
    let sum = |of: &[f64]| of.iter().map(|one| one.abs()).sum::<f64>();
    let told = if stands(robot, wheels) {
        format!("the reference of the path does not move while the wheels drive {:.3} m", sum(&way))
    } else if stands(wheels, robot) {
        format!(
            "the wheels stand still while the reference of the path moves by {:.3} m",
            sum(&along)
        )
    } else {
        return Ok(());
    };
    Err(IdentifyError(told))
}

/// Whether `read`, of `column`, is more than a sensor that stands at `truth` can be wrong by.
fn is_motion(dataset: &Dataset, column: &Column, read: &Course, truth: f64) -> bool {
    let moves = read.moves();
    if !(moves > NOISE * read.noise) {
        return false;
    }
    match (dataset.kind, column.unit.dimension()) {
        (Kind::Sensor, dimension) => {
            let is_angle = dimension == Dimension::Angle;
            if is_angle && moves > ANGLE {
                return true;
            }
            // Over a turn a sensor may be wrong in cycles.
            if dataset.columns_of(Role::Heading).any(|one| !is_still(one)) {
                return false;
            }
            // The zero of an angle is arbitrary.
            let has_scale = !is_angle && truth.abs() > SHARE * moves;
            if has_scale && !(moves > SHARE * truth.abs())
                || !has_scale && !(moves > FAR * read.noise)
                || !is_course(&read.values, &dataset.run_of_row)
            {
                return false;
            }
        }
        (_, Dimension::Count) if !(moves > COUNTS * read.noise) => return false,
        (_, Dimension::AngularRate | Dimension::Angle) if !(moves > TURNS) => return false,
        _ => {}
    }
    let mut side = 0.0_f64;
    let mut times = 0;
    for value in read.blocks.iter().filter(|value| value.abs() > moves / 2.0) {
        times += usize::from(side * value < 0.0);
        side = *value;
    }
    times >= TIMES && left_by_causes(dataset, read) > LEAVES
}

/// Share of the squares of `read` that temperatures, voltages and currents leave, and of any sensor all that was recorded beside it.
fn left_by_causes(dataset: &Dataset, read: &Course) -> f64 {
    let bears = |column: &&Column| {
        let unit = column.unit.dimension();
        let is_beside = dataset.kind == Kind::Sensor && column.role == Role::Auxiliary;
        is_beside
            || matches!(unit, Dimension::Temperature | Dimension::Voltage | Dimension::Current)
    };
    let mut columns = vec![vec![1.0; read.blocks.len()]];
    let others = dataset.columns.iter().filter(|one| !is_read(one) && !one.role.is_reference());
    for column in others.filter(bears) {
        let level = Course::new(dataset, column).at(&read.rows);
        columns.push(level.iter().map(|value| value * value).collect());
        columns.push(level);
    }
    let mut basis = Basis::default();
    basis.extend(columns);
    1.0 - basis.explained(&read.blocks) / dot(&read.blocks, &read.blocks)
}

/// What a field says of a motion: rows, and medians of blocks of them, less that of their run.
struct Course {
    /// One a row, SI; a rate of what turns. NaN where it is missing.
    values: Vec<f64>,
    blocks: Vec<f64>,
    /// First row of each block.
    rows: Vec<usize>,
    /// White noise of a block.
    noise: f64,
    /// Text of the unit of `values`, and one of it in SI.
    unit: (String, f64),
}

impl Course {
    fn new(dataset: &Dataset, column: &Column) -> Self {
        let (values, unit) = values(dataset, column);
        let (time, block) = times(dataset);
        let (mut blocks, mut rows, mut steps, mut known) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for run in runs(&dataset.run_of_row) {
            let own: Vec<usize> = run.filter(|&row| values[row].is_finite()).collect();
            let middle = median(own.iter().map(|&row| values[row]).collect());
            known += own.len();
            for rows_of in
                own.chunk_by(|&a, &b| (time[a] / block).floor() == (time[b] / block).floor())
            {
                blocks.push(median(rows_of.iter().map(|&row| values[row]).collect()) - middle);
                rows.push(rows_of[0]);
            }
            let four = |rows: &[usize]| [0, 1, 2, 3].map(|at| values[rows[at]]);
            steps.extend(own.windows(4).map(|rows| robust::third_difference(four(rows))));
        }
        let per_block = known as f64 / blocks.len().max(1) as f64;
        let mut sizes: Vec<f64> = blocks.iter().map(|block| block.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let wild =
            sizes.get((WILD * sizes.len() as f64) as usize).copied().unwrap_or(f64::INFINITY);
        let (blocks, rows) =
            blocks.into_iter().zip(rows).filter(|(block, _)| block.abs() <= wild).unzip();
        let noise = (robust::white_variance(&steps) / per_block).sqrt();
        Self { values, blocks, rows, noise, unit }
    }

    fn moves(&self) -> f64 {
        root_mean_square(&self.blocks)
    }

    fn span(&self) -> f64 {
        let (low, high) = robust::ends(self.blocks.iter().copied());
        high - low
    }

    /// The last block that begins up to each of `rows`.
    fn at(&self, rows: &[usize]) -> Vec<f64> {
        let last = |row: &usize| self.rows.partition_point(|other| other <= row).saturating_sub(1);
        rows.iter().map(|row| self.blocks.get(last(row)).copied().unwrap_or(0.0)).collect()
    }
}

/// Times of the rows, and how long a block is in them.
fn times(dataset: &Dataset) -> (Vec<f64>, f64) {
    match dataset.column(Role::Time) {
        Some(time) if time.unit.dimension() == Dimension::Time => (time.si().collect(), BLOCK),
        Some(time) => (time.values.clone(), 1.0),
        None => ((0..dataset.rows()).map(|row| row as f64).collect(), 1.0),
    }
}

/// The values of a column, SI: of a heading and of increments the rate, of an angle without its jumps of whole turns. The text of
/// their unit, and one of it in SI.
fn values(dataset: &Dataset, column: &Column) -> (Vec<f64>, (String, f64)) {
    let mut values: Vec<f64> = column.si().collect();
    let unit = (column.unit.text().to_owned(), column.unit.si());
    let is_heading = column.role == Role::ReferenceHeading;
    if !is_heading && column.role != Role::GyroAngleIncrement {
        if column.unit.dimension() == Dimension::Angle {
            unwrap(&mut values);
        }
        return (values, unit);
    }
    let (time, _) = times(dataset);
    let mut last: Option<usize> = None;
    let mut found = vec![f64::NAN; values.len()];
    for row in (0..values.len()).filter(|&row| values[row].is_finite()) {
        if let Some(last) = last.filter(|&last| dataset.run_of_row[last] == dataset.run_of_row[row])
        {
            let turned = if is_heading { wrap(values[row] - values[last]) } else { values[row] };
            found[row] = turned / (time[row] - time[last]);
        }
        last = Some(row);
    }
    (found, (format!("{}/s", unit.0), unit.1))
}
