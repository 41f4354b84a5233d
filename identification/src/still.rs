//! Fields that stand still while the device moves: a reference that has ended, an axis or a wheel that is not connected.

mod course;
mod stands;

pub(crate) use stands::without as without_standing;

use crate::corrections::{Poses, leaves, reference_of};
use crate::dataset::{Column, Dataset, Kind, Role};
use crate::error::IdentifyError;
use crate::linear::coefficients;
use crate::problem::{Channels, motion, runs};
use crate::robust::root_mean_square;
use std::ops::Range;

/// Values of a reference that repeat at the end of a run, from which it has ended.
const ENDED: usize = 5;
/// Share of the usual motion that goes on beside a reference that has ended.
const GOES_ON: f64 = 0.2;
/// Error of a sensor beside a reference that has ended, over the usual one.
const TIMES: f64 = 5.0;
/// Number of legs of a path, and share of its motion that is no motion of wheels.
const LEGS: usize = 400;
const ASIDE: f64 = 0.2;
const LEAVES: f64 = 0.5;
const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// `dataset` without references that have ended and without axes that are dead, each with a notice.
///
/// # Errors
///
/// When nothing that moves is left.
pub(crate) fn without(dataset: &mut Dataset) -> Result<(), IdentifyError> {
    match dataset.kind {
        Kind::Odometry => {
            path(dataset)?;
            let roles = [Role::ReferenceX, Role::ReferenceY, Role::ReferenceHeading];
            let is_pose = |column: &&Column| roles.contains(&column.role);
            let names = dataset.columns.iter().filter(is_pose).map(|one| one.name.clone());
            let names: Vec<String> = names.collect();
            let goes_on = beside_motion(dataset);
            end(dataset, &names, goes_on);
        }
        Kind::Series | Kind::Sensor => {
            dead(dataset)?;
            let columns = dataset.columns.iter();
            let pairs = columns.filter_map(|one| Some((one, reference_of(dataset, one)?)));
            let pairs = pairs.map(|(one, reference)| (one.values.clone(), reference.clone()));
            for (read, reference) in pairs.collect::<Vec<(Vec<f64>, Column)>>() {
                let goes_on = beside_readings(read, reference.values);
                end(dataset, std::slice::from_ref(&reference.name), goes_on);
            }
        }
        _ => {}
    }
    Ok(())
}

fn is_still(column: &Column) -> bool {
    let mut known = column.values.iter().filter(|value| value.is_finite());
    known.next().is_some_and(|first| known.all(|value| value == first))
}

/// Takes readings that never change from what is identified, where their reference does.
fn dead(dataset: &mut Dataset) -> Result<(), IdentifyError> {
    let columns = dataset.columns.iter().filter(|column| is_still(column));
    let wrong = |column: &Column| {
        let (name, reference) = (column.name.clone(), reference_of(dataset, column)?);
        (!is_still(reference)).then(|| Wrong {
            told: format!("`{name}` never changes, though its reference `{}` does", reference.name),
            advice: None,
            name,
        })
    };
    leave_out(dataset, columns.filter_map(wrong).collect())
}

fn is_read(column: &Column) -> bool {
    column.role.is_gyro() || column.role == Role::Measured
}

/// Readings that cannot be identified.
struct Wrong {
    name: String,
    /// What is wrong with them.
    told: String,
    /// What to do, if that is not plain.
    advice: Option<String>,
}

/// Takes these readings out of `dataset`.
fn leave_out(dataset: &mut Dataset, wrong: Vec<Wrong>) -> Result<(), IdentifyError> {
    for Wrong { name, told, advice } in wrong {
        let is_other = |one: &&Column| is_read(one) && one.name != name;
        if dataset.kind != Kind::Odometry && dataset.columns.iter().filter(is_other).count() == 0 {
            let advice = advice.map_or_else(String::new, |advice| format!(": {advice}"));
            return Err(IdentifyError(format!("{told}{advice}")));
        }
        dataset.columns.retain(|one| one.name != name);
        dataset.notices.push(format!("{told}: it is left out"));
    }
    Ok(())
}

/// Refuses a path that no wheels drive because one of its fields stands still.
fn path(dataset: &Dataset) -> Result<(), IdentifyError> {
    let Some(poses) = Poses::new(dataset) else { return Ok(()) };
    let legs = poses.legs(LEGS);
    let sum = |of: &dyn Fn(usize) -> f64| (0..legs.len()).map(of).sum::<f64>();
    let along = sum(&|leg| legs[leg].along.abs());
    let aside = sum(&|leg| legs[leg].aside.abs());
    let refused = |column: &Column, why: &str| {
        Err(IdentifyError(format!("`{}` never changes, {why}", column.name)))
    };
    for role in [Role::ReferenceX, Role::ReferenceY, Role::ReferenceHeading] {
        if let Some(column) = dataset.column(role).filter(|column| is_still(column))
            && aside > ASIDE * along
        {
            return refused(column, "though the rest of the reference moves as if it did");
        }
    }
    stands::path(dataset, &poses)?;
    let turned: Vec<f64> = legs.iter().map(|leg| leg.turned).collect();
    for role in [Role::WheelLeft, Role::WheelRight, Role::DriveDistance] {
        let Some(column) = dataset.column(role).filter(|column| is_still(column)) else { continue };
        if column.values.iter().any(|value| *value != 0.0) {
            continue;
        }
        // About a wheel that stands, the other one drives a circle.
        let Ok(motion) = motion(dataset, &Channels::new(dataset)) else { return Ok(()) };
        let said = poses.sums(&legs, &motion.turn, 0.0);
        let turns = turned.iter().any(|turned| *turned != 0.0);
        if along > 0.0 && turns && leaves(&said, &turned, ANY) > LEAVES {
            return refused(column, "though the robot drives");
        }
    }
    Ok(())
}

/// Whether wheels turn in a range of rows about as they usually do.
fn beside_motion(dataset: &Dataset) -> impl Fn(Range<usize>) -> bool + use<> {
    let motion = motion(dataset, &Channels::new(dataset)).map(|motion| motion.distance);
    let way: Vec<f64> =
        motion.unwrap_or_default().into_iter().map(|distance: f64| distance.abs()).collect();
    let rows = way.len();
    let mean = move |range: Range<usize>| {
        let count = range.len().max(1) as f64;
        way.get(range).map_or(0.0, |way| way.iter().sum::<f64>()) / count
    };
    let usual = mean(0..rows);
    move |range: Range<usize>| mean(range) > GOES_ON * usual
}

/// Whether readings leave their reference in a range of rows, as they do not elsewhere.
fn beside_readings(read: Vec<f64>, truth: Vec<f64>) -> impl Fn(Range<usize>) -> bool {
    move |range: Range<usize>| {
        let known = |row: &usize| (read[*row] + truth[*row]).is_finite();
        let rest = (0..read.len()).filter(|row| !range.contains(row)).filter(known);
        let rest: Vec<usize> = rest.collect();
        let of = |values: &[f64], rows: &[usize]| -> Vec<f64> {
            rows.iter().map(|&row| values[row]).collect()
        };
        let columns = [vec![1.0; rest.len()], of(&truth, &rest)];
        let line = coefficients(&columns, &of(&read, &rest));
        let [offset, slope] = line[..] else { return false };
        let error = |row: &usize| read[*row] - offset - slope * truth[*row];
        let inside: Vec<usize> = range.clone().filter(known).collect();
        let error =
            |rows: &[usize]| root_mean_square(&rows.iter().map(error).collect::<Vec<f64>>());
        inside.len() >= ENDED && error(&inside) > TIMES * error(&rest)
    }
}

/// Takes away what the columns `names` repeat at the end of each run while the device goes on.
fn end(dataset: &mut Dataset, names: &[String], goes_on: impl Fn(Range<usize>) -> bool) {
    let columns: Vec<usize> = (0..dataset.columns.len())
        .filter(|&at| names.contains(&dataset.columns[at].name))
        .collect();
    let run_of_row = dataset.run_of_row.clone();
    for run in runs(&run_of_row) {
        let values = |row: usize| columns.iter().map(move |&at| (at, row));
        let value = |(at, row): (usize, usize)| dataset.columns[at].values[row];
        let known: Vec<usize> =
            run.clone().filter(|&row| values(row).all(|cell| value(cell).is_finite())).collect();
        let last = known.last().copied();
        let repeats = |row: &&usize| {
            last.is_some_and(|last| values(**row).map(value).eq(values(last).map(value)))
        };
        let tail = known.iter().rev().take_while(repeats).count();
        let from = known.len() - tail;
        if tail > ENDED && from > 0 && goes_on(known[from] + 1..run.end) {
            let time = dataset.column(Role::Time).map_or(f64::NAN, |time| time.values[known[from]]);
            dataset.notices.push(format!(
                "{} of run {} repeats one value from {time:.3} on to the end, though the device goes on: the \
                 reference has ended there",
                names.join(", "),
                dataset.run_labels[run_of_row[run.start]],
            ));
            for &at in &columns {
                dataset.columns[at].values[known[from]..run.end].fill(f64::NAN);
            }
        }
    }
}
