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
