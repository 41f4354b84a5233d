//! A signal evened out from both sides alike.

use crate::linear::coefficients;

/// How often what a mean leaves is evened out again: the motion passes up to the sixth order of its curvature, as through
/// a smoothing spline of that order. It was the best of 1 to 4 on readings with known noise.
const TIMES: usize = 3;

/// Beyond each end the signal goes on as its mirror image for this many widths, turned about a line through as many.
const BEYOND: f64 = 6.0;

/// `values` without their noise: what three means leave of one another is taken away.
pub fn evened(times: &[f64], values: &[f64], width_s: f64) -> Vec<f64> {
    let count = values.len().min(times.len());
    if count < 4 || !(width_s > 0.0) {
        return values[..count].to_vec();
    }
    let front = mirrored(times, values, width_s);
    let turned = |of: &[f64], sign: f64| -> Vec<f64> {
        of[..count].iter().rev().map(|value| sign * value).collect()
    };
    let back = mirrored(&turned(times, -1.0), &turned(values, 1.0), width_s);
    let before = front.len();
    let (mut all_times, mut all): (Vec<f64>, Vec<f64>) = front.into_iter().rev().unzip();
    all_times.extend(&times[..count]);
    all.extend(&values[..count]);
    for (time, value) in back {
        all_times.push(-time);
        all.push(value);
    }
    let keep: Vec<f64> =
        all_times.windows(2).map(|two| (-(two[1] - two[0]).max(0.0) / width_s).exp()).collect();
    let mut left = all;
    for _ in 0..TIMES {
        let mean = mean(&left, &keep);
        left.iter_mut().zip(mean).for_each(|(left, mean)| *left -= mean);
    }
    values[..count].iter().zip(&left[before..]).map(|(value, left)| value - left).collect()
}

/// The signal before its first value, the nearest first: what follows, turned by half about the line through it at the
/// first value's time.
fn mirrored(times: &[f64], values: &[f64], width_s: f64) -> Vec<(f64, f64)> {
    let near = times.iter().take_while(|time| **time - times[0] <= BEYOND * width_s).count();
    let near = near.clamp(2, times.len());
    let since: Vec<f64> = times[..near].iter().map(|time| time - times[0]).collect();
    let line = coefficients(&[vec![1.0; near], since.clone()], &values[..near]);
    let middle = line.first().copied().filter(|value| value.is_finite()).unwrap_or(values[0]);
    let turned = |i: usize| (times[0] - since[i], 2.0 * middle - values[i]);
    (1..near).map(turned).collect()
}

/// The mean of `values` around each, with weights of which `keep` stays from each to the next: they fall by e in a width
/// both ways, for a random walk in white noise the estimate of least variance (Wiener). Each side has the same say, so that
/// a slope cancels.
fn mean(values: &[f64], keep: &[f64]) -> Vec<f64> {
    let count = values.len();
    // Of the values before, the one itself left out: the sum of weights, and of weighted values.
    let mut before = vec![(0.0, 0.0); count];
    for i in 1..count {
        let (weight, sum) = before[i - 1];
        before[i] = (keep[i - 1] * (weight + 1.0), keep[i - 1] * (sum + values[i - 1]));
    }
    let mut found = values.to_vec();
    let (mut weight, mut sum) = (0.0, 0.0);
    for i in (0..count).rev() {
        if i + 1 < count {
            (weight, sum) = (keep[i] * (weight + 1.0), keep[i] * (sum + values[i + 1]));
        }
        let (other, of_other) = before[i];
        if weight > 0.0 && other > 0.0 {
            let half = 0.5 * (weight + other);
            found[i] = (values[i] + half * (sum / weight + of_other / other)) / (1.0 + 2.0 * half);
        }
    }
    found
}
