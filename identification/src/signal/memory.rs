//! Effects with a memory: a first-order lag, exact for an input that is bent between samples as [`super::interpolate_along`]
//! says, and the play operator, the elementary hysteresis (backlash) of Prandtl and Ishlinskii.

use super::Bends;

/// `values`, bent so, through a first-order lag, in equilibrium at the first sample. Times are increasing.
pub fn first_order(
    times: &[f64],
    values: &[f64],
    bends: &[Bends],
    time_constant_s: f64,
) -> Vec<f64> {
    let mut lagged = Vec::with_capacity(values.len());
    let Some(&first) = values.first() else {
        return lagged;
    };
    let mut state = first;
    lagged.push(state);
    for i in 1..values.len() {
        let dt = times[i] - times[i - 1];
        let ratio = dt / time_constant_s;
        let decay = (-ratio).exp();
        // The mean weight of the new end of a ramp: 1 - (1 - e^-r) / r.
        let new = if ratio > 1e-8 { 1.0 - (1.0 - decay) / ratio } else { ratio / 2.0 };
        let old = 1.0 - decay - new;
        state = decay * state + old * values[i - 1] + new * values[i];
        state -= time_constant_s.powi(2) * bends[i].mean() / 2.0 * bulge(ratio, decay);
        lagged.push(state);
    }
    lagged
}

/// Response to the parabola between two samples, u (r - u), at its end: the integral of its product with e^-u up to r.
fn bulge(ratio: f64, decay: f64) -> f64 {
    if ratio < 0.01 {
        return ratio.powi(3) / 6.0 * (1.0 - ratio / 2.0);
    }
    let (first, second) = (1.0 + ratio, 2.0 + 2.0 * ratio + ratio * ratio);
    ratio * (1.0 - first * decay) - (2.0 - second * decay)
}

/// `values` with play of `half_width` to each side, from the middle of the play at the first sample.
pub fn play(values: &[f64], half_width: f64) -> Vec<f64> {
    play_from(values.first().copied().unwrap_or(0.0), values, half_width)
}

/// Share of the play within which `values` leave it open where it is, if it was anywhere at the first sample.
pub fn undecided(values: &[f64], half_width: f64) -> Vec<f64> {
    let first = values.first().copied().unwrap_or(0.0);
    let [low, high] =
        [-half_width, half_width].map(|off| play_from(first + off, values, half_width));
    high.iter().zip(low).map(|(high, low)| (high - low) / (2.0 * half_width)).collect()
}

fn play_from(mut position: f64, values: &[f64], half_width: f64) -> Vec<f64> {
    values
        .iter()
        .map(|&value| {
            position = position.clamp(value - half_width, value + half_width);
            position
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{play, undecided};
    use crate::signal::bends;

    fn first_order(times: &[f64], values: &[f64], constant: f64) -> Vec<f64> {
        super::first_order(times, values, &bends(times, values), constant)
    }

    /// Of a sine the answer is known: smaller by the cosine of the angle that it is late by.
    #[test]
    fn a_sine_comes_out_smaller_and_late() {
        for (rate, constant) in [(0.4_f64, 0.4_f64), (0.3, 5.0), (0.05, 0.005)] {
            let times: Vec<f64> = (0..3000).map(f64::from).collect();
            let sine: Vec<f64> = times.iter().map(|t| (rate * t).sin()).collect();
            let lagged = first_order(&times, &sine, constant);
            let angle = (rate * constant).atan();
            let off = (1000..2900)
                .map(|i| (lagged[i] - angle.cos() * (rate * times[i] - angle).sin()).abs())
                .fold(0.0, f64::max);
            // A straight line between samples would be off by a twelfth of the square of the angle between them.
            assert!(off < 0.03 * rate * rate / 12.0, "{rate} {constant}: {off}");
        }
    }

    #[test]
    fn a_ramp_is_followed_at_a_distance_of_the_time_constant() {
        let times: Vec<f64> = (0..2000).map(f64::from).collect();
        let ramp: Vec<f64> = times.iter().map(|t| 0.5 * t).collect();
        let lagged = first_order(&times, &ramp, 40.0);
        assert!((ramp[1999] - lagged[1999] - 0.5 * 40.0).abs() < 1e-9);
        // The exact response: x - m tau (1 - e^(-t/tau)).
        let expected = ramp[30] - 20.0 * (1.0 - (-30.0_f64 / 40.0).exp());
        assert!((lagged[30] - expected).abs() < 1e-9);
    }

    #[test]
    fn a_play_is_where_its_driver_has_put_it_once_all_of_it_was_gone_through() {
        assert_eq!(undecided(&[5.0, 6.0, 5.5, 4.5, 9.0], 1.0), [1.0, 0.5, 0.5, 0.25, 0.0]);
    }

    #[test]
    fn a_reversal_takes_up_the_play_first() {
        let found = play(&[0.0, 1.0, 3.0, 2.0, 0.0], 1.0);
        assert_eq!(found, [0.0, 0.0, 2.0, 2.0, 1.0]);
    }
}
