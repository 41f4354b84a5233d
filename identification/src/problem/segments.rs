//! Ranges of rows: in which time advances without a break, of runs, and of what counts as independent of one another.

use std::ops::Range;

/// Ranges of rows in which time advances: a new one starts where time goes back, or where a new run starts after a gap
/// much longer than the row interval.
pub fn segments(times: &[f64], runs: &[usize]) -> Vec<Range<usize>> {
    const GAP: f64 = 10.0;
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let typical = steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY);
    let mut found = Vec::new();
    let mut start = 0;
    for i in 1..times.len() {
        let step = times[i] - times[i - 1];
        if step <= 0.0 || (runs[i] != runs[i - 1] && step > GAP * typical) {
            found.push(start..i);
            start = i;
        }
    }
    if !times.is_empty() {
        found.push(start..times.len());
    }
    found
}

/// Where consecutive rows have the same `key`.
pub fn runs<K: PartialEq>(key: &[K]) -> impl Iterator<Item = Range<usize>> {
    key.chunk_by(|one, next| one == next).scan(0, |end, own| {
        *end += own.len();
        Some(*end - own.len()..*end)
    })
}

/// Fewer runs than this are cut into stretches.
const RUNS_MIN: usize = 6;
const STRETCHES: usize = 12;

/// Cluster of each row, by the run of each: its run, or its stretch if runs are few.
pub fn clusters(run: &[usize]) -> Vec<usize> {
    if runs(run).count() < RUNS_MIN {
        return (0..run.len()).map(|i| i * STRETCHES / run.len()).collect();
    }
    let of = |(cluster, rows): (usize, Range<usize>)| rows.map(move |_| cluster);
    runs(run).enumerate().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::segments;

    #[test]
    fn runs_that_follow_one_another_are_one_stretch_of_time() {
        let turns = segments(&[0.0, 12.0, 30.0, 42.0, 60.0], &[0, 0, 1, 1, 2]);
        assert_eq!((turns.len(), turns[0].clone()), (1, 0..5));
        let restarted = segments(&[0.0, 1.0, 0.0, 1.0], &[0, 0, 1, 1]);
        assert_eq!(restarted, [0..2, 2..4]);
        let apart = segments(&[0.0, 1.0, 900.0, 901.0], &[0, 0, 1, 1]);
        assert_eq!(apart, [0..2, 2..4]);
    }
}
