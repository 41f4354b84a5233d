//! Unknown periods, by the fast Fourier transform of the residual.

use super::scene::Scene;
use crate::candidates::{Candidate, periodic};
use crate::model::{Acts, exposure};
use crate::problem::Aggregate;
use crate::robust;
use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

/// Maximum number of samples of the transform.
const SAMPLES_MAX: usize = 1 << 21;
/// Minimum number of cycles of a period in the record.
const CYCLES_MIN: f64 = 3.0;
/// Independent tests per frequency of the transform, since periods between frequencies are searched too.
const TESTS_PER_FREQUENCY: f64 = 2.5;
/// Number of peaks examined for each kind of term.
const PEAKS: usize = 2;

/// The likeliest periods, and the number of independent tests.
pub fn periods(scene: &Scene<'_>) -> (Vec<Candidate>, f64) {
    let (block, channels) = (scene.data.block, scene.data.channels);
    let interval = scene.data.layout.interval();
    let (first, last) = robust::ends(channels.time.iter().copied());
    let bins = ((last - first) / interval).ceil() as usize + 1;
    let transformable = (32..=SAMPLES_MAX).contains(&bins);
    if block.aggregate != Aggregate::Row || !transformable || block.rows.len() < 64 {
        return (Vec::new(), 1.0);
    }
    let length = (2 * bins).next_power_of_two();
    // Without the planner, whose every algorithm would be compiled for this one length.
    let transform = Radix4::new(length, FftDirection::Forward);
    let lowest = (CYCLES_MIN * length as f64 / bins as f64).ceil() as usize;
    let highest = length / 2;
    let mut found = Vec::new();
    let mut kinds = 0.0;
    for on in [Acts::Bias, Acts::Scale, Acts::Turn, Acts::Curvature, Acts::Drive] {
        let Some(exposed) = exposure(block, on) else { continue };
        kinds += 1.0;
        let mut spectrum = vec![Complex::new(0.0, 0.0); length];
        for (score, &row) in scene.scores.iter().zip(&block.rows) {
            let bin = ((channels.time[row] - first) / interval).round() as usize;
            if bin < length {
                spectrum[bin].re += score * exposed.per_row[row];
            }
        }
        if highest <= lowest {
            continue;
        }
        transform.process(&mut spectrum);
        let power: Vec<f64> = spectrum[..=highest].iter().map(|value| value.norm_sqr()).collect();
        let mut order: Vec<usize> = (lowest..highest)
            .filter(|&bin| power[bin] >= power[bin - 1] && power[bin] >= power[bin + 1])
            .collect();
        order.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
        for bin in order.into_iter().take(PEAKS) {
            let period = length as f64 * interval / bin as f64;
            found.push(periodic(on, channels, period));
        }
    }
    (found, TESTS_PER_FREQUENCY * kinds * bins as f64 / 2.0)
}
