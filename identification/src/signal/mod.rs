//! What effects derive from a channel: its slope, its lag, its branch of a hysteresis.

mod memory;
mod smooth;

pub use memory::{first_order, play, undecided};
pub use smooth::{Beside, Smooth, smooth};

/// Sum of `values` up to each of them.
pub fn running_total(values: &[f64]) -> Vec<f64> {
    let add = |sum: &mut f64, value: &f64| {
        *sum += value;
        Some(*sum)
    };
    values.iter().scan(0.0, add).collect()
}

/// Means of each of `values` and the one before (trapezoidal rule): what adds up does so over the time in between.
pub fn since_before(values: &mut [f64]) {
    for at in (1..values.len()).rev() {
        values[at] = f64::midpoint(values[at - 1], values[at]);
    }
}

/// Linear interpolation of `(times, values)` at `at`; the ends are held. `times` are increasing.
pub fn interpolate(times: &[f64], values: &[f64], at: f64) -> f64 {
    between(times, values, at, times.partition_point(|&time| time <= at))
}

/// The same at a place whose number of earlier times is near `above`, which is then set to it.
pub fn interpolate_near(times: &[f64], values: &[f64], at: f64, above: &mut usize) -> f64 {
    *above = (*above).min(times.len());
    while *above < times.len() && times[*above] <= at {
        *above += 1;
    }
    while *above > 0 && times[*above - 1] > at {
        *above -= 1;
    }
    between(times, values, at, *above)
}

/// Values at each of `at`, which lie near one another in sequence, of a course with these `bends`. Where the curvature changes
/// evenly over six values, the course is that of all six: smooth motion is followed to the sixth order, through its turning
/// points as well. Elsewhere it is bent as far as the values on both sides agree (the harmonic mean of their curvatures, after van Leer 1974), and the corner
/// of a ramp stays one. The ends are held.
pub fn interpolate_along(
    times: &[f64],
    values: &[f64],
    bends: &[Bends],
    at: impl Iterator<Item = f64>,
) -> impl Iterator<Item = f64> {
    let mut above = 0;
    at.map(move |at| {
        let straight = interpolate_near(times, values, at, &mut above);
        if above == 0 || above == times.len() {
            return straight;
        }
        let (since, until) = (at - times[above - 1], times[above] - at);
        let Bends { before, after, fourth } = bends[above];
        let (step, both) = (since + until, since * until);
        let first = (before * (since + 2.0 * until) + after * (2.0 * since + until)) / 6.0;
        straight - first / step * both + fourth / 24.0 * both * (1.0 + both / (step * step))
    })
}

/// How the course is bent between two values.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bends {
    /// Second derivative at its start and at its end.
    before: f64,
    after: f64,
    /// Fourth derivative times the square of the step.
    fourth: f64,
}

impl Bends {
    /// Second derivative of the parabola that lies as far from the straight line on the mean.
    pub fn mean(&self) -> f64 {
        // The mean of 1 + s (h - s) / h^2 over s (h - s) is 6/5.
        (self.before + self.after) / 2.0 - 1.2 * self.fourth / 12.0
    }
}

/// How `values` are bent in the interval that ends at each of them; those at the ends are straight.
pub fn bends(times: &[f64], values: &[f64]) -> Vec<Bends> {
    let bent = curvatures(times, values);
    let inside = 2..values.len().saturating_sub(1);
    let of = |above| if inside.contains(&above) { bend(&bent, above) } else { Bends::default() };
    (0..values.len()).map(of).collect()
}

/// How values with these `curvatures` are bent in the interval that ends at `above`, which is not one at an end.
fn bend(curvatures: &[f64], above: usize) -> Bends {
    let (before, after) = (curvatures[above - 1], curvatures[above]);
    if above > 2 && above + 2 < curvatures.len() {
        let four = [curvatures[above - 2], before, after, curvatures[above + 1]];
        let steps = [four[1] - four[0], four[2] - four[1], four[3] - four[2]];
        if are_even(&steps) || are_even(&four) {
            // What differences of neighbours show is the mean over them, and more than the value in the middle.
            let (of_before, of_after) = (steps[1] - steps[0], steps[2] - steps[1]);
            return Bends {
                before: before - of_before / 12.0,
                after: after - of_after / 12.0,
                fourth: (of_before + of_after) / 2.0,
            };
        }
    }
    let both = before * after;
    let bent = if both > 0.0 { 2.0 * both / (before + after) } else { 0.0 };
    Bends { before: bent, after: bent, fourth: 0.0 }
}

/// Whether they have one sign and are within a factor of one another.
fn are_even(values: &[f64]) -> bool {
    let same = values.iter().all(|one| *one > 0.0) || values.iter().all(|one| *one < 0.0);
    let sizes = || values.iter().map(|one| one.abs());
    same && sizes().fold(0.0, f64::max) <= EVENLY * sizes().fold(f64::INFINITY, f64::min)
}

/// Curvatures, or the steps between them, within this factor are even: of a sine with 13 samples a turn, one or the other is
/// everywhere.
const EVENLY: f64 = 6.0;

/// Second derivative at each value, by those beside it; zero at the ends.
fn curvatures(times: &[f64], values: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; values.len()];
    let slope = |i: usize| (values[i] - values[i - 1]) / (times[i] - times[i - 1]);
    let mut before = if values.len() > 1 { slope(1) } else { 0.0 };
    for middle in 1..values.len().max(1) - 1 {
        let after = slope(middle + 1);
        found[middle] = 2.0 * (after - before) / (times[middle + 1] - times[middle - 1]);
        before = after;
    }
    found
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
    use super::{bends, interpolate, interpolate_along};

    /// Thirteen samples a turn.
    #[test]
    fn a_sine_is_followed_through_its_turning_points() {
        let times: Vec<f64> = (0..60).map(f64::from).collect();
        let sine = |t: f64| (0.48 * t + 0.2).sin();
        let values: Vec<f64> = times.iter().map(|t| sine(*t)).collect();
        let at: Vec<f64> = (60..540).map(|i| f64::from(i) * 0.1).collect();
        let off = interpolate_along(&times, &values, &bends(&times, &values), at.iter().copied())
            .zip(&at)
            .fold(0.0_f64, |most, (found, at)| most.max((found - sine(*at)).abs()));
        assert!(off < 3e-4, "{off}");
    }

    #[test]
    fn between_samples_a_curve_is_bent_and_a_corner_is_not() {
        let times = [0.0, 1.0, 1.5, 4.0, 9.0, 10.0];
        let at: Vec<f64> = (0..220).map(|i| 5.0 + 6.0 * (f64::from(i) * 0.1).sin()).collect();
        let square = |t: f64| 2.0 - t + 0.3 * t * t;
        let corner = |t: f64| 0.5 * (t - 4.0).max(0.0);
        for (of, from, to) in [(&square as &dyn Fn(f64) -> f64, 1.0, 9.0), (&corner, 0.0, 10.0)] {
            let values = times.map(of);
            let bends = bends(&times, &values);
            let along = interpolate_along(&times, &values, &bends, at.iter().copied());
            for (at, found) in at.iter().zip(along) {
                let inside = (from..to).contains(at);
                let expected = if inside { of(*at) } else { interpolate(&times, &values, *at) };
                assert!((found - expected).abs() < 1e-9, "{at}: {found} {expected}");
            }
        }
    }
}
