//! Runs of which a single reading is left, once those without a reference and those that are wrong are set aside.

use super::{Aggregate, Block, Problem};
use crate::dataset::{Dataset, Kind};

/// Leaves such readings out of `problem`, with a notice: a reading that stands alone shows no change, and as a run of its own it
/// would count as much as all others.
pub(super) fn leave_out(problem: &mut Problem, dataset: &Dataset) {
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
