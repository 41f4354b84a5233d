//! What effects make of a channel: its slope, its lagged self, its branch of a hysteresis.

mod lag;
mod play;
mod smooth;

pub use lag::first_order;
pub use play::play;
pub use smooth::{Smooth, smooth};

/// Linear interpolation of `(times, values)` at `at`; the ends are held. `times` rise.
pub fn interpolate(times: &[f64], values: &[f64], at: f64) -> f64 {
    let above = times.partition_point(|&time| time <= at);
    match above {
        0 => values.first().copied().unwrap_or(f64::NAN),
        n if n == times.len() => values.last().copied().unwrap_or(f64::NAN),
        n => {
            let (t0, t1) = (times[n - 1], times[n]);
            values[n - 1] + (values[n] - values[n - 1]) * (at - t0) / (t1 - t0)
        }
    }
}
