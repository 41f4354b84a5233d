//! How well a model predicts held-out runs, in the quantities that matter to its user: the position and the heading at
//! the end of a path, the rate of each axis.

mod alike;
mod choice;
mod errors;
mod held_out;
mod whiteness;

use crate::finding::HeldOut;
use crate::fit::Data;
use crate::model::Shape;
use crate::noise::NoiseModel;
use crate::problem::{Aggregate, DisplayUnit, Path};
pub(crate) use alike::{Goes, goes_with};
pub(crate) use choice::{Standing, best, confirmed, margin};
pub(crate) use errors::Errors;
use held_out::path_errors;
pub(crate) use held_out::{Holding, add_driven};
pub use whiteness::{WHITENESS_LEVEL, Whiteness};
pub(crate) use whiteness::{of_innovations, stretches};

/// Held-out errors of one quantity.
#[derive(Debug, Clone)]
pub struct Metric {
    /// Which quantity.
    pub name: String,
    /// Its unit.
    pub unit: DisplayUnit,
    /// The errors, SI.
    pub errors: Errors,
}

/// Judges models of one block.
#[derive(Clone, Copy)]
pub struct Judge<'a> {
    /// The readings before any correction.
    pub data: Data<'a>,
    /// The path, for a driven robot.
    pub path: Option<&'a Path>,
    /// How runs are held out.
    pub holding: Holding,
}

impl Judge<'_> {
    /// Errors of `terms` in each metric of the block, on held-out runs.
    pub fn judge(&self, terms: &[Shape], noise: &NoiseModel) -> Vec<Metric> {
        let block = self.data.block;
        if block.aggregate == Aggregate::Pose
            && let Some(path) = self.path
            && let Some((positions, headings)) = path_errors(path, self.data, terms, noise)
        {
            return vec![
                Metric {
                    name: "final_position".to_owned(),
                    unit: crate::dataset::Unit::Metre.into(),
                    errors: positions,
                },
                Metric {
                    name: "final_heading".to_owned(),
                    unit: crate::dataset::Unit::Degree.into(),
                    errors: headings,
                },
            ];
        }
        vec![Metric {
            name: block.label.clone(),
            unit: block.unit.clone(),
            errors: self.data.held_out(terms, noise, self.holding),
        }]
    }

    /// The error from one reading to the next: the most informative one if the residual is noise.
    pub fn innovation(&self, terms: &[Shape], noise: &NoiseModel) -> Metric {
        Metric {
            name: "innovation".to_owned(),
            unit: DisplayUnit::one(),
            errors: self.data.innovations_held_out(terms, noise),
        }
    }
}

impl Metric {
    /// Root mean square of the errors, in its unit.
    pub fn value(&self) -> f64 {
        self.errors.rmse() / self.unit.si
    }

    /// Both errors in the form of the contract, with `before` as the error before. The quantity is named if there are
    /// several.
    pub fn held_out(&self, before: &Self, is_one_of_several: bool, seed: u64) -> HeldOut {
        let si = self.unit.si;
        HeldOut {
            metric: "rmse".to_owned(),
            quantity: is_one_of_several.then(|| self.name.clone()),
            unit: self.unit.text.clone(),
            before: before.value(),
            after: self.value(),
            ci95: self.errors.interval(seed).map(|value| value / si),
            folds: self.errors.folds,
        }
    }
}
