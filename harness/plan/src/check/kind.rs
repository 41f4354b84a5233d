//! What every kind of check says of itself.

use super::figure::{Figure, Refusal};
use super::selection::Selection;
use crate::band::Band;
use crate::quantity::QuantityName;

/// A kind of check. Its fields are what a plan writes below its key.
pub trait Kind {
    /// The band of the judged figure.
    fn figure_band(&self) -> Band;

    /// Unit of the judged figure; `unit` is that of the quantity, `against` that of the abscissa. `1` for shares, counts
    /// and ratios.
    fn figure_unit(&self, unit: &str, _against: &str) -> String {
        unit.to_owned()
    }

    /// The figure of these observations.
    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal>;

    /// The figure is estimated from many values, and its uncertainty says how far another run's would be from it. That of
    /// a worst value is the reading's alone, and counts are exact.
    fn estimates(&self) -> bool {
        false
    }

    /// The band of single values; `None` if the check is on a figure of all values.
    fn value_band(&self) -> Option<Band> {
        None
    }

    /// A single value outside of [`value_band`](Self::value_band) fails the check.
    fn needs_every_value(&self) -> bool {
        false
    }

    /// The step or label during which values count; all count where it is `None`.
    fn during(&self) -> Option<&str> {
        None
    }

    /// The tag on the abscissa, if any.
    fn against(&self) -> Option<&str> {
        None
    }

    /// The key and the name of the second quantity, if any.
    fn second_quantity(&self) -> Option<(&'static str, &QuantityName)> {
        None
    }

    /// The quantities are coordinates on the floor, in metres.
    fn is_on_the_floor(&self) -> bool {
        false
    }
}
