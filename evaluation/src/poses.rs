//! Worlds whose observations are poses: x, y and heading, on which effects act in proportion to their sizes, to first order.

use crate::design::Design;
use crate::noise::Drawn;
use crate::truth::{TrueValue, Truth};
use crate::world::{Sizing, Strength, World};
use identification::dataset::Dataset;

/// A cause, in the words of a finding.
pub struct Cause {
    /// Name in the tables.
    pub name: &'static str,
    /// Spellings; see [`crate::truth`].
    pub spellings: &'static [&'static str],
    /// Unit of its size, where any form of it must have that parameter.
    pub unit: Option<&'static str>,
}

/// A world of poses.
pub trait Poses {
    /// See [`World::dataset`].
    fn dataset(&self, strength: &Strength) -> Dataset;
    /// See [`World::design`].
    fn design(&self) -> &Design;
    /// True poses (x, y, unwrapped heading), concatenated, with effects of those sizes.
    fn poses(&self, sizes: &[(usize, f64)]) -> Vec<f64>;
    /// The noise of the observations.
    fn noise(&self) -> &Drawn;
    /// The cause of each effect.
    fn causes(&self) -> Vec<Cause>;
}

impl<T: Poses> World for T {
    fn dataset(&self, strength: &Strength) -> Dataset {
        Poses::dataset(self, strength)
    }

    fn design(&self) -> &Design {
        Poses::design(self)
    }

    fn contribution(&self, effect: usize, size: f64) -> Vec<f64> {
        let (with, without) = (self.poses(&[(effect, size)]), self.poses(&[]));
        with.iter().zip(without).map(|(with, without)| with - without).collect()
    }

    fn nominal(&self) -> Option<Vec<f64>> {
        Some(self.poses(&[]))
    }

    fn observed(&self, strength: &Strength) -> Vec<f64> {
        let sizes: Vec<(usize, f64)> = strength.sizes.iter().copied().enumerate().collect();
        let poses = self.poses(&sizes).into_iter().zip(&self.noise().values);
        poses.map(|(pose, noise)| pose + strength.noise * noise).collect()
    }

    fn sizings(&self) -> Vec<Sizing> {
        vec![Sizing::Proportional; self.causes().len()]
    }

    fn truths(&self, strength: &Strength) -> Vec<Truth> {
        let truth = |(cause, &size): (Cause, &f64)| Truth {
            effect: cause.name.into(),
            spellings: cause.spellings.iter().map(|&spelling| spelling.to_owned()).collect(),
            value: cause.unit.map(|unit| TrueValue { value: size, unit, names: &[] }),
        };
        self.causes().into_iter().zip(&strength.sizes).map(truth).collect()
    }

    fn unit(&self) -> Option<&'static str> {
        None
    }
}
