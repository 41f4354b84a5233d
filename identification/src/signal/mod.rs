//! What effects derive from a channel: its slope, its lag, its branch of a hysteresis.

mod lag;
mod play;
mod smooth;

pub use lag::first_order;
pub use play::play;
pub use smooth::{Smooth, smooth};

/// Sum of `values` up to each of them.
pub fn running_total(values: &[f64]) -> Vec<f64> {
    let add = |sum: &mut f64, value: &f64| {
        *sum += value;
        Some(*sum)
    };
    values.iter().scan(0.0, add).collect()
}

/// Linear interpolation of `(times, values)` at `at`; the ends are held. `times` are increasing.
pub fn interpolate(times: &[f64], values: &[f64], at: f64) -> f64 {
    between(times, values, at, times.partition_point(|&time| time <= at))
}

/// Values at each of `at`, which lie near one another in sequence. Between two values the course is bent as far as the
/// values on both sides agree (the harmonic mean of their curvatures, after van Leer 1974): smooth motion is followed to the
/// third order, and the corner of a ramp stays one. The ends are held.
pub fn interpolate_along(
    times: &[f64],
    values: &[f64],
    at: impl Iterator<Item = f64>,
) -> impl Iterator<Item = f64> {
    let mut above = 0;
    at.map(move |at| {
        while above < times.len() && times[above] <= at {
            above += 1;
        }
        while above > 0 && times[above - 1] > at {
            above -= 1;
        }
        let straight = between(times, values, at, above);
        if above < 2 || above + 1 >= times.len() {
            return straight;
        }
        let bend = |middle: usize| curvature(times, values, middle);
        let (before, after) = (bend(above - 1), bend(above));
        let both = before * after;
        let bent = if both > 0.0 { 2.0 * both / (before + after) } else { 0.0 };
        straight - bent / 2.0 * (at - times[above - 1]) * (times[above] - at)
    })
}

/// Second derivative at `middle`, by the values beside it.
fn curvature(times: &[f64], values: &[f64], middle: usize) -> f64 {
    let slope = |i: usize| (values[i] - values[i - 1]) / (times[i] - times[i - 1]);
    2.0 * (slope(middle + 1) - slope(middle)) / (times[middle + 1] - times[middle - 1])
}

/// Interpolation with `above` times at or before `at`.
fn between(times: &[f64], values: &[f64], at: f64, above: usize) -> f64 {
    match above {
        0 => values.first().copied().unwrap_or(f64::NAN),
        n if n == times.len() => values.last().copied().unwrap_or(f64::NAN),
        n => {
            let (t0, t1) = (times[n - 1], times[n]);
            values[n - 1] + (values[n] - values[n - 1]) * (at - t0) / (t1 - t0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{interpolate, interpolate_along};

    #[test]
    fn between_samples_a_curve_is_bent_and_a_corner_is_not() {
        let times = [0.0, 1.0, 1.5, 4.0, 9.0, 10.0];
        let at: Vec<f64> = (0..220).map(|i| 5.0 + 6.0 * (f64::from(i) * 0.1).sin()).collect();
        let square = |t: f64| 2.0 - t + 0.3 * t * t;
        let corner = |t: f64| 0.5 * (t - 4.0).max(0.0);
        for (of, from, to) in [(&square as &dyn Fn(f64) -> f64, 1.0, 9.0), (&corner, 0.0, 10.0)] {
            let values = times.map(of);
            let along = interpolate_along(&times, &values, at.iter().copied());
            for (at, found) in at.iter().zip(along) {
                let inside = (from..to).contains(at);
                let expected = if inside { of(*at) } else { interpolate(&times, &values, *at) };
                assert!((found - expected).abs() < 1e-9, "{at}: {found} {expected}");
            }
        }
    }
}
