//! Unknown periods, by the fast Fourier transform of the residual.

use super::refine::refine;
use super::scene::Scene;
use crate::candidates::{Candidate, periodic};
use crate::model::{Acts, Shape, exposure};
use crate::problem::Aggregate;
use crate::robust;
use crate::significance::surprise_chi2;
use rustfft::Fft;
use rustfft::num_complex::Complex;

/// Maximum number of samples of the transform.
const SAMPLES_MAX: usize = 1 << 21;
/// Minimum number of cycles of a period in the record.
const CYCLES_MIN: f64 = 3.0;
/// Independent tests per frequency of the transform, since periods between frequencies are searched too.
const TESTS_PER_FREQUENCY: f64 = 2.5;
/// Number of peaks examined for each kind of term.
const PEAKS: usize = 2;

/// Number of independent frequencies on each side of a period from which the noise beside it is taken.
const BESIDE: [usize; 4] = [3, 6, 12, 24];
/// Risk that noise that is as loud at all frequencies is taken for louder beside a period.
const RISK: f64 = 0.01;

/// Frequencies that a record tells apart.
struct Frequencies {
    /// Number of samples of the record, and of the transform.
    bins: usize,
    length: usize,
    interval: f64,
}

impl Frequencies {
    fn of(scene: &Scene<'_>) -> Option<Self> {
        let (block, channels) = (scene.data.block, scene.data.channels);
        let interval = scene.data.layout.interval();
        let (first, last) = robust::ends(channels.time.iter().copied());
        let bins = ((last - first) / interval).ceil() as usize + 1;
        let transformable = (32..=SAMPLES_MAX).contains(&bins);
        let is_row = block.aggregate == Aggregate::Row && block.rows.len() >= 64;
        let length = (2 * bins).next_power_of_two();
        (is_row && transformable).then_some(Self { bins, length, interval })
    }

    /// Power of the scores of `scene` at each of them, as a term that acts `on` this shows them.
    fn power(&self, scene: &Scene<'_>, on: Acts) -> Option<Vec<f64>> {
        let (block, channels) = (scene.data.block, scene.data.channels);
        let exposed = exposure(block, on)?;
        let (first, _) = robust::ends(channels.time.iter().copied());
        let mut spectrum = vec![Complex::new(0.0, 0.0); self.length];
        for (score, &row) in scene.scores.iter().zip(&block.rows) {
            let bin = ((channels.time[row] - first) / self.interval).round() as usize;
            if bin < self.length {
                spectrum[bin].re += score * exposed.per_row[row];
            }
        }
        scene.record.transform(self.length).process(&mut spectrum);
        Some(spectrum[..=self.length / 2].iter().map(|value| value.norm_sqr()).collect())
    }

    /// The period of each, and the first that goes round often enough.
    fn period(&self, bin: usize) -> f64 {
        self.length as f64 * self.interval / bin as f64
    }

    fn lowest(&self) -> usize {
        (CYCLES_MIN * self.length as f64 / self.bins as f64).ceil() as usize
    }
}

/// The likeliest periods, and the number of independent tests.
pub fn periods(scene: &Scene<'_>) -> (Vec<Candidate>, f64) {
    let Some(frequencies) = Frequencies::of(scene) else { return (Vec::new(), 1.0) };
    let (lowest, highest) = (frequencies.lowest(), frequencies.length / 2);
    let mut found = Vec::new();
    let mut kinds = 0.0;
    for on in [Acts::Bias, Acts::Scale, Acts::Turn, Acts::Curvature, Acts::Drive] {
        if exposure(scene.data.block, on).is_none() {
            continue;
        }
        kinds += 1.0;
        if highest <= lowest {
            continue;
        }
        let power = frequencies.power(scene, on).unwrap_or_default();
        let mut order: Vec<usize> = (lowest..highest)
            .filter(|&bin| power[bin] >= power[bin - 1] && power[bin] >= power[bin + 1])
            .collect();
        order.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
        for bin in order.into_iter().take(PEAKS) {
            found.push(periodic(on, scene.data.channels, frequencies.period(bin)));
        }
    }
    (found, TESTS_PER_FREQUENCY * kinds * frequencies.bins as f64 / 2.0)
}

/// How much louder noise is beside the period of `shape` than at all frequencies, if it is: a band of noise has a largest
/// wave like any other, and that is as surprising as it is large within the band. The wave itself counts on neither side.
pub fn loudness(scene: &Scene<'_>, shape: &Shape) -> f64 {
    let Some(frequencies) = Frequencies::of(scene) else { return 1.0 };
    let shape = refine(scene, shape);
    let without = scene.with(&scene.data.columns(&shape));
    let power = frequencies.power(&without, shape.acts).unwrap_or_default();
    let Some(period) = shape.number("period").filter(|_| !power.is_empty()) else { return 1.0 };
    let mean = |bins: Vec<usize>| {
        bins.iter().map(|bin| power[*bin]).sum::<f64>() / bins.len().max(1) as f64
    };
    let lowest = frequencies.lowest();
    let all = mean((lowest..power.len()).collect());
    let middle = frequencies.length as f64 * frequencies.interval / period;
    // What the wave itself leaves is within one independent frequency.
    let apart = frequencies.length as f64 / frequencies.bins as f64;
    let louder = |count: usize| {
        let is_beside = |bin: &usize| {
            (1.0..=1.0 + count as f64).contains(&((*bin as f64 - middle).abs() / apart))
        };
        let bins: Vec<usize> = (lowest..power.len()).filter(is_beside).collect();
        let waves = bins.len() as f64 / apart;
        let ratio = mean(bins) / all;
        let surprise = surprise_chi2(2.0 * waves * ratio, (2.0 * waves).max(1.0));
        if surprise > (BESIDE.len() as f64 / RISK).ln() { ratio } else { 1.0 }
    };
    BESIDE.map(louder).into_iter().fold(1.0, f64::max)
}
