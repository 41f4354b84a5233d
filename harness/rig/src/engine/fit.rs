//! Fits models to observations and builds calibrations from them.

use controller::calibration::{BIAS_POINTS_MAX, BiasPoint, Calibration, FACTORS_MAX, Factor};
use plan::check::line::Line;
use plan::observation::Observed;
use plan::{CalibrationPart, Fit, Model};
use std::fmt;

/// A fitted model, and the part of a calibration that it becomes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fitted {
    model: Shape,
    becomes: Option<CalibrationPart>,
    observations: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    Mean(f64),
    ByDirection {
        cw: f64,
        ccw: f64,
    },
    Line(Line),
    /// Abscissa and mean of each interval that has observations.
    Table(Vec<(f64, f64)>),
}

impl fmt::Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.model {
            Shape::Mean(mean) => write!(f, "mean {mean:.6}")?,
            Shape::ByDirection { cw, ccw } => write!(f, "cw {cw:.6}, ccw {ccw:.6}")?,
            Shape::Line(line) => write!(
                f,
                "slope {:.5} +- {:.5}, intercept {:.4} +- {:.4}",
                line.slope, line.slope_uncertainty, line.intercept, line.intercept_uncertainty
            )?,
            Shape::Table(points) => write!(f, "table of {} points", points.len())?,
        }
        write!(f, " of {} observations", self.observations)
    }
}

/// Fits the step's model to the observations that the step selects.
pub(super) fn fit<'a>(
    step: &Fit,
    observed: impl Iterator<Item = Observed<'a>>,
) -> Result<Fitted, String> {
    let used: Vec<Observed<'_>> =
        observed.filter(|one| step.filter.matches(|tag| one.tag(tag))).collect();
    let model = match &step.model {
        Model::Mean => Shape::Mean(mean(used.iter().map(Observed::value)).ok_or("nothing to fit")?),
        Model::ByDirection => {
            let of = |sign: f64| {
                let in_direction = |o: &&Observed<'_>| o.tag("direction") == Some(sign);
                mean(used.iter().filter(in_direction).map(Observed::value))
            };
            let cw = of(-1.0).ok_or("nothing clockwise to fit")?;
            let ccw = of(1.0).ok_or("nothing counter-clockwise to fit")?;
            Shape::ByDirection { cw, ccw }
        }
        Model::Line { against } => {
            let points: Vec<_> = used
                .iter()
                .filter_map(|o| Some((o.tag(against)?, o.value(), o.uncertainty())))
                .collect();
            Shape::Line(Line::fit(&points).ok_or("a line needs finite points at two abscissae")?)
        }
        Model::Table { against, points: intervals } => {
            let intervals = (intervals.get() as usize).min(BIAS_POINTS_MAX);
            Shape::Table(table(&points(&used, against), intervals).ok_or("nothing to fit")?)
        }
    };
    Ok(Fitted { model, becomes: step.becomes(), observations: used.len() })
}

/// Combines the fits into a calibration, with the factors in their order (Eq. 4).
pub(super) fn calibration<'a>(
    fits: impl Iterator<Item = &'a Fitted>,
) -> Result<Calibration, String> {
    let mut calibration = Calibration::default();
    for fitted in fits {
        let factor = match (&fitted.model, fitted.becomes) {
            (Shape::Mean(error), Some(CalibrationPart::Constant)) => {
                Factor::Constant(360.0 / (360.0 + error))
            }
            (Shape::ByDirection { cw, ccw }, Some(CalibrationPart::Direction)) => {
                Factor::Direction { cw_error_deg: *cw, ccw_error_deg: *ccw }
            }
            (Shape::Line(line), Some(CalibrationPart::TemperatureLine)) => {
                Factor::TemperatureLine {
                    slope_deg_per_celsius: line.slope,
                    intercept_deg: line.intercept,
                }
            }
            (Shape::Table(points), Some(CalibrationPart::BiasTable)) => {
                calibration.bias_table = points
                    .iter()
                    .map(|&(celsius, bias_deg_per_s)| BiasPoint { celsius, bias_deg_per_s })
                    .collect();
                continue;
            }
            _ => return Err("a fit has no place in a calibration".to_owned()),
        };
        if calibration.factors.push(factor).is_err() {
            return Err(format!("more than {FACTORS_MAX} factors"));
        }
    }
    if calibration.is_usable() {
        Ok(calibration)
    } else {
        Err("the fits make a calibration that is not credible".to_owned())
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

fn points(used: &[Observed<'_>], against: &str) -> Vec<(f64, f64)> {
    used.iter()
        .filter_map(|observation| Some((observation.tag(against)?, observation.value())))
        .collect()
}

/// Means in equal intervals of the abscissa, at the mean abscissa of each.
fn table(points: &[(f64, f64)], intervals: usize) -> Option<Vec<(f64, f64)>> {
    let low = points.iter().map(|point| point.0).reduce(f64::min)?;
    let high = points.iter().map(|point| point.0).reduce(f64::max)?;
    let width = (high - low) / intervals as f64;
    let mut sums = vec![(0.0, 0.0, 0u32); intervals];
    for &(x, y) in points {
        let index = if width > 0.0 { ((x - low) / width) as usize } else { 0 };
        let sum = &mut sums[index.min(intervals - 1)];
        *sum = (sum.0 + x, sum.1 + y, sum.2 + 1);
    }
    let means = sums.into_iter().filter(|sum| sum.2 > 0);
    Some(means.map(|(x, y, n)| (x / f64::from(n), y / f64::from(n))).collect())
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn a_table_has_the_mean_of_each_interval_and_none_where_there_is_nothing() {
        let points = [(0.0, 1.0), (1.0, 3.0), (9.0, 10.0), (10.0, 20.0)];
        assert_eq!(table(&points, 5), Some(vec![(0.5, 2.0), (9.5, 15.0)]));
        assert_eq!(table(&[(4.0, 7.0)], 5), Some(vec![(4.0, 7.0)]));
        assert_eq!(table(&[], 5), None);
    }
}
