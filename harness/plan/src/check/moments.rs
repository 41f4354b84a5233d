//! `mean_within`, `rms_within` and `rms_ratio_within`: the mean and the root mean square of all values.

use super::figure::{Figure, Refusal};
use super::jackknife::{self, Together};
use super::kind::{Facts, Kind, UnitOf};
use super::selection::{Sample, Selection};
use crate::band::Band;
use crate::number;
use crate::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;

/// The mean lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
pub struct MeanWithin(pub Band);

impl Kind for MeanWithin {
    fn facts(&self) -> Facts<'_> {
        Facts { estimates: true, ..Facts::of(self.0) }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let samples = selection.samples();
        let statistic = format!("mean of {}", samples.len());
        within(mean(&samples, selection.together()), self.0, statistic)
    }
}

/// The root mean square lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
pub struct RmsWithin(pub Band);

impl Kind for RmsWithin {
    fn facts(&self) -> Facts<'_> {
        Facts { estimates: true, ..Facts::of(self.0) }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let samples = selection.samples();
        let statistic = format!("root mean square of {}", samples.len());
        within(rms(&samples, selection.together()), self.0, statistic)
    }
}

/// The root mean square, over that of another quantity of the same unit, lies in the band.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[schemars(inline)]
#[serde(deny_unknown_fields)]
pub struct RmsRatioWithin {
    /// The other quantity.
    pub to: QuantityName,
    /// Standard uncertainty of an offset that all values of `to` in a run share, in their unit: known from a model
    /// of their source, because their scatter does not show it.
    #[serde(default, with = "number::Positive")]
    pub to_offset: f64,
    /// The band.
    pub band: Band,
}

impl Kind for RmsRatioWithin {
    fn facts(&self) -> Facts<'_> {
        Facts {
            unit: UnitOf::Fixed("1"),
            estimates: true,
            second_quantity: Some(("to", &self.to)),
            ..Facts::of(self.band)
        }
    }

    fn figure(&self, selection: &Selection<'_>) -> Result<Figure, Refusal> {
        let (ours, theirs) = (selection.samples(), selection.second_samples());
        ratio_within(&ours, &theirs, self.to_offset, selection.together(), self.band)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
}

/// The mean; `None` without values.
pub(super) fn mean(samples: &[Sample], together: Together) -> Option<Estimate> {
    estimate(samples, together, |_| 1.0, mean_of)
}

/// The root mean square; `None` without values.
pub(super) fn rms(samples: &[Sample], together: Together) -> Option<Estimate> {
    let value = root_mean_square_of(&mut samples.iter())?;
    // If every value is zero the linear term vanishes; the values' own uncertainties are an upper bound.
    let of_zero = (samples.len() as f64).sqrt();
    let weight = |sample: &Sample| if value > 0.0 { sample.value / value } else { of_zero };
    estimate(samples, together, weight, root_mean_square_of)
}

/// The figure with its uncertainty: from the scatter of the values, which already includes their own uncertainties, or
/// from these if larger. `weight` is the derivative of the figure by a value, times the number of values.
fn estimate(
    samples: &[Sample],
    together: Together,
    weight: impl Fn(&Sample) -> f64,
    figure: Statistic,
) -> Option<Estimate> {
    let value = figure(&mut samples.iter())?;
    let own = samples.iter().map(|sample| (weight(sample) * sample.uncertainty).powi(2));
    let own = own.sum::<f64>().sqrt() / samples.len() as f64;
    let scatter = jackknife::uncertainty(samples.len(), together, |left_out| {
        figure(&mut jackknife::rest(samples, left_out))
    })?;
    Some(Estimate { value, uncertainty: own.max(scatter) })
}

type Statistic = fn(&mut dyn Iterator<Item = &Sample>) -> Option<f64>;

fn mean_of(samples: &mut dyn Iterator<Item = &Sample>) -> Option<f64> {
    let (count, sum) = samples.fold((0.0, 0.0), |(count, sum), one| (count + 1.0, sum + one.value));
    (count > 0.0).then(|| sum / count)
}

fn root_mean_square_of(samples: &mut dyn Iterator<Item = &Sample>) -> Option<f64> {
    let add = |(count, sum), one: &Sample| (count + 1.0, sum + one.value * one.value);
    let (count, sum) = samples.fold((0.0, 0.0), add);
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// Ratio of the root mean squares of `ours` and `theirs`, each in time order. A drift common to both does not count as
/// scatter. `offset` is the standard uncertainty of an offset that `theirs` share (JCGM 100:2008, 4.3: evaluated by other
/// means than their scatter).
fn ratio_within(
    ours: &[Sample],
    theirs: &[Sample],
    offset: f64,
    together: Together,
    band: Band,
) -> Result<Figure, Refusal> {
    let statistic = format!("rms of {} over rms of {}", ours.len(), theirs.len());
    let ratio = match (rms(ours, together), rms(theirs, together)) {
        (Some(a), Some(b)) => {
            let value = a.value / b.value;
            let own = (a.uncertainty / b.value).hypot(value * b.uncertainty / b.value);
            let is_paired = together == Together::InTime && ours.len() == theirs.len();
            let both = is_paired.then(|| {
                jackknife::uncertainty(ours.len(), together, |left_out| {
                    let theirs = &mut jackknife::rest(theirs, left_out.clone());
                    let ours = &mut jackknife::rest(ours, left_out);
                    Some(root_mean_square_of(ours)? / root_mean_square_of(theirs)?)
                })
            });
            let scatter = both.flatten().unwrap_or(own);
            let common = value * of_offset(theirs, offset) / b.value;
            Some(Estimate { value, uncertainty: scatter.hypot(common) })
        }
        _ => None,
    };
    within(ratio, band, statistic)
}

/// Standard uncertainty of a root mean square by an offset o of all values: the mean square is off by 2 m o + o^2 with
/// the mean m. The square counts where the mean is small (JCGM 100:2008, 5.1.2, note).
fn of_offset(samples: &[Sample], offset: f64) -> f64 {
    let (Some(mean), Some(rms)) =
        (mean_of(&mut samples.iter()), root_mean_square_of(&mut samples.iter()))
    else {
        return 0.0;
    };
    (2.0 * mean * offset).hypot(std::f64::consts::SQRT_2 * offset * offset) / (2.0 * rms)
}

fn within(estimate: Option<Estimate>, band: Band, statistic: String) -> Result<Figure, Refusal> {
    let Some(Estimate { value, uncertainty }) = estimate else {
        return Err(Refusal::Unset(format!("{statistic}: nothing observed")));
    };
    Figure::in_band(value, uncertainty, band, statistic)
}

#[cfg(test)]
mod tests {
    use super::Together::{Alone, InTime};
    use super::{Sample, mean, ratio_within, rms};

    fn samples(values: &[f64], uncertainty: f64) -> Vec<Sample> {
        values.iter().map(|&value| Sample { value, uncertainty }).collect()
    }

    /// Ratio of Student's t at 95 % to the quantile of the normal distribution, for one and two degrees of freedom.
    const WIDE: [f64; 2] = [12.706 / 1.959_964, 4.303 / 1.959_964];

    #[test]
    fn the_mean_is_as_uncertain_as_scatter_or_readings_make_it() {
        // 1, 2, 3: standard deviation 1, over sqrt(3).
        let scattered = mean(&samples(&[1.0, 2.0, 3.0], 0.1), Alone).unwrap();
        assert_eq!(scattered.value, 2.0);
        assert!((scattered.uncertainty - WIDE[1] / 3f64.sqrt()).abs() < 1e-12);
        // The readings are less certain than their scatter suggests.
        let poor = mean(&samples(&[1.0, 1.0, 1.0, 1.0], 0.2), Alone).unwrap();
        assert!((poor.uncertainty - 0.1).abs() < 1e-15);
        assert_eq!(mean(&samples(&[5.0], 0.3), Alone).unwrap().uncertainty, 0.3);
        assert_eq!(mean(&[], Alone), None);
    }

    #[test]
    fn the_rms_is_propagated_to_first_order() {
        // Squares 9 and 16: mean 12.5, own sqrt((6u)^2 + (8u)^2) / 2 = 5u; u = 5 gives 25 / sqrt(50).
        let poor = rms(&samples(&[3.0, -4.0], 5.0), Alone).unwrap();
        assert!((poor.value - 12.5f64.sqrt()).abs() < 1e-15);
        assert!((poor.uncertainty - 25.0 / 50f64.sqrt()).abs() < 1e-12);
        // Without either value it is the magnitude of the other: 4 and 3, and half their difference.
        let scattered = rms(&samples(&[3.0, -4.0], 0.0), Alone).unwrap();
        assert!((scattered.uncertainty - WIDE[0] / 2.0).abs() < 1e-12);
        let zero = rms(&samples(&[0.0, 0.0], 0.1), Alone).unwrap();
        assert_eq!(zero.value, 0.0);
        assert!((zero.uncertainty - 0.1).abs() < 1e-15);
    }

    /// Both follow the same drift, so the ratio is exact.
    #[test]
    fn a_ratio_of_two_that_drift_together_is_exact() {
        let ours: Vec<f64> = (0..40).map(|i| 1.0 + f64::from(i)).collect();
        let theirs: Vec<f64> = ours.iter().map(|value| 2.0 * value).collect();
        let ratio = |together| {
            let band = crate::Band::at_most(1.0);
            ratio_within(&samples(&ours, 0.0), &samples(&theirs, 0.0), 0.0, together, band).unwrap()
        };
        assert!(ratio(InTime).uncertainty < 1e-12);
        assert!(ratio(Alone).uncertainty > 0.05);
    }

    #[test]
    fn an_offset_of_the_reference_counts_even_without_scatter() {
        let band = crate::Band::at_most(1.0);
        let of = |theirs: &[f64]| {
            let (ours, theirs) = (samples(&[1.0; 4], 0.0), samples(theirs, 0.0));
            ratio_within(&ours, &theirs, 0.5, InTime, band).unwrap()
        };
        // 1 / (2 + o): 0.5 / 4 to first order, and the square adds a little.
        let exact = (4.0 * 4.0 * 0.25f64 + 2.0 * 0.0625).sqrt() / 16.0;
        assert!((of(&[2.0; 4]).uncertainty - exact).abs() < 1e-12);
        // Without a mean the square is all: o^2 / sqrt 2 over 2 rms^3. The scatter of these is zero.
        let square = 0.25 / 2f64.sqrt() / 8.0;
        let found = of(&[2.0, -2.0, 2.0, -2.0]).uncertainty;
        assert!((found - square).abs() < 1e-12, "{found} {square}");
    }
}
