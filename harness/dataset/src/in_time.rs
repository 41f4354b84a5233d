//! Rows of a run in the order of their time: repeated rows are dropped, late ones put in their place, and repeated times forgotten.

use super::table::{Rows, left_out};

/// One row in this many of a run may be late, and by no more than that share of the run: more is a clock that was set. As many may
/// say the time of the row before, and one in a shorter run: more is a clock that is coarser than the rows.
const LATE: usize = 20;

/// Puts the rows `order` selects in order of `time`, a column of `rows`, within each run.
pub(super) fn in_time(
    rows: &mut Rows,
    time: usize,
    order: &mut Vec<usize>,
    notices: &mut Vec<String>,
) {
    let mut moved = 0;
    let mut start = 0;
    while start < order.len() {
        let run = rows.runs[order[start]];
        let of_run = order[start..].iter().take_while(|row| rows.runs[**row] == run).count();
        moved += put_in_place(&rows.columns[time], &mut order[start..start + of_run]);
        start += of_run;
    }
    if moved > 0 {
        notices.push(format!("{moved} rows stood after later ones and were put in their place"));
    }
    let before = order.len();
    order.dedup_by(|row, last| is_repeated(rows, time, *row, *last));
    if order.len() < before {
        let repeated = before - order.len();
        notices.push(format!("{}: as the row before", left_out(repeated)));
    }
    let doubtful = order.chunk_by(|a, b| rows.runs[*a] == rows.runs[*b]);
    let doubtful: Vec<usize> =
        doubtful.flat_map(|run| at_one_time(&rows.columns[time], run)).collect();
    if !doubtful.is_empty() {
        let count = doubtful.len();
        notices.push(format!("{count} rows say the time of the row before: their own is unknown"));
    }
    doubtful.into_iter().for_each(|row| rows.columns[time][row] = f64::NAN);
}

/// The rows of one run that say the time of the row before; none where too many do.
fn at_one_time(times: &[f64], run: &[usize]) -> Vec<usize> {
    let mut last = f64::NAN;
    let mut found = Vec::new();
    for &row in run.iter().filter(|row| !times[**row].is_nan()) {
        if times[row] == last {
            found.push(row);
        }
        last = times[row];
    }
    found.truncate(if found.len() > (run.len() / LATE).max(1) { 0 } else { found.len() });
    found
}

/// Sorts the rows of one run by their times; the number that were late. Nothing is moved where too many are.
fn put_in_place(times: &[f64], rows: &mut [usize]) -> usize {
    let reach = rows.len() / LATE;
    let (mut late, mut is_far) = (0, false);
    // A row without a time stays behind the one before it.
    let mut at = f64::NEG_INFINITY;
    let mut latest: Vec<f64> = Vec::with_capacity(rows.len());
    let mut keys: Vec<(f64, usize)> = Vec::with_capacity(rows.len());
    for (place, &row) in rows.iter().enumerate() {
        let before = latest.last().copied().unwrap_or(at);
        if !times[row].is_nan() {
            at = times[row];
            late += usize::from(at < before);
            is_far |= place > reach && at < latest[place - reach - 1];
        }
        latest.push(before.max(at));
        keys.push((at, row));
    }
    if late == 0 || late > reach || is_far {
        return 0;
    }
    keys.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.iter_mut().zip(keys).for_each(|(row, (_, sorted))| *row = sorted);
    late
}

/// Whether a row says at the same time the same as another.
fn is_repeated(rows: &Rows, time: usize, row: usize, other: usize) -> bool {
    // A column of labels has no numbers.
    let same = |column: &Vec<f64>| {
        column.is_empty()
            || column[row] == column[other]
            || (column[row].is_nan() && column[other].is_nan())
    };
    rows.runs[row] == rows.runs[other]
        && !rows.columns[time][row].is_nan()
        && rows.columns.iter().all(same)
}
