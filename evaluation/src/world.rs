//! The interface of every generated world, and the size that an effect needs for a given z.

use crate::design::{Design, Projector, norm};
use crate::truth::Truth;
use identification::dataset::Dataset;

/// Size of each effect, and the noise relative to its nominal size.
#[derive(Debug, Clone, PartialEq)]
pub struct Strength {
    /// Size of each effect, in its own unit.
    pub sizes: Vec<f64>,
    /// Factor on the nominal noise.
    pub noise: f64,
}

/// How an effect is scaled to the requested size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sizing {
    /// Its column is (nearly) proportional to its size.
    Proportional,
    /// Its column grows with its size, from the first bound to the second.
    Monotone(f64, f64),
    /// Its size is fixed; the noise is scaled to the requested z.
    Noise(f64),
    /// Its size is fixed, whatever its z: it is present or absent.
    Whole(f64),
    /// Its size is that many times the requested level: it has no z of its own.
    Level(f64),
}

/// Data of one kind with one or more undeclared effects, in the observation space of the generator:
/// the quantity on which the plain model and the effects act linearly.
pub trait World {
    /// The data set, as instruments would record it.
    fn dataset(&self, strength: &Strength) -> Dataset;
    /// Base columns and true noise, at nominal noise.
    fn design(&self) -> &Design;
    /// Contribution of the effect of that number to the observations.
    fn contribution(&self, effect: usize, size: f64) -> Vec<f64>;
    /// The part of the observations that the nominal constants predict and no column of the design holds.
    fn nominal(&self) -> Option<Vec<f64>> {
        None
    }
    /// The observations, with base, effects and noise.
    fn observed(&self, strength: &Strength) -> Vec<f64>;
    /// How each effect is scaled.
    fn sizings(&self) -> Vec<Sizing>;
    /// The causes, as a finding may spell them.
    fn truths(&self, strength: &Strength) -> Vec<Truth>;
    /// The unit of the observations, if a prediction is of the same quantity row by row; `None` if the predictor
    /// chooses the quantity.
    fn unit(&self) -> Option<&'static str>;
}

/// Steps of the bisection for a size: a factor of two each, so more than the 52 bits of a number.
const BISECTIONS: usize = 60;
/// Rounds of proportional correction; one is enough for a proportional column.
const CORRECTIONS: usize = 6;
/// Relative tolerance of z.
const Z_TOLERANCE: f64 = 1e-6;

/// The strength at which each effect of `world` alone has that z, and the actual z of the first. `None` if no size
/// reaches it (an effect that the programme cannot show).
pub fn strength_of(world: &dyn World, z: f64) -> Option<(Strength, Option<f64>)> {
    let projector = world.design().projector();
    let mut strength = Strength { sizes: Vec::new(), noise: 1.0 };
    let mut reached = None;
    for (effect, sizing) in world.sizings().into_iter().enumerate() {
        let z_of = |size: f64| world.design().z(&projector, &world.contribution(effect, size));
        let size = match sizing {
            Sizing::Proportional => proportional(z, z_of)?,
            Sizing::Monotone(low, high) => monotone(z, low, high, z_of)?,
            Sizing::Noise(size) => {
                strength.noise = z_of(size) / z;
                if strength.noise <= 0.0 || !strength.noise.is_finite() {
                    return None;
                }
                size
            }
            Sizing::Whole(size) => size,
            Sizing::Level(factor) => factor * z,
        };
        if effect == 0 && !matches!(sizing, Sizing::Level(_)) {
            reached = Some(z_of(size) / strength.noise);
        }
        strength.sizes.push(size);
    }
    Some((strength, reached))
}

/// Whether a test that knows every candidate, all its numbers but the size, and the noise takes a true cause for the
/// likeliest. `all` is `world` with every effect of its kind. `None` without a single effect with a column of its own.
pub fn known_best(world: &dyn World, strength: &Strength, all: &dyn World, z: f64) -> Option<bool> {
    let truths = world.truths(strength);
    let [truth] = truths.as_slice() else { return None };
    if matches!(world.sizings()[0], Sizing::Level(_)) {
        return None;
    }
    let projector = world.design().projector();
    let left_by_base = |column: &[f64]| {
        let mut column = world.design().whiten(column);
        projector.project(&mut column);
        column
    };
    let mut observed = world.observed(strength);
    if let Some(nominal) = world.nominal() {
        observed.iter_mut().zip(nominal).for_each(|(x, nominal)| *x -= nominal);
    }
    let left = left_by_base(&observed);
    let explained = |(effect, sizing): (usize, Sizing)| {
        let column = |size: f64| left_by_base(&all.contribution(effect, size));
        let size = match sizing {
            Sizing::Proportional => proportional(z, |size| norm(&column(size)))?,
            Sizing::Monotone(low, high) => monotone(z, low, high, |size| norm(&column(size)))?,
            Sizing::Noise(size) | Sizing::Whole(size) => size,
            Sizing::Level(_) => return None,
        };
        let column = column(size);
        let along: f64 = column.iter().zip(&left).map(|(x, left)| x * left).sum();
        let length = norm(&column);
        (length > 0.0).then(|| (effect, along.powi(2) / length.powi(2)))
    };
    let sizings = all.sizings().into_iter().enumerate();
    let (best, _) = sizings.filter_map(explained).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let any = Strength { sizes: vec![1.0; all.sizings().len()], noise: 1.0 };
    let best = &all.truths(&any)[best];
    Some(best.spellings.iter().any(|spelling| truth.spellings.contains(spelling)))
}

fn proportional(z: f64, z_of: impl Fn(f64) -> f64) -> Option<f64> {
    /// Small enough for every effect here to start in its linear range.
    const FIRST: f64 = 1e-4;
    let mut size = FIRST;
    for _ in 0..CORRECTIONS {
        let found = z_of(size);
        if found <= 0.0 || !found.is_finite() {
            return None;
        }
        size *= z / found;
        if (found / z - 1.0).abs() < Z_TOLERANCE {
            break;
        }
    }
    Some(size)
}

fn monotone(z: f64, mut low: f64, mut high: f64, z_of: impl Fn(f64) -> f64) -> Option<f64> {
    if z_of(high) < z {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = (low * high).sqrt();
        let found = z_of(middle);
        if (found / z - 1.0).abs() < Z_TOLERANCE {
            return Some(middle);
        }
        if found < z { low = middle } else { high = middle }
    }
    Some(high)
}

/// The oracle's result for a world: the true forms with known nonlinear parameters, fitted with the true noise on
/// `train` and applied to `test`.
#[derive(Debug, Clone, PartialEq)]
pub struct Oracle {
    /// Fitted factors on the true sizes; 1 is the truth.
    pub factors: Vec<f64>,
    /// Error on the test set with the plain model, and with the effects as well; in the unit of the observations, and
    /// only if the plain model has columns of the whole set.
    pub test_rmse: Option<(f64, f64)>,
}

/// The oracle's fit. `None` where the columns are not independent.
pub fn oracle(train: &dyn World, test: &dyn World, strength: &Strength) -> Option<Oracle> {
    let contributions = |world: &dyn World| -> Vec<Vec<f64>> {
        let sizes = strength.sizes.iter().enumerate();
        sizes.map(|(effect, &size)| world.contribution(effect, size)).collect()
    };
    let (effects, mut observed) = (contributions(train), train.observed(strength));
    if let Some(nominal) = train.nominal() {
        observed.iter_mut().zip(nominal).for_each(|(x, nominal)| *x -= nominal);
    }
    let design = train.design();
    let projector: Projector = design.projector();
    let factors = design.effect_coefficients(&projector, &observed, &effects)?;
    let test_rmse = if design.local.is_empty() && train.unit().is_some() {
        let plain = design.fit(&observed, &[])?;
        let full = design.fit(&observed, &effects)?;
        let (on_test, test_effects) = (test.observed(strength), contributions(test));
        let base = || test.design().base.iter();
        let before = crate::design::rmse(&on_test, base(), &plain);
        Some((before, crate::design::rmse(&on_test, base().chain(&test_effects), &full)))
    } else {
        None
    };
    Some(Oracle { factors, test_rmse })
}
