//! `slope_within`, `intercept_within` and `correlation_within`: least squares against a tag.

use super::figure::{Figure, Refusal};
use super::jackknife::{self, widening};
use super::kind::{Facts, Kind, UnitOf};
use super::selection::{Point, Selection};
use crate::band::Band;
use schemars::JsonSchema;
use serde::Deserialize;

/// The slope of the least-squares line lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct SlopeWithin {
    /// The tag that is the abscissa.
    pub against: String,
    /// The band.
    pub band: Band,
}

impl Kind for SlopeWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Slope,
            estimates: true,
            against: Some(&self.against),
            ..Facts::of(self.band)
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let points = selection.points(&self.against)?;
        let line = fit(&points, 2)?;
        let uncertainty = line.slope_uncertainty * of_few(&line, points.len());
        let statistic = format!("slope of {} points", points.len());
        Figure::in_band(line.slope, uncertainty, self.band, statistic)
    }
}

/// The ordinate of the least-squares line at zero lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct InterceptWithin {
    /// The tag that is the abscissa.
    pub against: String,
    /// The band.
    pub band: Band,
}

impl Kind for InterceptWithin {
    fn facts(&self) -> Facts<'_> {
        Facts { estimates: true, against: Some(&self.against), ..Facts::of(self.band) }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let points = selection.points(&self.against)?;
        let line = fit(&points, 2)?;
        let uncertainty = line.intercept_uncertainty * of_few(&line, points.len());
        let statistic = format!("intercept of {} points", points.len());
        Figure::in_band(line.intercept, uncertainty, self.band, statistic)
    }
}

/// Pearson's correlation lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct CorrelationWithin {
    /// The tag to correlate with.
    pub against: String,
    /// The band.
    pub band: Band,
}

impl Kind for CorrelationWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("1"),
            estimates: true,
            against: Some(&self.against),
            ..Facts::of(self.band)
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let points = selection.points_in_time(&self.against)?;
        let together = selection.together();
        let count = points.len();
        let r = fit(&points, CORRELATION_POINTS_MIN)?.correlation;
        if r.is_nan() {
            return Err(Refusal::Unset(format!("{count} points of the same value")));
        }
        let without = jackknife::uncertainty(count, together, |left_out| {
            let rest: Vec<Point> = jackknife::rest(&points, left_out).copied().collect();
            fit(&rest, 2).ok().map(|line| line.correlation).filter(|r| !r.is_nan())
        });
        // The correlation may be undefined without some block; its uncertainty is then unknown.
        let uncertainty = without.unwrap_or(1.0);
        let band = self.band.of_figures_within(-1.0, 1.0);
        Figure::in_band(r, uncertainty, band, format!("correlation of {count} points"))
    }
}

/// A straight line through points, by ordinary least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Slope.
    pub slope: f64,
    /// Ordinate at abscissa zero.
    pub intercept: f64,
    /// Standard uncertainty of the slope.
    pub slope_uncertainty: f64,
    /// Standard uncertainty of the intercept.
    pub intercept_uncertainty: f64,
    /// Pearson's correlation; NaN if all ordinates are equal.
    pub correlation: f64,
    /// Standard deviation of the points about the line; zero for two points.
    pub scatter: f64,
    /// Root mean square of the points' own uncertainties.
    pub own: f64,
}

impl Line {
    /// Fits `(abscissa, ordinate, standard uncertainty of the ordinate)`. All points get the same variance: that of the
    /// scatter about the line, which already includes the points' own uncertainties, or the mean square of those if
    /// larger. `None` for fewer than two different abscissae, or if a number is not finite.
    pub fn fit(points: &[(f64, f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let centre_x = points.iter().map(|p| p.0).sum::<f64>() / count;
        let centre_y = points.iter().map(|p| p.1).sum::<f64>() / count;
        let sum = |term: &dyn Fn(f64, f64) -> f64| {
            points.iter().map(|p| term(p.0 - centre_x, p.1 - centre_y)).sum::<f64>()
        };
        let (sxx, sxy, syy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
        let slope = sxy / sxx;
        let intercept = centre_y - slope * centre_x;
        let residual = sum(&|x, y| (y - slope * x).powi(2));
        let scatter = if points.len() > 2 { residual / (count - 2.0) } else { 0.0 };
        let own = points.iter().map(|p| p.2.powi(2)).sum::<f64>() / count;
        let variance = scatter.max(own);
        let line = Self {
            slope,
            intercept,
            slope_uncertainty: (variance / sxx).sqrt(),
            intercept_uncertainty: (variance * (1.0 / count + centre_x.powi(2) / sxx)).sqrt(),
            correlation: (sxy / (sxx * syy).sqrt()).clamp(-1.0, 1.0),
            scatter: scatter.sqrt(),
            own: own.sqrt(),
        };
        let figures = [slope, intercept, line.slope_uncertainty, line.intercept_uncertainty];
        (sxx > 0.0 && figures.iter().all(|figure| figure.is_finite())).then_some(line)
    }
}

/// The factor by which few points increase the uncertainties of their line, if those come from the scatter.
fn of_few(line: &Line, count: usize) -> f64 {
    if line.scatter == 0.0 {
        return 1.0;
    }
    let (scatter, own) = (line.scatter.powi(2), line.own.powi(2));
    let wide = scatter * widening(count - 2).powi(2);
    (wide.max(own) / scatter.max(own)).sqrt()
}

/// Fewest points for a correlation: two are always on a line.
const CORRELATION_POINTS_MIN: usize = 3;

fn fit(points: &[Point], least: usize) -> Result<Line, Refusal> {
    let count = points.len();
    if count < least {
        return Err(Refusal::Unset(format!("{count} points, at least {least} are needed")));
    }
    let points: Vec<_> =
        points.iter().map(|p| (p.at, p.sample.value, p.sample.uncertainty)).collect();
    Line::fit(&points).ok_or_else(|| Refusal::Unset(format!("{count} points at one place")))
}

#[cfg(test)]
mod tests {
    use super::Line;
    use proptest::prelude::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn by_hand() {
        // x 1 2 3 4, y 2 4 5 8: Sxx 5, Sxy 9.5, slope 1.9, intercept 0; residuals 0.1 0.2 -0.7 0.4,
        // their squares 0.70, s^2 0.35; u(slope) sqrt(0.35/5), u(intercept) sqrt(0.35 (1/4 + 6.25/5)).
        let line = Line::fit(&[(1.0, 2.0, 0.0), (2.0, 4.0, 0.0), (3.0, 5.0, 0.0), (4.0, 8.0, 0.0)])
            .unwrap();
        assert!(close(line.slope, 1.9) && close(line.intercept, 0.0));
        assert!(close(line.slope_uncertainty, 0.07f64.sqrt()));
        assert!(close(line.intercept_uncertainty, 0.525f64.sqrt()));
        assert!(close(line.scatter, 0.35f64.sqrt()));
        assert!(close(line.correlation, 9.5 / (5.0f64 * 18.75).sqrt()));
    }

    #[test]
    fn readings_worse_than_their_scatter_decide() {
        // Exactly on a line, each reading +-0.2: u(slope) = 0.2 / sqrt(5).
        let line = Line::fit(&[1.0, 2.0, 3.0, 4.0].map(|x| (x, 3.0 - x, 0.2))).unwrap();
        assert!(close(line.slope, -1.0));
        assert!(close(line.slope_uncertainty, 0.2 / 5f64.sqrt()));
    }

    #[test]
    fn no_line_through_one_place() {
        assert_eq!(Line::fit(&[]), None);
        assert_eq!(Line::fit(&[(1.0, 2.0, 0.1)]), None);
        assert_eq!(Line::fit(&[(1.0, 2.0, 0.1), (1.0, 3.0, 0.1)]), None);
        assert_eq!(Line::fit(&[(1.0, f64::NAN, 0.1), (2.0, 3.0, 0.1)]), None);
    }

    proptest! {
        #[test]
        fn a_line_is_found_again(
            slope in -10.0f64..10.0, intercept in -100.0f64..100.0,
            xs in prop::collection::btree_set(-1000i32..1000, 2..40),
        ) {
            let points: Vec<_> = xs.iter()
                .map(|&x| (f64::from(x), intercept + slope * f64::from(x), 0.0)).collect();
            let line = Line::fit(&points).unwrap();
            prop_assert!((line.slope - slope).abs() < 1e-7);
            prop_assert!((line.intercept - intercept).abs() < 1e-5);
        }

        #[test]
        fn moving_the_origin_leaves_the_slope(
            ys in prop::collection::vec(-1.0f64..1.0, 3..20), shift in -100.0f64..100.0,
        ) {
            let points = |shift: f64| -> Vec<_> {
                ys.iter().enumerate().map(|(i, &y)| (i as f64 + shift, y, 0.1)).collect()
            };
            let (a, b) = (Line::fit(&points(0.0)).unwrap(), Line::fit(&points(shift)).unwrap());
            prop_assert!((a.slope - b.slope).abs() < 1e-9);
            prop_assert!((a.slope_uncertainty - b.slope_uncertainty).abs() < 1e-9);
        }
    }
}
