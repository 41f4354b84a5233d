//! Processor time of this process: on a shared machine it is less disturbed than wall-clock time.

use rustix::time::{ClockId, clock_gettime};

/// Number of runs behind each median.
pub const RUNS: usize = 5;

/// Processor time so far, s.
pub fn processor_s() -> f64 {
    let spent = clock_gettime(ClockId::ProcessCPUTime);
    spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9
}

/// The median of the figures of [`RUNS`] runs.
#[allow(dead_code, reason = "one of the benchmarks shows best and worst as well")]
pub fn median(run: impl FnMut() -> f64) -> f64 {
    let mut figures = [0.0; RUNS];
    figures.fill_with(run);
    figures.sort_by(f64::total_cmp);
    figures[RUNS / 2]
}

/// A whole number with commas between thousands.
#[allow(dead_code, reason = "another benchmark has small figures")]
pub fn grouped(figure: f64) -> String {
    let digits = format!("{figure:.0}");
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}
