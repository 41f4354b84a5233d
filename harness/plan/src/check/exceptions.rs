//! `all_but_within` and `all_but_in_square`: the number of exceptions.

use super::figure::{COVERAGE, Figure, Refusal, graded, is_clear, too_few};
use super::kind::{Facts, Kind, UnitOf};
use super::selection::{Position, Sample, Selection};
use crate::band::Band;
use crate::number;
use crate::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::units::Length;

/// All values but so many lie in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct AllButWithin {
    /// How many may lie outside.
    pub count: u32,
    /// The band.
    pub band: Band,
}

impl Kind for AllButWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("1"),
            value_band: Some(self.band),
            ..Facts::of(Band::at_most(f64::from(self.count)))
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let clear = |s: &Sample, coverage| is_clear(s.value, s.uncertainty, self.band, coverage);
        exceptions(&selection.samples(), self.count, clear, &format!("outside {}", self.band))
    }
}

/// All positions but so many lie in a square along the axes.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct AllButInSquare {
    /// How many may lie outside.
    pub count: u32,
    /// Length of a side.
    #[serde(rename = "side_m", with = "number::PathLength")]
    pub side: Length,
    /// The quantity that is y, of the same unit.
    pub y: QuantityName,
    /// Where the square's centre is. The paper does not say where its 10 x 10 cm square lies; the
    /// start of the lap, which is the default, is the strictest reading.
    #[serde(rename = "centre_m", default)]
    pub centre: [f64; 2],
}

impl Kind for AllButInSquare {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("1"),
            second_quantity: Some(("y", &self.y)),
            is_on_the_floor: true,
            ..Facts::of(Band::at_most(f64::from(self.count)))
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let [centre_x, centre_y] = self.centre;
        let half = Band::at_most(self.side.m() / 2.0);
        let inside = |position: &Position, coverage: f64| {
            let (x, y) = (position.x, position.y);
            is_clear((x.value - centre_x).abs(), x.uncertainty, half, coverage)
                && is_clear((y.value - centre_y).abs(), y.uncertainty, half, coverage)
        };
        let what = format!("outside a square of {} m", self.side.m());
        exceptions(&selection.positions()?, self.count, inside, &what)
    }
}

/// The number of items outside. `is_inside` takes an item and the number of standard uncertainties by which it must be
/// inside.
fn exceptions<T>(
    items: &[T],
    most: u32,
    is_inside: impl Fn(&T, f64) -> bool,
    what: &str,
) -> Result<Figure, Refusal> {
    let count = items.len();
    if count <= most as usize {
        // Otherwise the check would pass with no item inside.
        return Err(Refusal::Unset(too_few(count, most as usize + 1)));
    }
    let outside =
        |coverage: f64| items.iter().filter(|item| !is_inside(item, coverage)).count() as f64;
    let (value, most) = (outside(0.0), f64::from(most));
    Ok(Figure {
        value,
        uncertainty: (outside(1.0) - outside(-1.0)) / 2.0,
        verdict: graded(value <= most, outside(COVERAGE) <= most),
        statistic: format!("number of {count} {what}"),
    })
}
