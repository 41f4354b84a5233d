//! Noise: white, random walk, and anything coloured as a sum of first-order Gauss-Markov processes.
//!
//! Flicker noise over some decades is such a sum with equal variances, a random walk is one with a long
//! correlation time, an offset that differs from run to run one with an endless correlation time.

mod fit;
mod innovations;
mod layout;
mod search;
mod slow;
mod whiten;

pub use fit::{TIME_CAUTION, evidence, fit, priced, retune};
pub use layout::Layout;
pub use slow::slow;
pub use whiten::Whitener;

/// One first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coloured {
    /// Correlation time, s; infinite for an offset of each run.
    pub correlation_s: f64,
    /// Its variance, in units of the white noise's.
    pub variance: f64,
}

/// A model of the noise. Variances are relative; the scale is estimated beside.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Variance of the white noise of an observation: 1, or 0 where there is none.
    pub white: f64,
    /// Variance that a unit of activity brings to a level.
    pub walk: f64,
    /// Coloured parts. On a level they are rates that add up.
    pub coloured: Vec<Coloured>,
    /// Standard deviation of each run's noise over that of all.
    pub run_scale: Vec<f64>,
}

/// How noise adds up over rows that took different times: equally, or as a rate would; the likeliest.
pub fn likeliest_layout(
    plain: Layout,
    durations: &[f64],
    residual: &[f64],
    columns: &[Vec<f64>],
) -> Layout {
    let (low, high) =
        durations.iter().fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), d| (l.min(*d), h.max(*d)));
    if plain.is_level() || !(high > DIFFERENT_FROM * low) || !(low > 0.0) {
        return plain;
    }
    let value = |layout: &Layout| {
        let (noise, left_out) = fit(layout, residual, columns, None);
        evidence(layout, residual, columns, &noise, &left_out).log_likelihood
            - 3.0 * noise.coloured.len() as f64
            - 10.0 * left_out.iter().filter(|left_out| **left_out).count() as f64
    };
    let as_rates = [plain.over(durations, false), plain.over(durations, true)];
    let mut best = (value(&plain), plain);
    for layout in as_rates {
        let found = value(&layout) - LAYOUT_GAIN_MIN;
        if found > best.0 {
            best = (found, layout);
        }
    }
    best.1
}

/// What noise that adds up like a rate must explain beyond noise that is alike in all rows, in nats: an effect that
/// grows with the duration looks like it too. Where it is so, hundreds of rows say it with tens of nats.
const LAYOUT_GAIN_MIN: f64 = 8.0;
/// Durations that differ by less than this factor are alike.
const DIFFERENT_FROM: f64 = 1.1;

impl NoiseModel {
    /// White noise, equal in all runs.
    pub fn white(runs: usize) -> Self {
        Self { white: 1.0, walk: 0.0, coloured: Vec::new(), run_scale: vec![1.0; runs] }
    }

    /// Is there anything but white noise?
    pub fn is_coloured(&self) -> bool {
        !self.coloured.is_empty()
    }
}
