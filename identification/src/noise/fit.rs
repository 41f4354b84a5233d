//! Fits the noise of a residual by maximum likelihood; each part must pay for itself.

use super::search::Search;
use super::{NoiseModel, Residual, Whitener};
use crate::linear::Basis;
use crate::robust;

/// Price of a coloured part when it competes with a cause, in nats.
pub const PART_PRICE: f64 = 6.0;
/// Extra evidence required of a cause that follows time alone, since noise explains it as easily, in nats.
pub const TIME_CAUTION: f64 = 3.0;
/// Minimum number of observations for a run to have its own noise level.
const RUN_ROWS_MIN: usize = 40;

impl Residual<'_> {
    /// Fits noise to it.
    pub fn fit(self) -> NoiseModel {
        let layout = self.layout;
        let mut noise = match layout.is_level() {
            true => NoiseModel::walking(layout),
            false => NoiseModel::white(layout.runs()),
        };
        if layout.is_poses() {
            noise.slide = Some([0.0; 2]);
        }
        noise.left_out = self.outliers(&noise);
        for round in 0..2 {
            let before = noise.left_out.clone();
            let search = Search::new(self, &before, false);
            if layout.is_poses() {
                search.walks(&mut noise, round > 0);
            } else if layout.is_level() {
                search.walk(&mut noise);
            }
            search.parts(&mut noise);
            noise.run_scale = self.run_scales(&noise);
            noise.left_out = self.outliers(&noise);
            let changed = before.iter().zip(&noise.left_out).filter(|(a, b)| a != b).count();
            if round == 0 && changed * 500 < before.len() && !noise.is_coloured() {
                break;
            }
        }
        noise
    }

    /// Tunes the parts of `start` to it, and returns the log-likelihood minus the price of the parts.
    pub fn retune(self, start: &NoiseModel) -> (NoiseModel, f64) {
        Tuning(Search::new(self, &start.left_out, false)).retune(start)
    }

    /// The log-likelihood minus the price of the parts.
    pub fn priced(self, noise: &NoiseModel) -> f64 {
        self.log_likelihood(noise) - PART_PRICE * noise.coloured.len() as f64
    }

    fn whitened(self, noise: &NoiseModel) -> Vec<f64> {
        let whitener = Whitener::new(self.layout, &noise.of_all());
        let mut basis = Basis::default();
        basis.extend(whitener.apply_all(self.columns));
        let mut white = whitener.apply(self.values);
        basis.project(&mut white);
        white
    }

    fn outliers(self, noise: &NoiseModel) -> Vec<bool> {
        let white = self.whitened(noise);
        let used: Vec<f64> = white.iter().copied().filter(|value| *value != 0.0).collect();
        let limit = robust::GROSS * robust::spread(&used);
        white.iter().map(|value| value.abs() > limit).collect()
    }

    /// Noise of each run over that of all. Differences of consecutive observations suppress slow noise.
    fn run_scales(self, noise: &NoiseModel) -> Vec<f64> {
        let runs = self.layout.runs();
        let differ = self.layout.spread.iter().any(|spread| spread.is_finite() && *spread != 1.0);
        if differ && self.layout.spread.iter().any(|spread| spread.is_infinite()) {
            // If readings are rounded so coarsely that some carry no information, the residual takes few values, whose
            // median says nothing about a run, and the noise of each is known.
            return vec![1.0; runs];
        }
        let even = NoiseModel { run_scale: vec![1.0; runs], ..noise.clone() };
        let white = self.whitened(&even);
        let mut of_run: Vec<Vec<f64>> = vec![Vec::new(); runs];
        for i in 1..white.len() {
            // Whitening sets an observation without information to zero.
            let counts = white[i] != 0.0 && white[i - 1] != 0.0;
            if counts && self.layout.run[i] == self.layout.run[i - 1] {
                of_run[self.layout.run[i]]
                    .push((white[i] - white[i - 1]) * std::f64::consts::FRAC_1_SQRT_2);
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
}

/// Tunes noise to a residual beside columns of causes, many after one another.
pub struct Tuning<'a>(Search<'a>);

impl<'a> Tuning<'a> {
    /// That of noise with these outliers.
    pub fn new(of: Residual<'a>, left_out: &'a [bool]) -> Self {
        Self(Search::new(of, left_out, true))
    }

    /// The same beside `more` columns.
    pub fn beside(&self, more: &[Vec<f64>]) -> Self {
        Self(self.0.beside(more))
    }

    /// Tunes the parts of `start`, and returns the log-likelihood minus the price of the parts. Parts may be dropped;
    /// none is added. Outliers stay, so that likelihoods can be compared.
    pub fn retune(&self, start: &NoiseModel) -> (NoiseModel, f64) {
        let Self(search) = self;
        let mut noise = start.clone();
        search.shrink(&mut noise);
        search.tune(&mut noise, PART_PRICE);
        let priced =
            |noise: &NoiseModel| search.on_whole(noise) - PART_PRICE * noise.coloured.len() as f64;
        let mut value = priced(&noise);
        if search.proposes_by_views() {
            // Tuned on views, which may mislead.
            let untuned = priced(start);
            if untuned > value {
                (noise, value) = (start.clone(), untuned);
            }
        }
        (noise, value)
    }
}

#[cfg(test)]
mod tests {
    use super::{NoiseModel, Residual};
    use crate::noise::Layout;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn readings_that_say_nothing_do_not_make_a_run_quiet() {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(1);
        let residual: Vec<f64> = (0..800).map(|_| StandardNormal.sample(&mut random)).collect();
        // In the second run, three of four stretches.
        let says_nothing = |i: usize| i >= 400 && i % 80 < 60;
        let spread = (0..800).map(|i| if says_nothing(i) { f64::INFINITY } else { 1.0 }).collect();
        let layout = Layout::of_rows(2, 400, 1.0).with_spread(spread);
        let residual = Residual { layout: &layout, values: &residual, columns: &[] };
        let scales = residual.run_scales(&NoiseModel::white(2));
        assert!(scales.iter().all(|scale| (scale - 1.0).abs() < 0.2), "{scales:?}");
    }
}
