//! Readings and references that are wrong by themselves: spikes, wrong rows, values that a logger held. They are set aside
//! before any fit, counted, and told; an error that goes with an input is structure and stays.

mod apart;
mod errors;
mod senseless;

use crate::dataset::{Axis, Column, Dataset, Kind, Role};
use crate::finding::{Left, SetAside};
use crate::model::Shape;
use crate::problem::{Aggregate, Block, Channels, Problem};
use apart::{Input, apart, gone_with};
use errors::{Errors, poses, residual};
pub(crate) use senseless::senseless;

/// Cells to set aside, all of one quantity.
#[derive(Debug, Clone)]
pub(crate) struct Wild {
    /// Names of the columns.
    columns: Vec<String>,
    /// Rows of the cells.
    rows: Vec<usize>,
    /// Whether they get the mean of the rows around instead of none: a motion that is missing would be none at all.
    bridged: bool,
    /// For the finding.
    pub told: SetAside,
}

/// Outliers of each quantity of `problem` beside its `terms`, and what would be outliers but goes with an input.
pub(crate) fn find(
    dataset: &Dataset,
    problem: &Problem,
    terms: &[Vec<Shape>],
) -> (Vec<Wild>, Vec<Left>) {
    let blocks = problem.blocks.iter().zip(terms);
    let (wild, left): (Vec<_>, Vec<_>) =
        blocks.map(|(block, terms)| of_block(dataset, problem, block, terms)).unzip();
    (wild.into_iter().flatten().collect(), left.into_iter().flatten().collect())
}

/// Readings that the noise of a fit does without (`left_out`), if they go with an input: they are no noise.
pub(crate) fn swallowed(block: &Block, channels: &Channels, left_out: &[bool]) -> Option<Left> {
    let at: Vec<usize> = (0..left_out.len()).filter(|&i| left_out[i]).collect();
    if block.aggregate != Aggregate::Row || at.len() < LEFT_MIN {
        return None;
    }
    let inputs = inputs(block, channels, &block.rows, &at);
    let (input, _) = gone_with(&at, &inputs)?;
    Some(Left::of_rows((at.len(), block.rows.len()), &block.label, input))
}

/// Sets the cells in `dataset` aside.
pub(crate) fn set_aside(dataset: &mut Dataset, wild: &[Wild]) {
    let Dataset { columns, run_of_row, .. } = dataset;
    for Wild { columns: names, rows, bridged, .. } in wild {
        for column in columns.iter_mut().filter(|column| names.contains(&column.name)) {
            rows.iter().for_each(|&row| column.values[row] = f64::NAN);
            for &row in rows.iter().filter(|_| *bridged) {
                let known = |other: &usize| column.values[*other].is_finite();
                let mine = |other: &usize| run_of_row[*other] == run_of_row[row];
                let before = (0..row).rev().take_while(mine).find(known);
                let after = (row + 1..run_of_row.len()).take_while(mine).find(known);
                let [before, after] = [before.or(after), after.or(before)]
                    .map(|other| other.map_or(0.0, |other| column.values[other]));
                column.values[row] = f64::midpoint(before, after);
            }
        }
    }
}

/// Rows of outliers, the least and the largest distance from the rows around, and the number of rows judged.
#[derive(Default)]
struct Rows {
    rows: Vec<usize>,
    limit: f64,
    largest: f64,
    of: usize,
    /// Errors that would be outliers but go with an input.
    left: Option<Left>,
}

impl Rows {
    fn of(all: &[Errors], block: &Block, channels: &Channels, terms: &[Shape]) -> Self {
        let mut found = Self::default();
        for errors in all {
            let run: Vec<usize> = errors.row.iter().map(|&row| channels.run[row]).collect();
            let inputs = |at: &[usize]| match errors.motion.is_empty()
                && block.aggregate != Aggregate::Row
            {
                // The inputs of a motion are derived from the motion.
                true => Vec::new(),
                false => inputs(block, channels, &errors.row, at),
            };
            found.of = found.of.max(errors.row.len());
            if let Some(apart) = apart(&errors.value, &run, (errors.step, &errors.least), inputs) {
                let rows = apart.at.iter().map(|&i| errors.row[i]);
                let rows = rows.filter(|&row| !is_unknown(terms, channels, row));
                if let Some(input) = &apart.goes_with {
                    let (count, of, label) = (rows.count(), found.of, &block.label);
                    found.left =
                        (count >= LEFT_MIN).then(|| Left::of_rows((count, of), label, input));
                    continue;
                }
                found.rows.extend(rows);
                if apart.largest > found.largest {
                    (found.limit, found.largest) = (apart.limit, apart.largest);
                }
            }
        }
        found.rows.sort_unstable();
        found.rows.dedup();
        found
    }
}

fn of_block(
    dataset: &Dataset,
    problem: &Problem,
    block: &Block,
    terms: &[Shape],
) -> (Option<Wild>, Option<Left>) {
    if block.closing.is_some() {
        return (None, None);
    }
    let channels = problem.channels_of(block);
    let all = match &block.pose {
        Some(_) => poses(problem),
        None => vec![residual(block, channels, terms)],
    };
    let mut found = Rows::default();
    if block.aggregate != Aggregate::Row {
        // A wrong motion bends all that follows it.
        let changes: Vec<Errors> = all.iter().map(|one| one.changes(&channels.run)).collect();
        found = Rows::of(&changes, block, channels, terms);
    }
    let bridged = !found.rows.is_empty();
    if !bridged {
        found = Rows::of(&all, block, channels, terms);
    }
    let columns = columns(dataset, block, bridged);
    if found.rows.is_empty() || columns.is_empty() {
        return (None, found.left.filter(|_| block.aggregate == Aggregate::Row));
    }
    let unit = if block.pose.is_some() { ("m", 1.0) } else { (&*block.unit.text, block.unit.si) };
    let wild = Wild {
        told: SetAside {
            quantity: if bridged { columns.join(" and ") } else { block.label.clone() },
            rows: found.rows.len(),
            of: found.of,
            limit: found.limit / unit.1,
            largest: found.largest / unit.1,
            unit: unit.0.to_owned(),
            times: found.rows.iter().take(TOLD).map(|&row| channels.time[row]).collect(),
        },
        columns,
        rows: found.rows,
        bridged,
    };
    (Some(wild), found.left)
}

/// Number of rows that go with an input from which they are told as left: fewer are as many as noise has.
const LEFT_MIN: usize = 5;
/// Number of outliers whose times are told.
const TOLD: usize = 10;
/// Number of time constants after which a beginning is forgotten.
const FORGOTTEN: f64 = 5.0;

/// Whether what one of `terms` says of a row depends on what was before its stretch, or comes after it.
fn is_unknown(terms: &[Shape], channels: &Channels, row: usize) -> bool {
    let reach = terms
        .iter()
        .flat_map(|term| ["delay", "time_constant"].map(|name| term.number(name)))
        .flatten()
        .fold(0.0, |most: f64, number| most.max(FORGOTTEN * number.abs()));
    let stretch = channels.segments.iter().find(|stretch| stretch.contains(&row));
    stretch.is_some_and(|stretch| {
        let time = &channels.time;
        let ends = [time[row] - time[stretch.start], time[stretch.end - 1] - time[row]];
        reach > 0.0 && (ends[0] <= reach || ends[1] <= reach)
    })
}

/// What the outliers `at` could go with, at these rows: every channel and the rotation, their sizes and those of their
/// slopes. What is derived from the readings or the reference themselves is taken without the outliers.
fn inputs(block: &Block, channels: &Channels, rows: &[usize], at: &[usize]) -> Vec<Input> {
    let mut found = Vec::new();
    let mut add = |name: &str, of: &dyn Fn(usize) -> f64| {
        found.push((name.to_owned(), rows.iter().map(|&row| of(row)).collect()));
    };
    if !channels.rotation.is_empty() {
        let mut rotation = channels.rotation.clone();
        let is_known = |i: &usize| at.binary_search(i).is_err();
        for &i in at {
            // The smoothed course would differ from the values of the other rows.
            let before = (0..i).rev().find(is_known).unwrap_or(i);
            let after = (i + 1..rows.len()).find(is_known).unwrap_or(before);
            let [before, after] = [before, after].map(|known| channels.rotation[rows[known]]);
            rotation[rows[i]] = f64::midpoint(before, after);
        }
        let slope = channels.smooth(&rotation).slope;
        let name = &channels.rotation_name;
        add(name, &|row| rotation[row]);
        add(&format!("abs({name})"), &|row| rotation[row].abs());
        add(&format!("rate_of({name})"), &|row| slope[row].abs());
    }
    let is_own = |role: Role| role == Role::Heading && block.aggregate != Aggregate::Row;
    for channel in channels.channels.iter().filter(|channel| !is_own(channel.role)) {
        let name = &channel.name;
        if channel.is_angle() {
            add(name, &|row| channel.values[row].sin());
            add(name, &|row| channel.values[row].cos());
        } else {
            add(name, &|row| channel.values[row]);
        }
        add(&format!("rate_of({name})"), &|row| channel.smooth.slope[row].abs());
    }
    found
}

/// What the wheels report: its sum is the way of the robot.
const MOTION: [Role; 4] =
    [Role::WheelLeft, Role::WheelRight, Role::DriveDistance, Role::SteerAngle];

/// Columns that are set aside with an outlier: the reading and its reference, since either may be wrong; of a level or a
/// pose the reference, or the motion.
fn columns(dataset: &Dataset, block: &Block, motion: bool) -> Vec<String> {
    use Role as R;
    let roles: &[Role] = match (block.aggregate, dataset.kind) {
        (Aggregate::Pose, _) if motion => &MOTION,
        (Aggregate::Pose, _) => &[R::ReferenceX, R::ReferenceY, R::ReferenceHeading],
        (Aggregate::Level, _) if !motion => &[R::ReferenceHeading],
        (Aggregate::Row, Kind::Series) => &[R::ReferenceRate],
        (Aggregate::Row, Kind::Sensor) => &[R::Reference],
        _ => &[],
    };
    let reads = motion || block.aggregate == Aggregate::Row;
    let mine = |column: &&Column| {
        let is_same = Axis::agree(column.axis, block.axis);
        (roles.contains(&column.role) && is_same) || (reads && column.name == block.label)
    };
    dataset.columns.iter().filter(mine).map(|column| column.name.clone()).collect()
}

/// Adds the outliers of a later round to those of each quantity.
pub(crate) fn join(told: &mut Vec<SetAside>, wild: Vec<Wild>) {
    for Wild { told: more, .. } in wild {
        match told.iter_mut().find(|one| one.quantity == more.quantity) {
            Some(one) => {
                one.rows += more.rows;
                (one.limit, one.largest) =
                    (one.limit.min(more.limit), one.largest.max(more.largest));
                one.times.extend(more.times);
                one.times.truncate(TOLD);
            }
            None => told.push(more),
        }
    }
}

impl Left {
    /// That many rows, of all, that are off where an input is alike.
    fn of_rows((count, of): (usize, usize), label: &str, input: &str) -> Self {
        Self {
            drivers: vec![input.to_owned()],
            shape: format!("{count} of {of} rows of {label}, far from others with a like {input}"),
            share_of_residual_variance: count as f64 / of.max(1) as f64,
        }
    }
}
