//! How late what is measured comes, at first sight: delays of many samples lie far from those that are tried.

use crate::problem::{Aggregate, Block, Channels};
use crate::robust::Moments;
use crate::signal::interpolate_near;

/// Longest time after which a sensor shows what is, s. Assumption: gas analysers with their lines take minutes, and hardly anything
/// takes longer. What is stamped later has a clock that nobody set.
pub(crate) const SENSOR_LATE_MAX: f64 = 400.0;
/// Number of samples up to which every one is tried as a delay, and the factor between larger ones.
const EACH: usize = 40;
const FACTOR: f64 = 1.05;
/// Maximum delay, as a share of the longest stretch of time: of a longer one too little is left to compare.
pub(crate) const SHARE_MAX: f64 = 0.2;
/// Minimum number of rows, and the number that is enough.
const ROWS_MIN: usize = 200;
const ROWS: usize = 3000;
/// Share of the squares that must be left at most. Of hundreds of delays that are tried in noise, the best takes away far
/// less.
const LEFT_MAX: f64 = 0.8;

/// A stretch of time: what is measured, and the readings of some of its rows.
pub(crate) struct Stretch<'a> {
    pub(crate) times: &'a [f64],
    pub(crate) truth: &'a [f64],
    pub(crate) readings: Vec<(usize, f64)>,
}

/// The delay (negative: a lead), s, at which the moved truth leaves least of the readings beside a bias and a scale; `None` if
/// no delay takes away much. Samples lie `interval` apart.
pub(crate) fn delay(stretches: &[Stretch<'_>], interval: f64) -> Option<f64> {
    let lasts =
        |times: &[f64]| times.last().zip(times.first()).map_or(0.0, |(end, from)| end - from);
    let longest = stretches.iter().map(|one| lasts(one.times)).fold(0.0, f64::max);
    let count: usize = stretches.iter().map(|one| one.readings.len()).sum();
    if count < ROWS_MIN || !(interval > 0.0) {
        return None;
    }
    let rows: Vec<(&Stretch<'_>, usize, f64)> = stretches
        .iter()
        .flat_map(|one| one.readings.iter().map(move |(row, reading)| (one, *row, *reading)))
        .step_by(count.div_ceil(ROWS))
        .collect();
    // Squares that are left with the truth moved, over those with it at its place, in rows that have both.
    let left = |delay: f64| -> Option<f64> {
        let (mut moved, mut still) = (Vec::new(), Vec::new());
        let mut above = 0;
        for (Stretch { times, truth, .. }, row, reading) in &rows {
            let at = times[*row] - delay;
            if at >= times[0] && at <= times[times.len() - 1] {
                moved.push((interpolate_near(times, truth, at, &mut above), *reading));
                still.push((truth[*row], *reading));
            }
        }
        (moved.len() >= ROWS_MIN.min(rows.len() / 2)).then(|| rest(&moved) / rest(&still))
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
        .filter_map(|delay| left(delay).map(|share| (delay, share)));
    let (mut delay, mut share) = shares.min_by(|a, b| a.1.total_cmp(&b.1))?;
    // The larger ones lie some samples apart.
    let mut step = (FACTOR - 1.0) / 2.0 * delay.abs();
    while step > interval / 2.0 {
        for tried in [delay - step, delay + step] {
            if let Some(its) = left(tried).filter(|its| *its < share) {
                (delay, share) = (tried, its);
            }
        }
        step /= 2.0;
    }
    (share < LEFT_MAX).then_some(delay)
}

/// Sum of squares of the second of each pair beside a line over the first.
fn rest(pairs: &[(f64, f64)]) -> f64 {
    let Moments { xx, xy, yy, .. } = Moments::of(pairs.iter().copied());
    if xx > 0.0 { yy - xy * xy / xx } else { yy }
}

/// The delay (negative: a lead), s, at which the moved rotation leaves least of the readings of `block`; `None` if no delay
/// takes away much.
pub(crate) fn delay_of(block: &Block, channels: &Channels) -> Option<f64> {
    let is_heading = match block.aggregate {
        Aggregate::Row => false,
        // Beside sparse headings there are few readings to compare; the delays that are tried anyway are near enough.
        Aggregate::Level if 2 * block.rows.len() > channels.time.len() => true,
        _ => return None,
    };
    let of = |range: &std::ops::Range<usize>| Stretch {
        times: &channels.time[range.clone()],
        truth: &channels.rotation[range.clone()],
        readings: Vec::new(),
    };
    let mut stretches: Vec<Stretch<'_>> = channels.segments.iter().map(of).collect();
    let mut stretch = 0;
    for (observation, &row) in block.rows.iter().enumerate() {
        while channels.segments.get(stretch)?.end <= row {
            stretch += 1;
        }
        let at = row - channels.segments[stretch].start;
        let reading = match is_heading {
            true => block.measured(observation),
            false => block.residual[observation] + channels.rotation[row],
        };
        stretches[stretch].readings.push((at, reading));
    }
    delay(&stretches, channels.interval())
}
