//! Checks on the mean and the root mean square of all values.

use super::figure::{Figure, Refusal};
use super::select::Sample;
use plan::Band;

/// A statistic and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
}

/// The mean. Its uncertainty is that of n independent values: their scatter, which holds their own
/// uncertainties already, or those alone where they are larger. Zero values have no mean.
pub(super) fn mean(samples: &[Sample]) -> Option<Estimate> {
    let count = samples.len() as f64;
    if samples.is_empty() {
        return None;
    }
    let value = samples.iter().map(|s| s.value).sum::<f64>() / count;
    let own = samples.iter().map(|s| s.uncertainty.powi(2)).sum::<f64>() / count;
    let scatter = match samples.len() {
        1 => 0.0,
        _ => samples.iter().map(|s| (s.value - value).powi(2)).sum::<f64>() / (count - 1.0),
    };
    Some(Estimate { value, uncertainty: (own.max(scatter) / count).sqrt() })
}

/// The root mean square: the root of the mean of the squares, each with the uncertainty that its value
/// gives it to first order.
pub(super) fn rms(samples: &[Sample]) -> Option<Estimate> {
    let squares: Vec<_> = samples
        .iter()
        .map(|s| Sample {
            value: s.value.powi(2),
            uncertainty: 2.0 * s.value.abs() * s.uncertainty,
        })
        .collect();
    let square = mean(&squares)?;
    let value = square.value.sqrt();
    if value > 0.0 {
        return Some(Estimate { value, uncertainty: square.uncertainty / (2.0 * value) });
    }
    // Every value is zero: the first order says nothing, the values' own uncertainties bound it.
    let own = samples.iter().map(|s| s.uncertainty.powi(2)).sum::<f64>();
    Some(Estimate { value, uncertainty: (own / samples.len() as f64).sqrt() })
}

pub(super) fn mean_within(samples: &[Sample], band: Band) -> Result<Figure, Refusal> {
    within(mean(samples), band, format!("mean of {}", samples.len()))
}

pub(super) fn rms_within(samples: &[Sample], band: Band) -> Result<Figure, Refusal> {
    within(rms(samples), band, format!("root mean square of {}", samples.len()))
}

/// The root mean square of `ours` over that of `theirs`, taken as independent.
pub(super) fn ratio_within(
    ours: &[Sample],
    theirs: &[Sample],
    band: Band,
) -> Result<Figure, Refusal> {
    let ratio = match (rms(ours), rms(theirs)) {
        (Some(a), Some(b)) => {
            let relative = b.uncertainty / b.value;
            let value = a.value / b.value;
            let uncertainty = (a.uncertainty / b.value).hypot(value * relative);
            Some(Estimate { value, uncertainty })
        }
        _ => None,
    };
    within(ratio, band, format!("rms of {} over rms of {}", ours.len(), theirs.len()))
}

fn within(estimate: Option<Estimate>, band: Band, statistic: String) -> Result<Figure, Refusal> {
    let Some(Estimate { value, uncertainty }) = estimate else {
        return Err(Refusal::Unset(format!("{statistic}: nothing observed")));
    };
    Figure::in_band(value, uncertainty, band, statistic)
}

#[cfg(test)]
mod tests {
    use super::{Sample, mean, rms};

    fn samples(values: &[f64], uncertainty: f64) -> Vec<Sample> {
        values.iter().map(|&value| Sample { value, uncertainty }).collect()
    }

    #[test]
    fn the_mean_is_as_uncertain_as_scatter_or_readings_make_it() {
        // 1, 2, 3: standard deviation 1, over sqrt(3).
        let scattered = mean(&samples(&[1.0, 2.0, 3.0], 0.1)).unwrap();
        assert_eq!(scattered.value, 2.0);
        assert!((scattered.uncertainty - 1.0 / 3f64.sqrt()).abs() < 1e-15);
        // Readings worse than what they scatter.
        let poor = mean(&samples(&[1.0, 1.0, 1.0, 1.0], 0.2)).unwrap();
        assert!((poor.uncertainty - 0.1).abs() < 1e-15);
        assert_eq!(mean(&samples(&[5.0], 0.3)).unwrap().uncertainty, 0.3);
        assert_eq!(mean(&[]), None);
    }

    #[test]
    fn the_rms_is_propagated_to_first_order() {
        // Squares 9 and 16: mean 12.5, own sqrt((6u)^2 + (8u)^2) / 2 = 5u; u = 1 gives 5 / sqrt(50).
        let poor = rms(&samples(&[3.0, -4.0], 1.0)).unwrap();
        assert!((poor.value - 12.5f64.sqrt()).abs() < 1e-15);
        assert!((poor.uncertainty - 5.0 / 50f64.sqrt()).abs() < 1e-15);
        // Scatter of the squares: 7 / sqrt(2), over sqrt(2), over 2 x rms.
        let scattered = rms(&samples(&[3.0, -4.0], 0.0)).unwrap();
        assert!((scattered.uncertainty - 3.5 / 50f64.sqrt()).abs() < 1e-15);
        let zero = rms(&samples(&[0.0, 0.0], 0.1)).unwrap();
        assert_eq!((zero.value, zero.uncertainty), (0.0, 0.1));
    }
}
