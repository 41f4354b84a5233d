//! How late what is measured comes, at first sight: delays of many samples lie far from those that are tried.

use crate::moments::Moments;
use crate::problem::{Aggregate, Block, Channels};
use crate::signal::interpolate;

/// Number of samples up to which every one is tried as a delay, and the factor between larger ones.
const EACH: usize = 40;
const FACTOR: f64 = 1.05;
/// Maximum delay, as a share of the longest stretch of time: of a longer one too little is left to compare.
const SHARE_MAX: f64 = 0.2;
/// Minimum number of rows, and the number that is enough.
const ROWS_MIN: usize = 200;
const ROWS: usize = 3000;
/// Share of the squares that must be left at most. Of hundreds of delays that are tried in noise, the best takes away far
/// less.
const LEFT_MAX: f64 = 0.8;

/// The delay (negative: a lead), s, at which the moved rotation leaves least of the readings of `block` beside a bias and a
/// scale; `None` if no delay takes away much.
pub(super) fn delay(block: &Block, channels: &Channels) -> Option<f64> {
    let interval = channels.interval();
    let longest = channels
        .segments
        .iter()
        .map(|range| channels.time[range.end - 1] - channels.time[range.start])
        .fold(0.0, f64::max);
    if block.aggregate != Aggregate::Row || block.rows.len() < ROWS_MIN || !(interval > 0.0) {
        return None;
    }
    let stride = block.rows.len().div_ceil(ROWS);
    let mut stretch = 0;
    let mut rows = Vec::new();
    for (&row, &error) in block.rows.iter().zip(&block.residual).step_by(stride) {
        while channels.segments.get(stretch)?.end <= row {
            stretch += 1;
        }
        rows.push((channels.segments[stretch].clone(), row, error + channels.rotation[row]));
    }
    // Squares that are left with the rotation moved and at its place, in rows that have both.
    let left = |delay: f64| -> Option<(f64, f64)> {
        let (mut moved, mut still) = (Vec::new(), Vec::new());
        for (range, row, reading) in &rows {
            let at = channels.time[*row] - delay;
            let (times, values) =
                (&channels.time[range.clone()], &channels.rotation[range.clone()]);
            if at >= times[0] && at <= times[times.len() - 1] {
                moved.push((interpolate(times, values, at), *reading));
                still.push((channels.rotation[*row], *reading));
            }
        }
        (moved.len() >= ROWS_MIN.min(rows.len() / 2)).then(|| (rest(&moved), rest(&still)))
    };
    let mut multiples: Vec<f64> = (1..=EACH).map(|samples| samples as f64).collect();
    while let Some(&last) = multiples.last()
        && last * FACTOR * interval < SHARE_MAX * longest
    {
        multiples.push(last * FACTOR);
    }
    let tried = multiples.iter().flat_map(|multiple| [*multiple, -*multiple]);
    let shares = tried
        .map(|multiple| multiple * interval)
        .filter(|delay| delay.abs() < SHARE_MAX * longest)
        .filter_map(|delay| left(delay).map(|(moved, still)| (delay, moved / still)));
    let (delay, share) = shares.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (share < LEFT_MAX).then_some(delay)
}

/// Sum of squares of the second of each pair beside a line over the first.
fn rest(pairs: &[(f64, f64)]) -> f64 {
    let Moments { xx, xy, yy, .. } = Moments::of(pairs.iter().copied());
    if xx > 0.0 { yy - xy * xy / xx } else { yy }
}
