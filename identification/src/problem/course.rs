//! The course of a rotation of which a gyro and headings are read.

use super::channels::Channels;
use super::rate::steps;
use crate::late::{self, SHARE_MAX};
use crate::signal::{Beside, interpolate, running_total};
use std::ops::Range;

/// Standard errors from which a delay or a scale error at first sight is one.
const SURE: f64 = 4.0;
/// Steps to the likeliest delay, and the share of a row that the last of them is at most.
const STEPS_MAX: usize = 12;
const NEAR: f64 = 0.01;

/// The rate of the rotation in each row, and how late the gyro is, s: what the gyro says, less its noise, its delay and its scale
/// error, and less its drift, which is the slope of a smooth course through its errors at the headings. It holds the noise of
/// neither.
pub(super) fn course(
    channels: &Channels,
    (rows, residual): (&[usize], &[f64]),
    (read, is_mean): (&[f64], bool),
    nominal: &[f64],
) -> (Vec<f64>, f64) {
    let mut read = channels.smooth(read).level;
    read.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
    let measured = running_total(nominal);
    let mut headings = vec![f64::NAN; read.len()];
    for (&row, residual) in rows.iter().zip(residual) {
        headings[row] = measured[row] - residual;
    }
    let rough = channels.smooth(&headings).slope;
    let lag = Lag { channels, headings: &headings, read: &read, rough: &rough, is_mean };
    let (delay, excess) = lag.likeliest();
    let read: Vec<f64> = lag.moved(delay).iter().map(|read| read * (1.0 - excess)).collect();
    let own = lag.turned(&read);
    let error: Vec<f64> = own.iter().zip(&headings).map(|(own, heading)| own - heading).collect();
    let drift = channels.smooth(&error).slope;
    (read.iter().zip(drift).map(|(read, drift)| read - drift).collect(), delay)
}

/// Turn in each row of a gyro that reads these rates.
pub(super) fn turns(channels: &Channels, read: &[f64], is_mean: bool, steps: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; read.len()];
    for range in &channels.segments {
        for row in range.start + 1..range.end {
            let now = if read[row].is_finite() { read[row] } else { 0.0 };
            let before = if read[row - 1].is_finite() { read[row - 1] } else { now };
            found[row] = if is_mean { now } else { (now + before) / 2.0 } * steps[row];
        }
    }
    found
}

/// Rows before which, by `delay` s, their stretch has begun and not ended.
pub(super) fn within(channels: &Channels, delay: f64) -> Vec<bool> {
    let of = |range: &Range<usize>| {
        let times = &channels.time[range.clone()];
        let ends = [times[0], times[times.len() - 1]];
        times.iter().map(move |time| time - delay >= ends[0] && time - delay <= ends[1])
    };
    channels.segments.iter().flat_map(of).collect()
}

/// A gyro and headings, of which one is late.
struct Lag<'a> {
    channels: &'a Channels,
    /// NaN in rows without a heading.
    headings: &'a [f64],
    read: &'a [f64],
    /// The rate by the headings alone.
    rough: &'a [f64],
    is_mean: bool,
}

impl Lag<'_> {
    /// What is read at each row, `delay` s later; beyond the ends of a stretch the rough rate.
    fn moved(&self, delay: f64) -> Vec<f64> {
        let within = within(self.channels, -delay);
        let mut found = self.rough.to_vec();
        for range in &self.channels.segments {
            let (times, read) = (&self.channels.time[range.clone()], &self.read[range.clone()]);
            for row in range.clone().filter(|&row| within[row]) {
                found[row] = interpolate(times, read, self.channels.time[row] + delay);
            }
        }
        found
    }

    fn turned(&self, read: &[f64]) -> Vec<f64> {
        running_total(&turns(self.channels, read, self.is_mean, &steps(self.channels)))
    }

    /// The delay, and the share of its turns that the gyro reads in excess, beside which what is left between gyro and headings is likeliest to be a smooth course and
    /// white noise. A drift of the gyro is in that course, however large it is.
    fn likeliest(&self) -> (f64, f64) {
        let stretch = |range: &Range<usize>| late::Stretch {
            times: &self.channels.time[range.clone()],
            truth: &self.rough[range.clone()],
            readings: self.read[range.clone()].iter().copied().enumerate().collect(),
        };
        let interval = self.channels.interval();
        let stretches: Vec<late::Stretch<'_>> =
            self.channels.segments.iter().map(stretch).collect();
        let mut delay = late::delay(&stretches, interval).unwrap_or(0.0);
        for _ in 0..STEPS_MAX {
            let Some([excess, more]) = self.beside(delay) else { return (0.0, 0.0) };
            let sure =
                |(value, error): (f64, f64)| if value.abs() > SURE * error { value } else { 0.0 };
            if more.0.abs() < NEAR * interval {
                return (sure((delay + more.0, more.1)), sure(excess));
            }
            delay += more.0;
            if delay.abs() > SHARE_MAX * self.channels.span() {
                break;
            }
        }
        (0.0, 0.0)
    }

    /// The excess, and what is missing of the `delay`, each with its standard error.
    fn beside(&self, delay: f64) -> Option<[(f64, f64); 2]> {
        let read = self.moved(delay);
        let own = self.turned(&read);
        let error: Vec<f64> =
            own.iter().zip(self.headings).map(|(own, heading)| own - heading).collect();
        let values = [&own, &read, &error];
        let add = |ratio: f64, rows_max: usize| {
            let mut found = Beside::default();
            for range in &self.channels.segments {
                let count = range.len().min(rows_max);
                let start = range.start + (range.len() - count) / 2;
                let range = start..start + count;
                let values = values.map(|values| &values[range.clone()]);
                found.add(&self.channels.time[range.clone()], values, ratio);
            }
            found
        };
        let ratios = Beside::ratios(self.channels.interval());
        let tried = ratios.map(|ratio| {
            let found = add(ratio, CHOICE_ROWS);
            (
                found.log_likelihood(fit(&found.products).map_or(f64::INFINITY, |fit| fit.left)),
                ratio,
            )
        });
        let (_, ratio) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let found = add(ratio, usize::MAX);
        let Fit { excess, late, left, inverse } = fit(&found.products)?;
        let error = |diagonal: f64| (found.variance(left) * diagonal).sqrt();
        Some([(excess, error(inverse[0])), (-late, error(inverse[1]))])
    }
}

/// Rows of a stretch from which its smoothness is chosen.
const CHOICE_ROWS: usize = 4000;

/// The error as a share of the angle, and of the rate.
struct Fit {
    excess: f64,
    late: f64,
    /// Sum of squares that is left.
    left: f64,
    /// Diagonal of the inverse of the normal equations.
    inverse: [f64; 2],
}

/// `None` where the angle and the rate say one thing, or nothing.
fn fit([[aa, ab, at], [_, bb, bt], [_, _, tt]]: &[[f64; 3]; 3]) -> Option<Fit> {
    let determinant = aa * bb - ab * ab;
    if !(determinant > INDEPENDENT * aa * bb) {
        return None;
    }
    let (excess, late) = ((bb * at - ab * bt) / determinant, (aa * bt - ab * at) / determinant);
    let left = tt - excess * at - late * bt;
    Some(Fit { excess, late, left, inverse: [bb / determinant, aa / determinant] })
}

/// Share of two squares that their determinant is at least.
const INDEPENDENT: f64 = 1e-6;
