//! Readings clipped at the end of the sensor's range. They are found before any other cause: a clipped reading carries
//! no information about other causes, and the missing part mimics every curve.
//!
//! The measurement is a straight line over its reference between two limits, and flat beyond them. Only clear cases are
//! taken; a limit that few readings reach, or a gain that falls before the limit, is left to the search.

mod error;

use crate::model::{Acts, Driver, Form, Shape};
use crate::problem::{Aggregate, Block, Channels};
use crate::robust;
use crate::significance::surprise_chi2;
use std::ops::Range;

/// A limit of the range, in the unit of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Limit {
    /// Reference at which readings saturate.
    at: f64,
    /// Its standard error.
    error: f64,
    /// Surprise under noise alone, in nats.
    strength: f64,
}

/// Clipping of a block.
#[derive(Debug, Clone)]
pub struct Clipped {
    /// The term, with its limits.
    pub shape: Shape,
    /// Fraction of the excess beyond the limits that is missing: all of it, times the scale.
    pub gain: f64,
    /// Standard errors of the limits, by name.
    pub errors: Vec<(String, f64)>,
    /// Surprise under noise alone, in nats.
    pub strength: f64,
    /// The block before clipping was removed.
    pub before: Block,
}

/// Minimum number of readings at a limit; fewer are left to the search.
const READINGS_MIN: usize = 10;
/// Minimum number of readings in all.
const ALL_MIN: usize = 60;
/// Mean distance of the line beyond a limit, over the noise, that the readings at the limit must reach: a rounding step
/// is flat too, but ends at 1.7 times its own noise.
const OVERSHOOT_MIN: f64 = 3.0;
/// Maximum spread of readings at a limit, over the noise of the others.
const VARY_MAX: f64 = 1.5;
/// Maximum slope of the readings at a limit, with two standard errors, over that of the others.
const SLOPE_MAX: f64 = 0.1;
/// Maximum number of readings beyond a limit, over that of the readings at it: outliers.
const BEYOND_MAX: f64 = 0.05;
/// Surprise beyond doubt, in nats; no false alarm has come near it.
const STRENGTH_MIN: f64 = 20.0;
/// Distance from a limit, over the noise, beyond which a reading is unaffected by it.
const FEELS: f64 = 3.0;
/// Central shares of the reference range in which the line is first fitted.
const STARTS: [f64; 3] = [0.7, 0.4, 0.2];
/// Rounds that alternate between line and limits.
const ROUNDS: usize = 8;

/// Reference and reading, sorted by reference.
struct Sorted {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Place of each in time, and the run at each place.
    order: Vec<usize>,
    run: Vec<usize>,
}

/// Sums over a stretch of readings: count, means, and centred squares and products.
struct Sums {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// A line between limits.
#[derive(Debug, Clone)]
struct Line {
    slope: f64,
    offset: f64,
    /// Readings between the limits.
    inside: Range<usize>,
    square: f64,
}

/// Removes clipping from `block`, if it is beyond doubt: readings at a limit are corrected and get no weight.
pub fn clip(block: &mut Block, channels: &Channels) -> Option<Clipped> {
    let has_scale = block.constants.iter().any(|known| known.acts == Acts::Scale);
    if block.aggregate != Aggregate::Row || !has_scale || block.rows.len() < ALL_MIN {
        return None;
    }
    let per_row = &block.exposure(Acts::Scale)?.per_row;
    let truth: Vec<f64> = block.rows.iter().map(|&row| per_row[row]).collect();
    let mut order: Vec<usize> = (0..truth.len()).collect();
    order.sort_by(|a, b| truth[*a].total_cmp(&truth[*b]));
    let sorted = Sorted {
        x: order.iter().map(|&i| truth[i]).collect(),
        y: order.iter().map(|&i| truth[i] + block.residual[i]).collect(),
        run: block.rows.iter().map(|&row| channels.run[row]).collect(),
        order,
    };
    let (line, noise, [low, high]) = sorted.limits()?;
    let strength = low.iter().chain(&high).map(|limit| limit.strength).reduce(f64::max)?;
    let (least, most) = (*sorted.x.first()?, *sorted.x.last()?);
    // A limit that no reading reached lies as far away on the other side, or where the data end.
    let upper = high.map_or_else(|| low.map_or(most, |low| most.max(-low.at)), |high| high.at);
    let lower = low.map_or_else(|| least.min(-upper), |low| low.at);
    let mut shape =
        Shape::new("saturation", Acts::Saturation, Driver::rotation(channels), Form::Saturation)
            .with("limit", upper);
    if lower != -upper || high.is_none() {
        shape.set("lower_limit", lower);
    }
    let before = block.clone();
    let feels = FEELS * noise / line.slope;
    block.spread.resize(truth.len(), 1.0);
    for (i, x) in truth.iter().enumerate() {
        block.residual[i] -= line.slope * (x.clamp(lower, upper) - x);
        let is_near = high.is_some() && *x > upper - feels || low.is_some() && *x < lower + feels;
        if is_near {
            block.spread[i] = f64::INFINITY;
        }
    }
    let named = [("limit", high), ("lower_limit", low)];
    let errors =
        named.iter().filter_map(|(name, limit)| Some(((*name).to_owned(), (*limit)?.error)));
    Some(Clipped { shape, gain: line.slope, errors: errors.collect(), strength, before })
}

impl Sorted {
    /// The line, its noise, and the lower and the upper limit.
    fn limits(&self) -> Option<(Line, f64, [Option<Limit>; 2])> {
        let lines = STARTS.iter().filter_map(|share| self.line(*share));
        let line = lines.min_by(|a, b| a.square.total_cmp(&b.square))?;
        let noise = self.noise(&line)?;
        let limits = [true, false].map(|is_low| self.limit(&line, noise, is_low));
        Some((line, noise, limits))
    }

    /// The line between limits, first fitted in the middle `share` of the range.
    fn line(&self, share: f64) -> Option<Line> {
        let (least, most) = (*self.x.first()?, *self.x.last()?);
        let margin = 0.5 * (1.0 - share) * (most - least);
        let mut inside = self.x.partition_point(|x| *x < least + margin)
            ..self.x.partition_point(|x| *x <= most - margin);
        for _ in 0..ROUNDS {
            let (slope, offset) = self.fit(inside.clone())?;
            let from = self.best(slope, offset, true);
            let to = self.best(slope, offset, false);
            let found = from..to;
            if found == inside {
                break;
            }
            inside = found;
        }
        let (slope, offset) = self.fit(inside.clone())?;
        let between = inside.clone().map(|i| self.y[i] - slope * self.x[i] - offset);
        let ends = [0..inside.start, inside.end..self.x.len()].map(|range| self.sums(range).yy);
        let square = between.map(|left| left * left).sum::<f64>() + ends[0] + ends[1];
        (slope > 0.0).then_some(Line { slope, offset, inside, square })
    }

    /// Slope and offset of a line through the readings of `range`; `None` if there are too few, or if two flat ends
    /// meet and leave no readings between them.
    fn fit(&self, range: Range<usize>) -> Option<(f64, f64)> {
        if range.len() < ALL_MIN / 4 {
            return None;
        }
        let Sums { x, y, xx, xy, .. } = self.sums(range);
        (xx > 0.0).then(|| (xy / xx, y - xy / xx * x))
    }

    fn sums(&self, range: Range<usize>) -> Sums {
        let count = range.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (xs, ys) = (&self.x[range.clone()], &self.y[range]);
        let (x, y) = (mean(xs), mean(ys));
        Sums {
            count,
            x,
            y,
            xx: xs.iter().map(|one| (one - x).powi(2)).sum(),
            xy: xs.iter().zip(ys).map(|(one, other)| (one - x) * (other - y)).sum(),
            yy: ys.iter().map(|one| (one - y).powi(2)).sum(),
        }
    }

    /// Number of readings from one end that are best explained as constant: where the line begins or ends.
    fn best(&self, slope: f64, offset: f64, is_low: bool) -> usize {
        let n = self.x.len();
        let (mut count, mut sum, mut square, mut line) = (0.0, 0.0, 0.0, 0.0);
        let mut best = (0.0, 0);
        for taken in 1..=n / 2 + n / 4 {
            let i = if is_low { taken - 1 } else { n - taken };
            let left = self.y[i] - slope * self.x[i] - offset;
            // Subtracting the first reading keeps the sums small.
            let y = self.y[i] - self.y[if is_low { 0 } else { n - 1 }];
            (count, sum, square, line) = (count + 1.0, sum + y, square + y * y, line + left * left);
            let gain: f64 = line - (square - sum * sum / count);
            if gain > best.0 {
                best = (gain, taken);
            }
        }
        if is_low { best.1 } else { n - best.1 }
    }

    fn left(&self, line: &Line, i: usize) -> f64 {
        self.y[i] - line.slope * self.x[i] - line.offset
    }

    /// Noise between the limits.
    fn noise(&self, line: &Line) -> Option<f64> {
        let left: Vec<f64> = line.inside.clone().map(|i| self.left(line, i)).collect();
        let noise = robust::spread(&left);
        (noise > 0.0).then_some(noise)
    }

    /// The limit at one end, if readings reach it.
    fn limit(&self, line: &Line, noise: f64, is_low: bool) -> Option<Limit> {
        let range = if is_low { 0..line.inside.start } else { line.inside.end..self.x.len() };
        if range.len() < READINGS_MIN {
            return None;
        }
        let Sums { count: n, x: mx, y: my, xx, xy, yy } = self.sums(range.clone());
        let beyond = (line.slope * mx + line.offset - my) * if is_low { -1.0 } else { 1.0 };
        let slope = (xy / xx).abs() + 2.0 * noise / xx.sqrt();
        let gain = range.clone().map(|i| self.left(line, i).powi(2)).sum::<f64>() - yy;
        let strength = surprise_chi2(gain / (noise * noise), 2.0) - (self.x.len() as f64).ln();
        let is_clear = beyond > OVERSHOOT_MIN * noise
            && yy <= n * (VARY_MAX * noise).powi(2)
            && slope < SLOPE_MAX * line.slope
            && strength > STRENGTH_MIN;
        if !is_clear {
            return None;
        }
        // No reading lies beyond a limit by more than the noise: where some do, others stay behind a reference that is wrong.
        let is_beyond =
            |y: &f64| (y - my) * if is_low { -1.0 } else { 1.0 } > robust::GROSS * noise;
        let beyond = self.y.iter().filter(|y| is_beyond(y)).count();
        if beyond as f64 > BEYOND_MAX * n {
            return None;
        }
        let at = (my - line.offset) / line.slope;
        // Of readings that do not vary a limit is known to the part of one.
        let error = self.error(line, (range, my), at).max(noise / n) / line.slope;
        Some(Limit { at, error, strength })
    }

    /// Standard error of the level of the readings in `flat`, whose mean is `level`, less what the line says `at` the limit.
    fn error(&self, line: &Line, (flat, level): (Range<usize>, f64), at: f64) -> f64 {
        let count = flat.len() as f64;
        let inside = self.sums(line.inside.clone());
        let (mut weights, mut errors) = (vec![0.0; self.x.len()], vec![0.0; self.x.len()]);
        for i in line.inside.clone() {
            let lever = (at - inside.x) * (self.x[i] - inside.x) / inside.xx;
            weights[self.order[i]] = -(1.0 / inside.count + lever);
            errors[self.order[i]] = self.left(line, i);
        }
        for i in flat {
            weights[self.order[i]] = 1.0 / count;
            errors[self.order[i]] = self.y[i] - level;
        }
        error::of_sum(&weights, &errors, &self.run)
    }
}

#[cfg(test)]
mod tests {
    use super::Sorted;

    /// The limits of what is measured of a reference from -10 to 10, with a noise of 0.05.
    fn limits(measured: impl Fn(f64) -> f64) -> Option<[Option<f64>; 2]> {
        let x: Vec<f64> = (0..2000).map(|i| -10.0 + 0.01 * f64::from(i)).collect();
        let noise = |i: usize| 0.0866 * ((i as f64 * 0.754_877).fract() * 2.0 - 1.0);
        let y = x.iter().enumerate().map(|(i, x)| measured(*x) + noise(i)).collect();
        let (order, run) = ((0..x.len()).collect(), vec![0; x.len()]);
        let (.., limits) = Sorted { x, y, order, run }.limits()?;
        Some(limits.map(|limit| limit.map(|limit| limit.at)))
    }

    #[test]
    fn only_a_flat_end_is_a_limit() {
        let [low, high] = limits(|x| 1.01 * x.clamp(-9.0, 4.0)).expect("a line");
        assert!((low.expect("reached") + 9.0).abs() < 0.02);
        assert!((high.expect("reached") - 4.0).abs() < 0.02);
        let none = Some([None, None]);
        assert_eq!(limits(|x| x), none);
        assert_eq!(limits(|x| x - 0.001 * x * x * x), none, "a cubic");
        assert_eq!(limits(|x| if x.abs() < 1.0 { 0.0 } else { x }), none, "a dead zone");
        assert_eq!(limits(|x| 12.0 * (x / 12.0).tanh()), none, "a gain that falls");
        assert_eq!(limits(|x| x.round()), none, "steps");
        assert_eq!(limits(|x| if x.abs() < 3.0 { x } else { 0.0 }), None, "ends that meet");
        let glitch = |x: f64| if x > 9.0 { 4.0 } else { x };
        assert_eq!(limits(glitch), none, "a reference that is wrong where it is large");
    }
}
