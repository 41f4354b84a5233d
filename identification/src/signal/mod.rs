//! What effects derive from a channel: its slope, its lag, its branch of a hysteresis.

mod lag;
mod play;
mod smooth;

pub use lag::first_order;
pub use play::play;
pub use smooth::{Smooth, smooth};

/// Linear interpolation of `(times, values)` at `at`; the ends are held. `times` are increasing.
pub fn interpolate(times: &[f64], values: &[f64], at: f64) -> f64 {
    between(times, values, at, times.partition_point(|&time| time <= at))
}

/// The same for each of `at`, which lie near one another in sequence.
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
        between(times, values, at, above)
    })
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
    fn along_a_path_each_place_is_found_that_is_found_alone() {
        let times = [0.0, 1.0, 1.5, 4.0, 9.0];
        let values = [2.0, -1.0, 3.0, 3.5, 0.0];
        let at: Vec<f64> = (0..200).map(|i| 5.0 + 6.0 * (f64::from(i) * 0.1).sin()).collect();
        let along: Vec<f64> = interpolate_along(&times, &values, at.iter().copied()).collect();
        let alone: Vec<f64> = at.iter().map(|&at| interpolate(&times, &values, at)).collect();
        assert_eq!(along, alone);
    }
}
