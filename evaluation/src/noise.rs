//! Classes of noise, each with its draws and its whitener.

use crate::design::{Autoregression, Whitener};
use crate::random::Stream;
use std::ops::Range;

/// A class of noise. Lengths are in rows; every class has a nominal standard deviation of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Noise {
    /// Independent normal.
    White,
    /// A first-order autoregression of that correlation time, with independent noise below it.
    Autoregressive(f64),
    /// A random walk that reaches one standard deviation in a quarter of a run, on independent noise.
    RandomWalk,
    /// Autoregressions a decade apart, a stand-in for 1/f noise, on independent noise.
    Flicker,
    /// Student's t with three degrees of freedom.
    Student,
    /// One row in a hundred is ten times as noisy.
    Outliers,
    /// Independent normal, rounded to steps of that many standard deviations.
    Quantised(f64),
    /// Independent normal with a different standard deviation in each run, from one to four times the nominal.
    PerRun,
    /// Independent normal, and wheels that slip at random, each by itself: an error of the motion, which stays. Of
    /// driven paths only.
    Slip,
}

/// Variance of the independent part beside an autoregression, and of the autoregression (assumption).
const BELOW: f64 = 0.64;
const CORRELATED: f64 = 0.36;
/// Correlation times of the flicker's parts, rows.
const FLICKER: [f64; 4] = [10.0, 100.0, 1_000.0, 10_000.0];

/// Drawn noise of a class: values of unit variance and their whitener.
pub struct Drawn {
    /// One per row.
    pub values: Vec<f64>,
    /// Whitens `sd` times `values`. A class that is neither independent nor autoregressive is treated as independent.
    pub whitener: Whitener,
    /// The readout's step, in nominal standard deviations.
    pub step: f64,
}

/// The readout's step of an ordinary instrument, in standard deviations of its noise (assumption).
pub const ORDINARY_STEP: f64 = 0.05;

impl Noise {
    /// Name of the class in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Autoregressive(_) => "autoregressive",
            Self::RandomWalk => "random walk",
            Self::Flicker => "flicker",
            Self::Student => "Student t3",
            Self::Outliers => "outliers",
            Self::Quantised(_) => "quantised",
            Self::PerRun => "differs by run",
            Self::Slip => "slip",
        }
    }

    /// Draws noise for rows in those runs, with standard deviation `sd` of each row.
    pub fn draw(self, stream: &mut Stream, runs: &[Range<usize>], sd: &[f64]) -> Drawn {
        let factors: Vec<f64> = match self {
            Self::PerRun => runs.iter().map(|_| stream.between(1.0, 4.0)).collect(),
            _ => vec![1.0; runs.len()],
        };
        let mut values = Vec::with_capacity(sd.len());
        for (run, factor) in runs.iter().zip(&factors) {
            let unit = self.run(stream, run.len());
            values.extend(unit.iter().map(|x| x * factor));
        }
        let of_row =
            || runs.iter().zip(&factors).flat_map(|(run, f)| run.clone().map(move |k| f * sd[k]));
        let whitener = match self {
            Self::Autoregressive(_) | Self::RandomWalk => Whitener::Autoregressive(
                runs.iter().map(|run| self.model(run.len()).scaled(sd[run.start])).collect(),
            ),
            _ => Whitener::Independent(of_row().collect()),
        };
        for (value, sd) in values.iter_mut().zip(sd) {
            *value *= sd;
        }
        let step = if let Self::Quantised(step) = self { step } else { ORDINARY_STEP };
        Drawn { values, whitener, step }
    }

    fn run(self, stream: &mut Stream, n: usize) -> Vec<f64> {
        let mut unit: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
        match self {
            Self::White | Self::PerRun | Self::Slip | Self::Quantised(_) => {}
            Self::Student => unit.iter_mut().for_each(|x| *x = stream.student_3()),
            Self::Outliers => unit.iter_mut().for_each(|x| {
                if stream.chance(0.01) {
                    *x *= 10.0;
                }
            }),
            Self::Flicker => {
                for tau in FLICKER {
                    let path = stream.wander(n, 1.0, (CORRELATED / 2.0).sqrt(), tau);
                    unit.iter_mut().zip(path).for_each(|(x, path)| *x += path);
                }
            }
            Self::Autoregressive(_) | Self::RandomWalk => {
                let of = self.model(n);
                let mut x = of.start * stream.normal();
                for unit in &mut unit {
                    *unit = x + of.white * *unit;
                    x = of.phi * x + of.process * stream.normal();
                }
            }
        }
        unit
    }

    fn model(self, n: usize) -> Autoregression {
        match self {
            Self::Autoregressive(tau) => {
                let phi = (-1.0 / tau).exp();
                let start = CORRELATED.sqrt();
                let process = start * (1.0 - phi * phi).sqrt();
                Autoregression { phi, process, start, white: BELOW.sqrt() }
            }
            _ => {
                let process = (4.0 / n.max(1) as f64).sqrt();
                Autoregression { phi: 1.0, process, start: 0.0, white: 1.0 }
            }
        }
    }
}

impl Autoregression {
    fn scaled(self, by: f64) -> Self {
        Self { process: self.process * by, start: self.start * by, white: self.white * by, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_is_what_it_says() {
        let runs = [0..20_000, 20_000..40_000];
        let mean_fourth = |noise: Noise| {
            let drawn =
                noise.draw(&mut Stream::new(1, noise.name(), 0, "test"), &runs, &[0.5; 40_000]);
            let white = match &drawn.whitener {
                Whitener::Independent(sd) => {
                    drawn.values.iter().zip(sd).map(|(x, s)| x / s).collect()
                }
                _ => drawn.values.clone(),
            };
            let moment =
                |power: i32| white.iter().map(|x: &f64| x.powi(power)).sum::<f64>() / 40_000.0;
            (moment(2), moment(4) / moment(2).powi(2))
        };
        let (variance, kurtosis) = mean_fourth(Noise::White);
        assert!((variance - 1.0).abs() < 0.05 && (kurtosis - 3.0).abs() < 0.2);
        let (variance, kurtosis) = mean_fourth(Noise::PerRun);
        assert!((variance - 1.0).abs() < 0.05 && (kurtosis - 3.0).abs() < 0.2);
        assert!(mean_fourth(Noise::Student).1 > 6.0);
        assert!(mean_fourth(Noise::Outliers).1 > 20.0);
    }
}
