//! `umbmark_within`: UMBmark (Borenstein and Feng 1996) for a base without a wheelbase: the centres of gravity of the return errors of
//! both directions, E_max,syst, and alpha and beta as effective parameters.
//!
//! The errors are absolute minus dead-reckoned positions after a lap of a square path of side L. For small
//! angles alpha = (x_cw + x_ccw) / (-4 L) is the effective error of each corner, and
//! beta = (x_cw - x_ccw) / (-4 L) the effective change of heading along one side.

use super::figure::{Figure, Refusal};
use super::jackknife::Together;
use super::kind::{Facts, Kind, UnitOf};
use super::moments::{Estimate, mean};
use super::selection::{Position, Sample, Selection};
use crate::band::Band;
use crate::number;
use crate::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::units::{Angle, Length};

/// A figure of UMBmark lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct UmbmarkWithin {
    /// The figure that is judged.
    pub figure: UmbmarkFigure,
    /// The quantity that is y, of the same unit.
    pub y: QuantityName,
    /// Side of the square path.
    #[serde(rename = "side_m", default = "paper_side", with = "number::PathLength")]
    pub side: Length,
    /// The band.
    pub band: Band,
}

/// Side of the paper's square path: 4 m (section 4.1), which is UMBmark's too.
pub const PAPER_SIDE: Length = Length::from_m(4.0);

fn paper_side() -> Length {
    PAPER_SIDE
}

/// The figures of UMBmark that make sense without a wheelbase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UmbmarkFigure {
    /// E_max,syst: the larger distance of the two directions' centres of gravity from the origin, m.
    EMaxSyst,
    /// alpha: the effective error of each corner's turn, deg.
    Alpha,
    /// beta: the effective change of heading along one side, deg.
    Beta,
}

impl Kind for UmbmarkWithin {
    fn facts(&self) -> Facts<'_> {
        let unit = match self.figure {
            UmbmarkFigure::EMaxSyst => UnitOf::Quantity,
            UmbmarkFigure::Alpha | UmbmarkFigure::Beta => UnitOf::Fixed("deg"),
        };
        Facts {
            unit,
            estimates: true,
            second_quantity: Some(("y", &self.y)),
            is_on_the_floor: true,
            ..Facts::of(self.band)
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let (cw, ccw) = centres(&selection.positions()?)?;
        let Estimate { value, uncertainty } = self.figure.of(&cw, &ccw, self.side);
        let name = match self.figure {
            UmbmarkFigure::EMaxSyst => "E_max,syst",
            UmbmarkFigure::Alpha => "alpha",
            UmbmarkFigure::Beta => "beta",
        };
        let statistic = format!("{name} of {} cw and {} ccw", cw.laps, ccw.laps);
        Figure::in_band(value, uncertainty, self.band, statistic)
    }
}

impl UmbmarkFigure {
    /// The figure of these centres on a square path of this side: alpha and beta for small angles.
    fn of(self, cw: &Centre, ccw: &Centre, side: Length) -> Estimate {
        let turn = match self {
            Self::EMaxSyst => {
                let (cw, ccw) = (cw.distance(), ccw.distance());
                return if cw.value > ccw.value { cw } else { ccw };
            }
            Self::Alpha => cw.x.value + ccw.x.value,
            Self::Beta => cw.x.value - ccw.x.value,
        };
        let both = cw.x.uncertainty.hypot(ccw.x.uncertainty);
        let deg = |metres: f64| Angle::from_rad(metres / (4.0 * side.m())).deg();
        Estimate { value: deg(-turn), uncertainty: deg(both) }
    }
}

/// Centre of gravity of the return errors of one direction, m.
#[derive(Debug)]
struct Centre {
    x: Estimate,
    y: Estimate,
    laps: usize,
}

impl Centre {
    /// The centre of these laps; `None` without laps.
    fn of(laps: &[Position]) -> Option<Self> {
        let axis = |read: fn(&Position) -> Sample| {
            mean(&laps.iter().map(read).collect::<Vec<_>>(), Together::Alone)
        };
        Some(Self { x: axis(|lap| lap.x)?, y: axis(|lap| lap.y)?, laps: laps.len() })
    }

    /// Distance from the origin, with its uncertainty to first order.
    fn distance(&self) -> Estimate {
        let Self { x, y, .. } = self;
        let value = x.value.hypot(y.value);
        let uncertainty = if value > 0.0 {
            (x.value * x.uncertainty).hypot(y.value * y.uncertainty) / value
        } else {
            x.uncertainty.max(y.uncertainty)
        };
        Estimate { value, uncertainty }
    }
}

/// The centres of the clockwise and of the counter-clockwise laps.
fn centres(positions: &[Position]) -> Result<(Centre, Centre), Refusal> {
    let going = |sign: f64| -> Vec<_> {
        positions.iter().filter(|lap| lap.direction == Some(sign)).copied().collect()
    };
    let (cw, ccw) = (going(-1.0), going(1.0));
    if cw.len() + ccw.len() < positions.len() {
        return Err(Refusal::Fail("laps without a direction".to_owned()));
    }
    match (Centre::of(&cw), Centre::of(&ccw)) {
        (Some(cw), Some(ccw)) => Ok((cw, ccw)),
        (None, _) => Err(Refusal::Unset("no cw lap".to_owned())),
        (_, None) => Err(Refusal::Unset("no ccw lap".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::{Centre, Length, Position, Sample, UmbmarkFigure};

    fn centre(x_m: f64, y_m: f64) -> Centre {
        let sample = |value| Sample { value, uncertainty: 0.002 };
        let lap = |dx, dy| Position { x: sample(x_m + dx), y: sample(y_m + dy), direction: None };
        Centre::of(&[lap(0.003, 0.0), lap(-0.003, 0.001), lap(0.0, -0.001)]).unwrap()
    }

    #[test]
    fn by_hand() {
        // Centres (-0.12, -0.05) and (0.04, 0.03) on 4 m: alpha = -0.08 / -16, beta = -0.16 / -16.
        let (cw, ccw) = (centre(-0.12, -0.05), centre(0.04, 0.03));
        let of = |figure: UmbmarkFigure| figure.of(&cw, &ccw, Length::from_m(4.0));
        let e_max_syst = of(UmbmarkFigure::EMaxSyst);
        let (alpha, beta) = (of(UmbmarkFigure::Alpha), of(UmbmarkFigure::Beta));
        assert!((e_max_syst.value - 0.13).abs() < 1e-12);
        assert!((alpha.value.to_radians() - 0.005).abs() < 1e-12);
        assert!((beta.value.to_radians() - 0.01).abs() < 1e-12);
        // x scatters by 0.003, y by 0.001; three laps each, for which Student's t is 4.303.
        let ux = 0.003 / 3f64.sqrt() * 4.303 / 1.959_964;
        let uy = ux / 3.0;
        assert!((cw.x.uncertainty - ux).abs() < 1e-15);
        assert!((cw.y.uncertainty - uy).abs() < 1e-15);
        let expected = (0.12 * ux).hypot(0.05 * uy) / 0.13;
        assert!((e_max_syst.uncertainty - expected).abs() < 1e-15);
        for angle in [alpha, beta] {
            assert!((angle.uncertainty.to_radians() - ux * 2f64.sqrt() / 16.0).abs() < 1e-15);
        }
    }
}
