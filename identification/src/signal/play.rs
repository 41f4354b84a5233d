//! The play operator: the elementary hysteresis (backlash) of Prandtl and Ishlinskii.

/// `values` with play of `half_width` to each side, from the middle of the play at the first sample.
pub fn play(values: &[f64], half_width: f64) -> Vec<f64> {
    let mut position = values.first().copied().unwrap_or(0.0);
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
    use super::play;

    #[test]
    fn a_reversal_takes_up_the_play_first() {
        let found = play(&[0.0, 1.0, 3.0, 2.0, 0.0], 1.0);
        assert_eq!(found, [0.0, 0.0, 2.0, 2.0, 1.0]);
    }
}
