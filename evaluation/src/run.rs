//! One case: generated, identified, predicted and compared with its truth.

use crate::catalogue::{Case, Purpose};
use crate::noise::Noise;
use crate::quantity::Quantity;
use crate::random::{MASTER_TEST, MASTER_TRAIN};
use crate::truth::Truth;
use crate::world::{Strength, World, known_best, oracle, strength_of};
use identification::dataset::Dataset;
use identification::finding::{Finding, Prediction, Verdict};
use serde::{Deserialize, Serialize};

/// The object of the evaluation: the identification, or a stand-in for it.
pub trait Identifier: Sync {
    /// The resulting model, which `predict` takes.
    type Model;

    /// Identifies a set from the plain model of its kind.
    ///
    /// # Errors
    ///
    /// A message, if the data are refused.
    fn identify(
        &self,
        dataset: &Dataset,
        max_effects: Option<usize>,
    ) -> Result<(Finding, Self::Model), String>;

    /// Applies a model.
    ///
    /// # Errors
    ///
    /// A message, if the data are refused.
    fn predict(&self, dataset: &Dataset, model: &Self::Model) -> Result<Prediction, String>;
}

/// Outcome of a case.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the case.
    pub case: String,
    /// Group of the tables.
    pub group: String,
    /// Undeclared effect, or class of noise.
    pub effect: String,
    /// Family of the effect; `null` where there is none.
    pub family: String,
    /// Requested size; 0 for a null.
    pub z: f64,
    /// Actual size; absent for effects without a size.
    pub z_reached: Option<f64>,
    /// Rows of the set.
    pub rows: usize,
    /// Why there is no finding.
    pub failed: Option<String>,
    /// The verdict.
    pub verdict: Option<Verdict>,
    /// An effect was found, or structure was reported as left.
    pub detected: bool,
    /// The verdict is `Explained`.
    pub explained: bool,
    /// The first effect is a true one.
    pub first: bool,
    /// A test that knows the candidates and the noise takes a true cause for the likeliest.
    pub ceiling: Option<bool>,
    /// Every true cause is an effect or a rival of one.
    pub within: bool,
    /// Number of rivals of the first effect.
    pub rivals: Option<usize>,
    /// An effect was reported in nothing but noise.
    pub false_alarm: bool,
    /// Effects that were added, `term: drivers`.
    pub found: Vec<String>,
    /// Gain on fresh data over the oracle's.
    pub gain_ratio: Option<f64>,
    /// Errors on fresh data behind that gain: with the plain model, with the found one and at best, in the unit of the
    /// prediction.
    pub errors: Vec<[f64; 3]>,
    /// Whether the 95 % interval of the true parameter holds it.
    pub covered: Option<bool>,
    /// Time that `identify` took, s.
    pub seconds: f64,
}

/// Generates and scores a case. `now` is a clock in seconds.
pub fn run<I: Identifier>(case: &Case, identifier: &I, now: &dyn Fn() -> f64) -> Outcome {
    let mut outcome = Outcome {
        case: case.name(),
        group: case.group.into(),
        effect: case.effect.clone(),
        family: case.family.into(),
        ..Outcome::default()
    };
    let train = case.world(MASTER_TRAIN);
    let Some(strength) = strength(case, train.as_ref(), &mut outcome) else {
        outcome.failed = Some("no size of the effect has that z".into());
        return outcome;
    };
    let dataset = train.dataset(&strength);
    outcome.rows = dataset.rows();
    let start = now();
    let identified = identifier.identify(&dataset, None);
    outcome.seconds = now() - start;
    let (finding, model) = match identified {
        Ok(identified) => identified,
        Err(error) => {
            outcome.failed = Some(error);
            return outcome;
        }
    };
    compare(&mut outcome, &finding, &train.truths(&strength), case.purpose);
    if let Purpose::Effect(z) = case.purpose {
        let all = case.with_every_effect(MASTER_TRAIN);
        outcome.ceiling = known_best(train.as_ref(), &strength, all.as_ref(), z);
    }
    if matches!(case.purpose, Purpose::Effect(_)) && case.family != "noise" {
        let test = case.world(MASTER_TEST);
        let worlds = Worlds { train: train.as_ref(), test: test.as_ref(), strength: &strength };
        outcome.errors = worlds.errors(identifier, &dataset, &model).unwrap_or_default();
        outcome.gain_ratio = ratio(&outcome.errors);
    }
    outcome
}

/// The strength of the effects of a case, and their z in `outcome`.
fn strength(case: &Case, world: &dyn World, outcome: &mut Outcome) -> Option<Strength> {
    match case.purpose {
        Purpose::Null(_) => Some(Strength { sizes: Vec::new(), noise: 1.0 }),
        Purpose::Effect(z) | Purpose::Timing(z) => {
            outcome.z = z;
            let (strength, reached) = strength_of(world, z)?;
            outcome.z_reached = reached;
            Some(strength)
        }
    }
}

/// The training set of a case, for inspection.
pub fn dataset(case: &Case) -> Option<Dataset> {
    let world = case.world(MASTER_TRAIN);
    let strength = strength(case, world.as_ref(), &mut Outcome::default())?;
    Some(Dataset { name: case.name(), ..world.dataset(&strength) })
}

fn compare(outcome: &mut Outcome, finding: &Finding, truths: &[Truth], purpose: Purpose) {
    outcome.verdict = Some(finding.verdict);
    outcome.explained = finding.verdict == Verdict::Explained;
    outcome.detected = outcome.explained
        || !finding.effects.is_empty()
        || (finding.verdict == Verdict::StructureLeft && !finding.left.is_empty());
    let spell = |effect: &identification::finding::Effect| {
        format!("{}: {}", effect.term, effect.drivers.join(" + "))
    };
    outcome.found = finding.effects.iter().map(spell).collect();
    outcome.rivals = finding.effects.first().map(|effect| effect.rivals.len());
    if let Purpose::Null(noise) = purpose {
        outcome.false_alarm = finding.effects.iter().any(|effect| !is_true_of(noise, &effect.term));
        return;
    }
    let first = finding.effects.first();
    outcome.first = first.is_some_and(|effect| truths.iter().any(|truth| truth.is_effect(effect)));
    outcome.within =
        truths.iter().all(|truth| finding.effects.iter().any(|effect| truth.is_within(effect)));
    if let [truth] = truths {
        let named = finding.effects.iter().find(|effect| truth.is_effect(effect));
        outcome.covered = named.and_then(|effect| truth.is_covered_by(&effect.parameters));
    }
}

/// Whether an effect of that term is not a false alarm in that noise: coloured noise may be reported as noise, and a
/// coarse readout as quantisation.
fn is_true_of(noise: Noise, term: &str) -> bool {
    match noise {
        Noise::Autoregressive(_) | Noise::RandomWalk | Noise::Flicker | Noise::PerRun => {
            term == "noise"
        }
        Noise::Quantised(_) => term == "quantisation",
        Noise::White | Noise::Student | Noise::Outliers | Noise::Slip => false,
    }
}

struct Worlds<'a> {
    train: &'a dyn World,
    test: &'a dyn World,
    strength: &'a Strength,
}

impl Worlds<'_> {
    /// Errors on the fresh set of each predicted quantity: with the plain model, with the resulting one and the oracle's.
    fn errors<I: Identifier>(
        &self,
        identifier: &I,
        dataset: &Dataset,
        model: &I::Model,
    ) -> Option<Vec<[f64; 3]>> {
        if self.train.unit().is_none()
            && matches!(self.train.sizings()[0], crate::world::Sizing::Level(_))
        {
            return None;
        }
        let oracle = oracle(self.train, self.test, self.strength)?;
        let errors = |dataset: &Dataset, model: &I::Model| -> Option<Vec<Error>> {
            Some(Error::all(identifier.predict(dataset, model).ok()?))
        };
        let test = self.test.dataset(self.strength);
        let after = errors(&test, model)?;
        if let (Some(own), Some((before, best))) = (self.train.unit(), oracle.test_rmse) {
            let own = Quantity::parse(own)?;
            let (after, si) = after.iter().find_map(|error| {
                let theirs = Quantity::parse(&error.unit)?;
                (theirs.powers == own.powers).then_some((error.rmse, theirs.si))
            })?;
            return Some(vec![[before, after * si / own.si, best]]);
        }
        // The predictor chooses what it predicts. Its plain model gives the errors before. The oracle's errors after
        // are those of its plain model on the same data, with only the part of the effect that the oracle's estimate
        // misses.
        let plain = |dataset: &Dataset| identifier.identify(dataset, Some(0)).ok();
        let sizes = self.strength.sizes.iter().zip(&oracle.factors);
        let missed = Strength {
            sizes: sizes.map(|(size, factor)| size * (1.0 - factor)).collect(),
            noise: self.strength.noise,
        };
        let (_, model_before) = plain(dataset)?;
        let (_, model_best) = plain(&self.train.dataset(&missed))?;
        let before = errors(&test, &model_before)?;
        let best = errors(&self.test.dataset(&missed), &model_best)?;
        let of = |errors: &[Error], quantity: &str| {
            errors.iter().find(|error| error.quantity == quantity).map(|error| error.rmse)
        };
        let of_quantity = |error: &Error| {
            let name = error.quantity.as_str();
            Some([of(&before, name)?, error.rmse, of(&best, name)?])
        };
        Some(after.iter().filter_map(of_quantity).collect())
    }
}

/// Error of one predicted quantity.
struct Error {
    quantity: String,
    unit: String,
    rmse: f64,
}

impl Error {
    fn all(prediction: Prediction) -> Vec<Self> {
        let first = Self {
            quantity: prediction.quantity,
            unit: prediction.unit,
            rmse: prediction.rmse.after,
        };
        let also = prediction.also.into_iter();
        let also = also.map(|p| Self { quantity: p.quantity, unit: p.unit, rmse: p.rmse.after });
        std::iter::once(first).chain(also).collect()
    }
}

/// Reduction of the squared errors over the oracle's, from the errors before, after and at best of each quantity, each
/// squared error in units of the best.
fn ratio(errors: &[[f64; 3]]) -> Option<f64> {
    let (mut gained, mut possible) = (0.0, 0.0);
    for &[before, after, best] in errors.iter().filter(|[.., best]| *best > 0.0) {
        gained += (before * before - after * after) / (best * best);
        possible += (before * before - best * best) / (best * best);
    }
    (possible > 0.0).then(|| gained / possible)
}
