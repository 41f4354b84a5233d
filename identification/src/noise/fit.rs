//! The noise of a residual by maximum likelihood, part by part as long as a part pays.

use super::whiten::COLOURED_MAX;
use super::{Coloured, Layout, NoiseModel, Whitener};
use crate::linear::{Basis, dot};
use crate::robust;

/// How well a noise model explains a residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Logarithm of the likelihood, with the scale at its best value.
    pub log_likelihood: f64,
    /// That scale: standard deviation of a whitened observation.
    pub scale: f64,
    /// Observations that took part.
    pub used: usize,
}

/// What a coloured part has to add to the logarithm of the likelihood (two parameters).
const PART_GAIN_MIN: f64 = 3.0;
/// An observation this many standard deviations off has no say in the noise.
const OUTLIER: f64 = 4.5;
/// A run with fewer observations has no noise level of its own.
const RUN_ROWS_MIN: usize = 40;
/// Coloured parts beyond this explain nothing that fewer do not.
const PARTS_MAX: usize = 3;

/// Likelihood of `residual` less what `columns` explain, under `noise`.
pub fn evidence(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
    left_out: &[bool],
) -> Evidence {
    let whitener = Whitener::new(layout, noise, left_out);
    let mut basis = Basis::default();
    for column in columns {
        basis.push(whitener.apply(column));
    }
    let mut white = whitener.apply(residual);
    basis.project(&mut white);
    let used = whitener.used();
    let n = used as f64;
    let sum = dot(&white, &white).max(f64::MIN_POSITIVE);
    Evidence {
        log_likelihood: -0.5 * (n * (sum / n).ln() + whitener.log_determinant),
        scale: (sum / (n - basis.len() as f64).max(1.0)).sqrt(),
        used,
    }
}

/// The noise of `residual` less what `columns` explain, beginning with `start`; and which observations are
/// outliers under it.
pub fn fit(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    start: Option<&NoiseModel>,
) -> (NoiseModel, Vec<bool>) {
    let mut noise = start.cloned().unwrap_or_else(|| NoiseModel::white(layout.runs()));
    if layout.is_level() && noise.walk == 0.0 {
        noise.walk = 1.0 / layout.mean_activity().max(f64::MIN_POSITIVE);
    }
    let mut left_out = outliers(layout, residual, columns, &noise);
    for _ in 0..2 {
        let search = Search { layout, residual, columns, left_out: &left_out };
        if layout.is_level() {
            search.walk(&mut noise);
        }
        search.parts(&mut noise);
        noise.run_scale = run_scales(layout, residual, columns, &noise);
        left_out = outliers(layout, residual, columns, &noise);
    }
    (noise, left_out)
}

/// The parts of `start` tuned to `residual` less what `columns` explain, and the logarithm of the likelihood. Parts
/// may go; none is added. `left_out` stays as it is, so that likelihoods can be compared.
pub fn retune(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    start: &NoiseModel,
    left_out: &[bool],
) -> (NoiseModel, f64) {
    let search = Search { layout, residual, columns, left_out };
    let mut noise = start.clone();
    let mut now = search.value(&noise);
    search.shrink(&mut noise, &mut now);
    search.tune(&mut noise, &mut now);
    (noise, now)
}

fn whitened(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
) -> Vec<f64> {
    let whitener = Whitener::new(layout, noise, &[]);
    let mut basis = Basis::default();
    for column in columns {
        basis.push(whitener.apply(column));
    }
    let mut white = whitener.apply(residual);
    basis.project(&mut white);
    white
}

fn outliers(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
) -> Vec<bool> {
    let white = whitened(layout, residual, columns, noise);
    let limit = OUTLIER * robust::spread(&white);
    white.iter().map(|value| value.abs() > limit).collect()
}

/// Noise of each run over that of all. Differences from one observation to the next see little of what is slow.
fn run_scales(
    layout: &Layout,
    residual: &[f64],
    columns: &[Vec<f64>],
    noise: &NoiseModel,
) -> Vec<f64> {
    let runs = layout.runs();
    let even = NoiseModel { run_scale: vec![1.0; runs], ..noise.clone() };
    let white = whitened(layout, residual, columns, &even);
    let mut of_run: Vec<Vec<f64>> = vec![Vec::new(); runs];
    for i in 1..white.len() {
        if layout.run[i] == layout.run[i - 1] {
            of_run[layout.run[i]].push((white[i] - white[i - 1]) * std::f64::consts::FRAC_1_SQRT_2);
        }
    }
    let all: Vec<f64> = of_run.iter().flatten().copied().collect();
    let overall = robust::spread(&all);
    of_run
        .iter()
        .map(|values| {
            let spread = robust::spread(values);
            let known = values.len() >= RUN_ROWS_MIN && spread > 0.0 && overall > 0.0;
            if known { (spread / overall).clamp(0.05, 20.0) } else { 1.0 }
        })
        .collect()
}

struct Search<'a> {
    layout: &'a Layout,
    residual: &'a [f64],
    columns: &'a [Vec<f64>],
    left_out: &'a [bool],
}

impl Search<'_> {
    fn value(&self, noise: &NoiseModel) -> f64 {
        evidence(self.layout, self.residual, self.columns, noise, self.left_out).log_likelihood
    }

    /// The best positive factor for a parameter, from a coarse search over decades and a fine one.
    fn best(&self, from: i32, to: i32, set: impl Fn(f64) -> NoiseModel) -> (f64, f64) {
        let at = |exponent: f64| {
            let value = 10_f64.powf(exponent);
            (self.value(&set(value)), exponent)
        };
        let mut best = (from..=to)
            .map(|exponent| at(f64::from(exponent)))
            .fold((f64::NEG_INFINITY, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        for step in [0.5, 0.25, 0.12] {
            for side in [best.1 - step, best.1 + step] {
                let tried = at(side);
                if tried.0 > best.0 {
                    best = tried;
                }
            }
        }
        (best.0, 10_f64.powf(best.1))
    }

    fn walk(&self, noise: &mut NoiseModel) {
        let unit = 1.0 / self.layout.mean_activity().max(f64::MIN_POSITIVE);
        let (_, ratio) = self.best(-6, 5, |ratio| NoiseModel { walk: ratio * unit, ..noise.clone() });
        noise.walk = ratio * unit;
    }

    /// Adds coloured parts while they pay, then tunes all and drops what no longer pays.
    fn parts(&self, noise: &mut NoiseModel) {
        let mut now = self.value(noise);
        self.tune(noise, &mut now);
        while noise.coloured.len() < PARTS_MAX.min(COLOURED_MAX) {
            let mut best: Option<(f64, Coloured)> = None;
            for correlation_s in self.correlations() {
                let with = |variance: f64| {
                    let mut noise = noise.clone();
                    noise.coloured.push(Coloured { correlation_s, variance: variance * self.unit() });
                    noise
                };
                // A quick look first: most correlation times have nothing to give.
                let quick = [0.003, 0.03, 0.3, 3.0].map(|variance| self.value(&with(variance)));
                if quick.iter().all(|value| *value < now + 0.5) {
                    continue;
                }
                let (value, variance) = self.best(-4, 4, with);
                if best.is_none_or(|(found, _)| value > found) {
                    best = Some((value, Coloured { correlation_s, variance: variance * self.unit() }));
                }
            }
            match best {
                Some((value, part)) if value > now + PART_GAIN_MIN => {
                    noise.coloured.push(part);
                    now = value;
                    self.tune(noise, &mut now);
                }
                _ => break,
            }
        }
        noise.coloured.sort_by(|a, b| a.correlation_s.total_cmp(&b.correlation_s));
    }

    /// On levels a coloured part is a rate: its variance is stated so that 1 brings, over its correlation time, as
    /// much as the white noise.
    fn unit(&self) -> f64 {
        if self.layout.is_level() { self.layout.interval().powi(-2) * 1e-2 } else { 1.0 }
    }

    fn correlations(&self) -> Vec<f64> {
        let (interval, span) = (self.layout.interval(), self.layout.span());
        let mut found = Vec::new();
        let mut at = 2.0 * interval;
        while at < 20.0 * span {
            found.push(at);
            at *= 10_f64.sqrt();
        }
        if !self.layout.is_level() && self.layout.runs() >= 4 {
            found.push(f64::INFINITY);
        }
        found
    }

    /// Much smaller parts are tried first: an effect may take all that a part stood for.
    fn shrink(&self, noise: &mut NoiseModel, now: &mut f64) {
        for k in 0..noise.coloured.len() {
            for factor in [0.3, 0.1, 0.03, 0.01] {
                let mut tried = noise.clone();
                tried.coloured[k].variance *= factor;
                let value = self.value(&tried);
                if value > *now {
                    (*noise, *now) = (tried, value);
                }
            }
        }
    }

    fn tune(&self, noise: &mut NoiseModel, now: &mut f64) {
        for step in [3.0, 1.8, 1.3] {
            for k in 0..noise.coloured.len() {
                for factor in [step, 1.0 / step] {
                    for which in 0..2 {
                        let mut tried = noise.clone();
                        if which == 0 {
                            tried.coloured[k].variance *= factor;
                        } else {
                            tried.coloured[k].correlation_s *= factor;
                        }
                        let value = self.value(&tried);
                        if value > *now {
                            (*noise, *now) = (tried, value);
                        }
                    }
                }
            }
        }
        // What takes nothing away when it goes, goes.
        let mut k = 0;
        while k < noise.coloured.len() {
            let mut without = noise.clone();
            without.coloured.remove(k);
            let value = self.value(&without);
            if value > *now - PART_GAIN_MIN {
                (*noise, *now) = (without, value);
            } else {
                k += 1;
            }
        }
    }
}
