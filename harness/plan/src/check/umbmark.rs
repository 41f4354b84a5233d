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
        let umbmark = umbmark(&selection.positions()?, self.side)?;
        let angle = umbmark.angle_uncertainty().deg();
        let (name, Estimate { value, uncertainty }) = match self.figure {
            UmbmarkFigure::EMaxSyst => {
                let uncertainty = umbmark.worse().distance_uncertainty_m();
                ("E_max,syst", Estimate { value: umbmark.e_max_syst_m(), uncertainty })
            }
            UmbmarkFigure::Alpha => {
                ("alpha", Estimate { value: umbmark.alpha().deg(), uncertainty: angle })
            }
            UmbmarkFigure::Beta => {
                ("beta", Estimate { value: umbmark.beta().deg(), uncertainty: angle })
            }
        };
        let statistic = format!("{name} of {} cw and {} ccw", umbmark.cw.laps, umbmark.ccw.laps);
        Figure::in_band(value, uncertainty, self.band, statistic)
    }
}

/// Centre of gravity of the return errors of one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centre {
    /// x, in metres.
    pub x_m: f64,
    /// y, in metres.
    pub y_m: f64,
    /// Standard uncertainty of x.
    pub x_uncertainty_m: f64,
    /// Standard uncertainty of y.
    pub y_uncertainty_m: f64,
    /// Number of laps.
    pub laps: usize,
}

/// Return error of one lap, with standard uncertainties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnError {
    /// x, in metres.
    pub x_m: f64,
    /// y, in metres.
    pub y_m: f64,
    /// Standard uncertainty of x.
    pub x_uncertainty_m: f64,
    /// Standard uncertainty of y.
    pub y_uncertainty_m: f64,
}

impl Centre {
    /// The centre of these laps; `None` without laps.
    pub fn of(laps: &[ReturnError]) -> Option<Self> {
        let axis = |read: fn(&ReturnError) -> Sample| {
            mean(&laps.iter().map(read).collect::<Vec<_>>(), Together::Alone)
        };
        let x = axis(|lap| Sample { value: lap.x_m, uncertainty: lap.x_uncertainty_m })?;
        let y = axis(|lap| Sample { value: lap.y_m, uncertainty: lap.y_uncertainty_m })?;
        Some(Self {
            x_m: x.value,
            y_m: y.value,
            x_uncertainty_m: x.uncertainty,
            y_uncertainty_m: y.uncertainty,
            laps: laps.len(),
        })
    }

    /// Distance from the origin, in metres.
    pub fn distance_m(&self) -> f64 {
        self.x_m.hypot(self.y_m)
    }

    /// Standard uncertainty of the distance, to first order.
    pub fn distance_uncertainty_m(&self) -> f64 {
        let distance = self.distance_m();
        if distance > 0.0 {
            let (x, y) = (self.x_m * self.x_uncertainty_m, self.y_m * self.y_uncertainty_m);
            x.hypot(y) / distance
        } else {
            self.x_uncertainty_m.max(self.y_uncertainty_m)
        }
    }
}

/// The result of UMBmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Umbmark {
    /// Centre of the clockwise laps.
    pub cw: Centre,
    /// Centre of the counter-clockwise laps.
    pub ccw: Centre,
    side: Length,
}

impl Umbmark {
    /// The result for these centres on a square path of this side.
    pub const fn new(cw: Centre, ccw: Centre, side: Length) -> Self {
        Self { cw, ccw, side }
    }

    /// E_max,syst: the larger of the two centres' distances, in metres.
    pub fn e_max_syst_m(&self) -> f64 {
        self.worse().distance_m()
    }

    /// alpha, for small angles.
    pub fn alpha(&self) -> Angle {
        Angle::from_rad((self.cw.x_m + self.ccw.x_m) / (-4.0 * self.side.m()))
    }

    /// beta, for small angles.
    pub fn beta(&self) -> Angle {
        Angle::from_rad((self.cw.x_m - self.ccw.x_m) / (-4.0 * self.side.m()))
    }

    /// Standard uncertainty of [`Umbmark::alpha`] and of [`Umbmark::beta`].
    pub fn angle_uncertainty(&self) -> Angle {
        let both = self.cw.x_uncertainty_m.hypot(self.ccw.x_uncertainty_m);
        Angle::from_rad(both / (4.0 * self.side.m()))
    }

    fn worse(&self) -> &Centre {
        if self.cw.distance_m() > self.ccw.distance_m() { &self.cw } else { &self.ccw }
    }
}

fn umbmark(positions: &[Position], side: Length) -> Result<Umbmark, Refusal> {
    let going = |sign: f64| -> Vec<_> {
        let laps = positions.iter().filter(|position| position.direction == Some(sign));
        laps.map(|position| ReturnError {
            x_m: position.x.value,
            y_m: position.y.value,
            x_uncertainty_m: position.x.uncertainty,
            y_uncertainty_m: position.y.uncertainty,
        })
        .collect()
    };
    let (cw, ccw) = (going(-1.0), going(1.0));
    if cw.len() + ccw.len() < positions.len() {
        return Err(Refusal::Fail("laps without a direction".to_owned()));
    }
    match (Centre::of(&cw), Centre::of(&ccw)) {
        (Some(cw), Some(ccw)) => Ok(Umbmark::new(cw, ccw, side)),
        (None, _) => Err(Refusal::Unset("no cw lap".to_owned())),
        (_, None) => Err(Refusal::Unset("no ccw lap".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::{Centre, Length, ReturnError, Umbmark};

    fn centre(x_m: f64, y_m: f64) -> Centre {
        let lap = |dx, dy| ReturnError {
            x_m: x_m + dx,
            y_m: y_m + dy,
            x_uncertainty_m: 0.002,
            y_uncertainty_m: 0.002,
        };
        Centre::of(&[lap(0.003, 0.0), lap(-0.003, 0.001), lap(0.0, -0.001)]).unwrap()
    }

    #[test]
    fn by_hand() {
        // Centres (-0.12, -0.05) and (0.04, 0.03) on 4 m: alpha = -0.08 / -16, beta = -0.16 / -16.
        let umbmark = Umbmark::new(centre(-0.12, -0.05), centre(0.04, 0.03), Length::from_m(4.0));
        assert!((umbmark.e_max_syst_m() - 0.13).abs() < 1e-12);
        assert!((umbmark.alpha().rad() - 0.005).abs() < 1e-12);
        assert!((umbmark.beta().rad() - 0.01).abs() < 1e-12);
        // x scatters by 0.003, y by 0.001; three laps each, for which Student's t is 4.303.
        let ux = 0.003 / 3f64.sqrt() * 4.303 / 1.959_964;
        let uy = ux / 3.0;
        assert!((umbmark.cw.x_uncertainty_m - ux).abs() < 1e-15);
        assert!((umbmark.cw.y_uncertainty_m - uy).abs() < 1e-15);
        let expected = (0.12 * ux).hypot(0.05 * uy) / 0.13;
        assert!((umbmark.cw.distance_uncertainty_m() - expected).abs() < 1e-15);
        assert!((umbmark.angle_uncertainty().rad() - ux * 2f64.sqrt() / 16.0).abs() < 1e-15);
    }
}
