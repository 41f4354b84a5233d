//! Noise without an end to its memory: a random walk of what is measured (the rate random walk of a gyro in IEEE Std 952).
//!
//! A record says of a memory that is longer than itself only that it is long. So a walk is set against noise that forgets
//! within a part of a stretch, both at their likeliest, beside a shorter memory that either may have.

use super::{Coloured, Layout, NoiseModel, Whitener};
use crate::linear::{Basis, dot};

/// A walk that is likelier than any noise that forgets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walk {
    /// Variance that it brings in a second, SI.
    pub variance_per_s: f64,
    /// Standard error of the logarithm of that.
    pub log_error: f64,
    /// By how much it is likelier, in nats.
    pub strength: f64,
}

/// Noise that forgets over less than this share of a stretch does not walk.
const FORGETS: f64 = 0.1;
/// A memory beside it is over less than this share, or the two could not be told apart.
const SHORT: f64 = 0.03;
/// A walk is a memory of so many stretches.
const LASTS: f64 = 30.0;
/// Observations that are looked at: means of several.
const THINNED: usize = 1200;
/// Fewer have no place for what is slow and what is not.
const OBSERVATIONS_MIN: usize = 100;
/// Stretches beyond this are short ones.
const STRETCHES_MAX: usize = 40;
/// Variances that are tried, in decades over that of a mean's white noise, and the finest step between them.
const DECADES: std::ops::RangeInclusive<i32> = -4..=3;
const FINEST: f64 = 0.1;

/// The record in means of several observations, each stretch with an offset of its own: where a walk begins nobody knows.
struct Means {
    layout: Layout,
    residual: Vec<f64>,
    columns: Vec<Vec<f64>>,
    left_out: Vec<bool>,
}

/// The walk in `residual` less what `columns` explain, if `noise` has a long memory and nothing that forgets is as likely.
pub fn walk(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
    left_out: &[bool],
) -> Option<Walk> {
    let forgets = FORGETS * layout.span();
    let remembers = noise.coloured.iter().any(|part| part.correlation_s > forgets);
    if layout.is_level() || !remembers {
        return None;
    }
    let means = Means::new(layout, residual, columns, left_out)?;
    let bounded = means.likeliest(forgets);
    let long = LASTS * layout.span();
    let walking = means.likeliest(long);
    let bend = means.bend(long, &walking);
    // A walk of the variance v by a memory of t brings 2 v / t in a second.
    (walking.value > bounded.value && bend > 0.0).then(|| Walk {
        variance_per_s: 2.0 * walking.slow * walking.scale.powi(2) / long,
        log_error: bend.sqrt().recip(),
        strength: walking.value - bounded.value,
    })
}

/// The likeliest noise with a slow part of a given memory.
#[derive(Clone, Copy)]
struct Likeliest {
    value: f64,
    /// Standard deviation of the white noise of a mean.
    scale: f64,
    /// Variance of the slow part over that of the white noise.
    slow: f64,
    /// The part with a shorter memory.
    short: Option<Coloured>,
}

impl Means {
    fn new(
        layout: &Layout,
        residual: &[f64],
        columns: &[Vec<f64>],
        left_out: &[bool],
    ) -> Option<Self> {
        let out = |i: usize| {
            left_out.get(i).copied().unwrap_or(false)
                || layout.spread.get(i).is_some_and(|spread| !spread.is_finite())
        };
        let (thin, groups) = layout.thinned(layout.len().div_ceil(THINNED));
        let of = |values: &[f64]| -> Vec<f64> {
            let mean = |range: &std::ops::Range<usize>| {
                let used = range.clone().filter(|&i| !out(i));
                let (sum, count) = used.fold((0.0, 0.0), |(s, c), i| (s + values[i], c + 1.0));
                sum / f64::max(count, 1.0)
            };
            groups.iter().map(mean).collect()
        };
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
        Some(Self { residual: of(residual), columns, left_out, layout: thin })
    }

    /// Logarithm of the likelihood of what the columns say nothing of (Patterson and Thompson 1971), and the scale.
    fn value(&self, coloured: Vec<Coloured>) -> (f64, f64) {
        let noise = NoiseModel { coloured, ..NoiseModel::white(self.layout.runs()) };
        let whitener = Whitener::new(&self.layout, &noise, &self.left_out);
        let columns = whitener.apply_all(&self.columns);
        let mut basis = Basis::default();
        let mut determinant = 0.0;
        for mut column in columns {
            let before = dot(&column, &column);
            basis.project(&mut column);
            let left = dot(&column, &column);
            // What another column says already takes no more away.
            if basis.push(column) {
                determinant += left.max(f64::MIN_POSITIVE * before).ln();
            }
        }
        let mut white = whitener.apply(&self.residual);
        basis.project(&mut white);
        let free = (whitener.used() as f64 - basis.len() as f64).max(1.0);
        let square = dot(&white, &white).max(f64::MIN_POSITIVE) / free;
        (-0.5 * (free * square.ln() + whitener.log_determinant + determinant), square.sqrt())
    }

    fn with(&self, slow: f64, memory: f64, short: Option<Coloured>) -> (f64, f64) {
        let slow = Coloured { correlation_s: memory, variance: slow };
        self.value(short.into_iter().chain([slow]).collect())
    }

    /// The likeliest noise with a part that remembers over `memory`, and a shorter one where it pays.
    fn likeliest(&self, memory: f64) -> Likeliest {
        let unit = memory / self.layout.interval();
        let alone = self.slow(memory, unit, None, DECADES.map(|e| 10_f64.powi(e)).collect());
        let mut best = alone;
        let mut correlation_s = 2.0 * self.layout.interval();
        while correlation_s < SHORT * self.layout.span() {
            for variance in [0.1, 1.0, 10.0] {
                let short = Some(Coloured { correlation_s, variance });
                let near = [0.1, 1.0, 10.0].map(|factor| factor * best.slow / unit).to_vec();
                let tried = self.slow(memory, unit, short, near);
                if tried.value > best.value {
                    best = tried;
                }
            }
            correlation_s *= 3.0;
        }
        // Both parts at their best.
        let mut step = 3.0;
        while step > 1.0 + FINEST {
            for which in 0..3 {
                for factor in [step, 1.0 / step] {
                    let (mut slow, mut short) = (best.slow, best.short);
                    match (which, &mut short) {
                        (0, _) => slow *= factor,
                        (1, Some(short)) => short.variance *= factor,
                        (2, Some(short)) => {
                            let limit = SHORT * self.layout.span();
                            short.correlation_s = (short.correlation_s * factor).min(limit);
                        }
                        _ => continue,
                    }
                    let (value, scale) = self.with(slow, memory, short);
                    if value > best.value {
                        best = Likeliest { value, scale, slow, short };
                    }
                }
            }
            step = step.sqrt();
        }
        best
    }

    /// The likeliest of these variances of the slow part, in `unit`.
    fn slow(
        &self,
        memory: f64,
        unit: f64,
        short: Option<Coloured>,
        variances: Vec<f64>,
    ) -> Likeliest {
        let found = variances.into_iter().map(|variance| {
            let slow = variance * unit;
            let (value, scale) = self.with(slow, memory, short);
            Likeliest { value, scale, slow, short }
        });
        let worst = Likeliest { value: f64::NEG_INFINITY, scale: 1.0, slow: unit, short };
        found.fold(worst, |a, b| if b.value > a.value { b } else { a })
    }

    /// How the likelihood bends over the logarithm of the slow part's variance: its information.
    fn bend(&self, memory: f64, at: &Likeliest) -> f64 {
        let step: f64 = 0.5;
        let side = |sign: f64| self.with(at.slow * (sign * step).exp(), memory, at.short).0;
        (2.0 * at.value - side(1.0) - side(-1.0)) / (step * step)
    }
}

#[cfg(test)]
mod tests {
    use super::{Walk, walk};
    use crate::noise::{self, Layout};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RUNS: usize = 6;
    const ROWS: usize = 1200;

    /// Six runs of white noise with a walk of `step` a row and noise of `colour` that keeps `keep` of itself.
    fn found(seed: u64, step: f64, (keep, colour): (f64, f64)) -> Option<Walk> {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut residual = Vec::new();
        for _ in 0..RUNS {
            let (mut walks, mut slow) = (0.0, colour * normal());
            for _ in 0..ROWS {
                walks += step * normal();
                slow = keep * slow + colour * (1.0 - keep * keep).sqrt() * normal();
                residual.push(normal() + walks + slow);
            }
        }
        let layout = Layout::of_rows(RUNS, ROWS, 1.0);
        let bias = vec![vec![1.0; residual.len()]];
        let (noise, left_out) = noise::fit(&layout, &residual, &bias, None);
        walk(&layout, &residual, &bias, &noise, &left_out)
    }

    #[test]
    fn a_walk_is_found_with_its_size() {
        for (step, colour) in [(0.03, (0.0, 0.0)), (0.06, (0.8, 0.6))] {
            let all: Vec<Walk> = (0..8).filter_map(|seed| found(seed, step, colour)).collect();
            assert!(
                all.iter().filter(|walk| walk.strength > 5.3).count() >= 7,
                "{colour:?} {all:?}"
            );
            for walk in all {
                let off = (walk.variance_per_s / f64::powi(step, 2)).ln();
                assert!(off.abs() < 4.0 * walk.log_error, "{walk:?}");
            }
        }
    }

    #[test]
    fn noise_that_forgets_does_not_walk() {
        for (keep, colour) in [(0.0, 0.0), (0.8, 0.6), (0.95, 0.6), (0.98, 2.0)] {
            for seed in 0..12 {
                let walk = found(seed, 0.0, (keep, colour));
                assert!(walk.is_none_or(|walk| walk.strength < 5.3), "{keep} {seed} {walk:?}");
            }
        }
    }
}
