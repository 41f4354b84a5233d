//! A first-order lag, exact for an input that is linear between samples.

/// `values` through a first-order lag, in equilibrium at the first sample. Times are increasing.
pub fn first_order(times: &[f64], values: &[f64], time_constant_s: f64) -> Vec<f64> {
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
        lagged.push(state);
    }
    lagged
}

#[cfg(test)]
mod tests {
    use super::first_order;

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
}
