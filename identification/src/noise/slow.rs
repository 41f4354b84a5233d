//! Noise with a long memory: a random walk of the measured quantity (rate random walk of a gyro in IEEE Std 952) or
//! noise whose correlation time is a considerable part of the record (exponentially correlated noise there).
//!
//! Slow noise competes with noise whose memory is shorter than a tenth of a stretch, both at their likeliest, and
//! either may have a further, shorter memory. Only a record many times as long as the memory distinguishes the two
//! kinds.

use super::layout::means;
use super::{Coloured, Layout, NoiseModel, Residual, Whitener};
use crate::linear::{Basis, dot};
use crate::significance::surprise_chi2;

/// Noise with a memory of a considerable part of a stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slow {
    /// Variance added per second, SI.
    pub variance_per_s: f64,
    /// Standard error of its logarithm.
    pub log_error: f64,
    /// Correlation time, if a finite one is likelier than a walk.
    pub correlation_s: Option<f64>,
    /// Probability of the other kind.
    pub other: f64,
    /// Surprise under noise with a short memory, in nats.
    pub surprise: f64,
}

/// Noise with a memory below this share of a stretch is not slow.
const SOON: f64 = 0.1;
/// Memories of slow noise tried besides a walk, as shares of a stretch. Longer ones are indistinguishable from a walk.
const MEMORIES: [f64; 3] = [0.1, 0.17, 0.29];
/// Longest additional memory, as a share of a stretch; a longer one could not be told from the slow part.
const SHORT: f64 = 0.03;
/// Memory of a walk, in stretches.
const LASTS: f64 = 30.0;
/// Number of observations used: means of several.
const THINNED: usize = 1200;
/// Minimum number of observations to separate slow noise from fast.
const OBSERVATIONS_MIN: usize = 100;
/// Maximum number of stretches; more are too short.
const STRETCHES_MAX: usize = 40;
/// A column with less than this share of its square beyond those before it depends on them.
const DEPENDENT: f64 = 1e-12;
/// Variances that are tried, in decades over that of a mean's white noise, and the finest step between them.
const DECADES: std::ops::RangeInclusive<i32> = -4..=3;
const FINEST: f64 = 0.1;

/// The record in means of several observations. Each stretch has its own offset, since the start of a walk is unknown.
struct Means {
    layout: Layout,
    residual: Vec<f64>,
    columns: Vec<Vec<f64>>,
    left_out: Vec<bool>,
}

/// The slow noise in `residual`, if `noise` has a long memory and is likelier than any
/// with a short memory.
pub fn slow(residual: Residual<'_>, noise: &NoiseModel) -> Option<Slow> {
    let layout = residual.layout;
    let span = layout.span();
    let remembers = noise.coloured.iter().any(|part| part.correlation_s > SOON * span);
    if layout.is_level() || !remembers {
        return None;
    }
    let means = Means::new(residual, noise)?;
    let soon = means.likeliest(&[SHORT, SOON].map(|share| share * span));
    let walking = means.likeliest(&[LASTS * span]);
    let forgetting = MEMORIES.map(|share| means.likeliest(&[share * span]));
    let memory = forgetting.into_iter().fold(Likeliest::NONE, better);
    let best = better(walking, memory);
    // A uniform prior over these memories and a walk.
    let evidence = forgetting.iter().map(|one| (one.value - best.value).exp()).sum::<f64>()
        / MEMORIES.len() as f64;
    let walks = (walking.value - best.value).exp();
    let is_walk = walks >= evidence;
    let kind = if is_walk { walking } else { memory };
    let bend = means.bend(&kind);
    // The memory is one more parameter, at the end of its range without slow noise: half of chi-squared (Self and Liang
    // 1987).
    let surprise = surprise_chi2(2.0 * (best.value - soon.value).max(0.0), 1.0) + 2.0_f64.ln();
    // A process of variance v and memory t adds a variance of 2 v / t per second.
    (bend > 0.0).then(|| Slow {
        variance_per_s: 2.0 * kind.slow.variance * kind.scale.powi(2) / kind.slow.correlation_s,
        log_error: bend.sqrt().recip(),
        correlation_s: (!is_walk).then_some(kind.slow.correlation_s),
        other: walks.min(evidence) / (walks + evidence),
        surprise,
    })
}

/// The likeliest noise with a slow part; variances are relative to the white noise.
#[derive(Clone, Copy)]
struct Likeliest {
    value: f64,
    /// Standard deviation of the white noise of a mean.
    scale: f64,
    slow: Coloured,
    /// The part with a shorter memory.
    short: Option<Coloured>,
}

impl Likeliest {
    const NONE: Self = Self {
        value: f64::NEG_INFINITY,
        scale: 1.0,
        slow: Coloured { correlation_s: 1.0, variance: 0.0 },
        short: None,
    };
}

impl Means {
    fn new(residual: Residual<'_>, noise: &NoiseModel) -> Option<Self> {
        let Residual { layout, values, columns } = residual;
        let out = |i: usize| {
            noise.leaves_out(i) || layout.spread.get(i).is_some_and(|spread| !spread.is_finite())
        };
        let (thin, groups) = layout.thinned(layout.len().div_ceil(THINNED));
        let of = |values: &[f64]| means(&groups, values, out);
        let starts: Vec<usize> = (0..thin.len()).filter(|&i| thin.starts[i]).collect();
        if thin.len() < OBSERVATIONS_MIN || starts.len() > STRETCHES_MAX {
            return None;
        }
        let ends = starts.iter().skip(1).copied().chain([thin.len()]);
        let mut columns: Vec<Vec<f64>> = columns.iter().map(|column| of(column)).collect();
        for (from, to) in starts.iter().zip(ends) {
            let mut offset = vec![0.0; thin.len()];
            offset[*from..to].fill(1.0);
            columns.push(offset);
        }
        let left_out = groups.iter().map(|range| range.clone().all(out)).collect();
        Some(Self { residual: of(values), columns, left_out, layout: thin })
    }

    /// Restricted log-likelihood (Patterson and Thompson 1971), and the scale.
    fn value(&self, coloured: Vec<Coloured>) -> (f64, f64) {
        let noise = NoiseModel {
            coloured,
            left_out: self.left_out.clone(),
            ..NoiseModel::white(self.layout.runs())
        };
        let whitener = Whitener::new(&self.layout, &noise);
        let columns = whitener.apply_all(&self.columns);
        let mut basis = Basis::default();
        let mut determinant = 0.0;
        for mut column in columns {
            let before = dot(&column, &column);
            basis.project(&mut column);
            let left = dot(&column, &column);
            // A column that depends on others removes nothing more: what is left of it is rounding.
            if left > DEPENDENT * before && basis.push(column) {
                determinant += left.ln();
            }
        }
        let mut white = whitener.apply(&self.residual);
        basis.project(&mut white);
        let free = (whitener.used() as f64 - basis.len() as f64).max(1.0);
        let square = dot(&white, &white).max(f64::MIN_POSITIVE) / free;
        (-0.5 * (free * square.ln() + whitener.log_determinant + determinant), square.sqrt())
    }

    fn with(&self, slow: Coloured, short: Option<Coloured>) -> Likeliest {
        let (value, scale) = self.value(short.into_iter().chain([slow]).collect());
        Likeliest { value, scale, slow, short }
    }

    /// The likeliest noise with a slow part whose memory is one of `memories` or between two of them, and with a
    /// shorter memory if it pays.
    fn likeliest(&self, memories: &[f64]) -> Likeliest {
        let interval = self.layout.interval();
        // A process of variance v and memory t adds 2 v / t per second: the grid has equal steps in that.
        let slow = |memory: f64, step: f64| Coloured {
            correlation_s: memory,
            variance: step * memory / interval,
        };
        let every = memories.iter().flat_map(|memory| {
            DECADES.map(|decade| self.with(slow(*memory, 10_f64.powi(decade)), None))
        });
        let Some(mut best) = every.reduce(better) else { return Likeliest::NONE };
        let mut correlation_s = 2.0 * interval;
        while correlation_s < SHORT * self.layout.span() {
            for variance in [0.1, 1.0, 10.0] {
                let short = Some(Coloured { correlation_s, variance });
                for factor in [0.1, 1.0, 10.0] {
                    let slow = Coloured { variance: factor * best.slow.variance, ..best.slow };
                    best = better(best, self.with(slow, short));
                }
            }
            correlation_s *= 3.0;
        }
        // Final tuning of all numbers.
        let bounds = memories
            .iter()
            .fold((f64::INFINITY, 0.0), |(low, high), memory| (memory.min(low), memory.max(high)));
        let mut step = 3.0;
        while step > 1.0 + FINEST {
            for which in 0..4 {
                for factor in [step, 1.0 / step] {
                    let (mut slow, mut short) = (best.slow, best.short);
                    match (which, &mut short) {
                        (0, _) => slow.variance *= factor,
                        (1, _) if bounds.0 < bounds.1 => {
                            let memory = (slow.correlation_s * factor).clamp(bounds.0, bounds.1);
                            slow.variance *= memory / slow.correlation_s;
                            slow.correlation_s = memory;
                        }
                        (2, Some(short)) => short.variance *= factor,
                        (3, Some(short)) => {
                            let limit = SHORT * self.layout.span();
                            short.correlation_s = (short.correlation_s * factor).min(limit);
                        }
                        _ => continue,
                    }
                    best = better(best, self.with(slow, short));
                }
            }
            step = step.sqrt();
        }
        best
    }

    /// Curvature of the log-likelihood over the logarithm of the slow part's variance: its information.
    fn bend(&self, at: &Likeliest) -> f64 {
        let step: f64 = 0.5;
        let side = |sign: f64| {
            let variance = at.slow.variance * (sign * step).exp();
            self.with(Coloured { variance, ..at.slow }, at.short).value
        };
        (2.0 * at.value - side(1.0) - side(-1.0)) / (step * step)
    }
}

fn better(a: Likeliest, b: Likeliest) -> Likeliest {
    if b.value > a.value { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::{Slow, slow};
    use crate::noise::{Layout, Residual};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RUNS: usize = 6;
    const ROWS: usize = 1200;

    /// Six runs of white noise with a walk of `step` a row and noise of `colour` that keeps `keep` of itself.
    fn found(seed: u64, step: f64, (keep, colour): (f64, f64)) -> Option<Slow> {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut residual = Vec::new();
        for _ in 0..RUNS {
            let (mut walks, mut kept) = (0.0, colour * normal());
            for _ in 0..ROWS {
                walks += step * normal();
                kept = keep * kept + colour * (1.0 - keep * keep).sqrt() * normal();
                residual.push(normal() + walks + kept);
            }
        }
        let layout = Layout::of_rows(RUNS, ROWS, 1.0);
        let bias = vec![vec![1.0; residual.len()]];
        let residual = Residual { layout: &layout, values: &residual, columns: &bias };
        slow(residual, &residual.fit()).filter(|found| found.surprise > 5.3)
    }

    #[test]
    fn a_walk_is_found_with_its_size() {
        for (step, colour) in [(0.03, (0.0, 0.0)), (0.06, (0.8, 0.6))] {
            let all: Vec<Slow> = (0..8).filter_map(|seed| found(seed, step, colour)).collect();
            let walks: Vec<&Slow> =
                all.iter().filter(|slow| slow.correlation_s.is_none()).collect();
            assert!(walks.len() >= 6, "{colour:?} {all:?}");
            for slow in walks {
                let off = (slow.variance_per_s / f64::powi(step, 2)).ln();
                assert!(off.abs() < 4.0 * slow.log_error, "{slow:?}");
            }
        }
    }

    #[test]
    fn noise_that_forgets_soon_is_not_slow() {
        for (keep, colour) in [(0.0, 0.0), (0.8, 0.6), (0.95, 0.6), (0.98, 2.0)] {
            for seed in 0..12 {
                assert_eq!(found(seed, 0.0, (keep, colour)), None, "{keep} {seed}");
            }
        }
    }

    #[test]
    fn noise_that_forgets_after_a_quarter_of_a_record_is_slow_and_no_sure_walk() {
        let all: Vec<Slow> =
            (0..12).filter_map(|seed| found(seed, 0.0, (1.0 - 1.0 / 300.0, 1.0))).collect();
        let surely = all.iter().filter(|slow| slow.correlation_s.is_none() && slow.other < 0.05);
        assert!(all.len() >= 6 && surely.count() <= 1, "{all:?}");
    }
}
