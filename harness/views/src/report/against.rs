//! The natural axis for the observations of a quantity.

use super::observed::Sample;

/// Minimum span of a temperature axis in kelvin. Assumption: twice the 0.5 K for which the paper's scale error is 0.26
/// deg in a turn.
const TEMPERATURE_SPAN_MIN: f64 = 1.0;

const SECONDS_PER_MINUTE: f64 = 60.0;
const SECONDS_PER_HOUR: f64 = 3_600.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Against {
    Temperature,
    Run,
    Time { unit: &'static str, unit_s: f64 },
}

impl Against {
    /// Chooses the most informative axis for `samples`.
    pub(super) fn of(samples: &[Sample]) -> Self {
        let span = |read: fn(&Sample) -> Option<f64>| {
            let axis = samples.iter().map(read).collect::<Option<Vec<_>>>()?;
            let low = axis.iter().copied().reduce(f64::min)?;
            Some(axis.into_iter().reduce(f64::max)? - low)
        };
        if span(|s| s.temperature).is_some_and(|span| span >= TEMPERATURE_SPAN_MIN) {
            return Self::Temperature;
        }
        Self::run_or_time(samples)
    }

    /// The runs, if there are several and each has a number; else the time.
    pub(super) fn run_or_time(samples: &[Sample]) -> Self {
        let runs = samples.iter().map(|sample| sample.run).collect::<Option<Vec<_>>>();
        let first = runs.as_ref().and_then(|runs| runs.first().copied());
        if runs.is_some_and(|runs| runs.iter().any(|run| Some(*run) != first)) {
            return Self::Run;
        }
        Self::time(samples)
    }

    /// The time, in a unit that suits the last sample.
    pub(super) fn time(samples: &[Sample]) -> Self {
        let (unit, unit_s) = match samples.iter().map(|s| s.at_s).fold(0.0, f64::max) {
            end if end > 2.0 * SECONDS_PER_HOUR => ("h", SECONDS_PER_HOUR),
            end if end > 5.0 * SECONDS_PER_MINUTE => ("min", SECONDS_PER_MINUTE),
            _ => ("s", 1.0),
        };
        Self::Time { unit, unit_s }
    }

    pub(super) fn label(self) -> String {
        match self {
            Self::Temperature => "temperature in degC".to_owned(),
            Self::Run => "run".to_owned(),
            Self::Time { unit, .. } => format!("bench time in {unit}"),
        }
    }

    /// Position of an instant on an axis of time.
    pub(super) fn place(self, at_s: f64) -> f64 {
        match self {
            Self::Time { unit_s, .. } => at_s / unit_s,
            Self::Temperature | Self::Run => at_s,
        }
    }

    pub(super) fn x(self, sample: &Sample) -> f64 {
        match self {
            Self::Temperature => sample.temperature.unwrap_or_default(),
            Self::Run => sample.run.unwrap_or_default(),
            Self::Time { unit_s, .. } => sample.at_s / unit_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Against;
    use crate::report::observed::{Direction, Sample};

    fn sample(at_s: f64, temperature: Option<f64>, run: Option<f64>) -> Sample {
        let direction = Some(Direction::Cw);
        Sample { at_s, value: 0.3, direction, run, temperature, ..Sample::default() }
    }

    #[test]
    fn the_axis_is_the_one_that_says_most() {
        let of = |tags: [(Option<f64>, Option<f64>); 2]| {
            let samples: Vec<_> =
                tags.into_iter().map(|(t, run)| sample(30_000.0, t, run)).collect();
            Against::of(&samples)
        };
        let (one, two) = (Some(1.0), Some(2.0));
        assert_eq!(of([(Some(20.0), one), (Some(40.0), two)]), Against::Temperature);
        assert_eq!(of([(Some(20.0), one), (Some(20.1), two)]), Against::Run);
        assert_eq!(of([(None, one), (None, one)]), Against::Time { unit: "h", unit_s: 3_600.0 });
        assert_eq!(of([(Some(20.0), None), (None, None)]).label(), "bench time in h");
        assert_eq!(Against::of(&[]).label(), "bench time in s");
    }
}
