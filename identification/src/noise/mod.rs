//! Noise models: white noise, random walk, and coloured noise as a sum of first-order Gauss-Markov processes.
//!
//! Flicker noise over some decades is such a sum with equal variances, a random walk one with a long correlation time,
//! a different offset in each run one with an infinite correlation time.

mod fit;
mod innovations;
mod layout;
mod pose_filter;
mod poses;
mod residual;
mod search;
mod slow;
mod view;
mod whiten;

pub use fit::{TIME_CAUTION, Tuning};
pub use layout::Layout;
pub use residual::Residual;
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

/// A model of the noise. Variances are relative; the scale is estimated separately.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Variance of the white noise of an observation: 1, or 0 without white noise.
    pub white: f64,
    /// Variance that a unit of activity adds to a level, or to the heading of a pose.
    pub walk: f64,
    /// Variance that a unit of activity adds to a position along the way and to its side, in units of a position's white
    /// noise; `None` for poses whose heading, x and y err each by itself.
    pub slide: Option<[f64; 2]>,
    /// Coloured parts. On a level they are rates that accumulate.
    pub coloured: Vec<Coloured>,
    /// Standard deviation of each run's noise over that of all.
    pub run_scale: Vec<f64>,
    /// Which observations are outliers beside it and get no weight; empty if none is.
    pub left_out: Vec<bool>,
}

/// How noise accumulates over rows of different durations, equally or like a rate: the likelier of the two.
pub fn likeliest_layout(
    plain: Layout,
    durations: &[f64],
    values: &[f64],
    columns: &[Vec<f64>],
) -> Layout {
    let (low, high) =
        durations.iter().fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), d| (l.min(*d), h.max(*d)));
    if plain.is_level() || !(high > DIFFERENT_FROM * low) || !(low > 0.0) {
        return plain;
    }
    let value = |layout: &Layout| {
        let residual = Residual { layout, values, columns };
        let noise = residual.fit();
        residual.log_likelihood(&noise)
            - 3.0 * noise.coloured.len() as f64
            - 10.0 * noise.left_out.iter().filter(|left_out| **left_out).count() as f64
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

/// Extra evidence required of noise that accumulates like a rate, in nats: an effect that grows with the duration looks
/// the same. Hundreds of rows provide tens of nats if it does.
const LAYOUT_GAIN_MIN: f64 = 8.0;
/// Durations within this factor count as equal.
const DIFFERENT_FROM: f64 = 1.1;

impl NoiseModel {
    /// White noise, equal in all runs.
    pub fn white(runs: usize) -> Self {
        let run_scale = vec![1.0; runs];
        Self {
            white: 1.0,
            walk: 0.0,
            slide: None,
            coloured: Vec::new(),
            run_scale,
            left_out: Vec::new(),
        }
    }

    /// Equal errors of levels, and a walk that adds as much from one observation to the next.
    pub fn walking(layout: &Layout) -> Self {
        Self { walk: layout.mean_activity().recip(), ..Self::white(layout.runs()) }
    }

    /// The same noise beside other observations: none is left out.
    pub fn of_all(&self) -> Self {
        Self { left_out: Vec::new(), ..self.clone() }
    }

    /// Whether this observation is an outlier.
    pub fn leaves_out(&self, observation: usize) -> bool {
        self.left_out.get(observation).copied().unwrap_or(false)
    }

    /// Whether there is anything but white noise.
    pub fn is_coloured(&self) -> bool {
        !self.coloured.is_empty()
    }
}
