//! What every kind of check says of itself.

use super::figure::{Figure, Refusal};
use super::selection::Selection;
use crate::band::Band;
use crate::quantity::QuantityName;

/// A kind of check. Its fields are what a plan writes below its key.
pub trait Kind {
    /// What can be said without observations.
    fn facts(&self) -> Facts<'_>;

    /// The figure of these observations.
    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal>;
}

/// What a check says of its figure and of the values that this is formed from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts<'a> {
    /// The band of the judged figure.
    pub figure_band: Band,
    /// The unit of the judged figure.
    pub unit: UnitOf,
    /// The figure is estimated from many values, and its uncertainty says how far another run's would be from it. That of
    /// a worst value is the reading's alone, and counts are exact.
    pub estimates: bool,
    /// The band of single values; `None` if the check is on a figure of all values.
    pub value_band: Option<Band>,
    /// A single value outside of [`value_band`](Self::value_band) fails the check.
    pub needs_every_value: bool,
    /// The step or label during which values count; all count where it is `None`.
    pub during: Option<&'a str>,
    /// The tag on the abscissa, if any.
    pub against: Option<&'a str>,
    /// The key and the name of the second quantity, if any.
    pub second_quantity: Option<(&'static str, &'a QuantityName)>,
    /// The quantities are coordinates on the floor, in metres.
    pub is_on_the_floor: bool,
}

/// The unit of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitOf {
    /// That of the quantity.
    Quantity,
    /// That of the quantity over that of the abscissa.
    Slope,
    /// This one; `1` for shares, counts and ratios.
    Fixed(&'static str),
}

impl Facts<'_> {
    /// Those of a figure in this band, in the unit of the quantity, that is no estimate.
    pub(super) const fn of(figure_band: Band) -> Self {
        Self {
            figure_band,
            unit: UnitOf::Quantity,
            estimates: false,
            value_band: None,
            needs_every_value: false,
            during: None,
            against: None,
            second_quantity: None,
            is_on_the_floor: false,
        }
    }

    /// Unit of the judged figure; `unit` is that of the quantity, `against` that of the abscissa.
    pub fn figure_unit(&self, unit: &str, against: &str) -> String {
        match self.unit {
            UnitOf::Slope if against != "1" => format!("{unit}/{against}"),
            UnitOf::Quantity | UnitOf::Slope => unit.to_owned(),
            UnitOf::Fixed(unit) => unit.to_owned(),
        }
    }
}
