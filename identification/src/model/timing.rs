//! Kinds of delay.

use super::{Acts, Driver, Form, LATE_SHARE, Shape, Wrap};

/// A kind of delay: a delay, a filter or a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing(Acts, Wrap);

impl Timing {
    /// Kind of delay of `shape`, if it is one.
    pub fn of(shape: &Shape) -> Option<Self> {
        let wrap = shape.drivers.first().map_or(Wrap::Plain, |driver| driver.wrap);
        (shape.form == Form::Delay).then_some(Self(shape.acts, wrap))
    }
}

/// Says of each delay among `terms` that all of what is measured is late, its scale error included. What a delay of the truth
/// alone leaves of a scale error looks like another delay, or like a wave. A term has `width` of the `coefficients`.
pub fn delay_all(terms: &mut [Shape], coefficients: &[f64], width: impl Fn(&Shape) -> usize) {
    let mut at = 0;
    let mut all = 1.0;
    for term in terms.iter() {
        if term.acts == Acts::Scale && term.drivers.is_empty() {
            all += coefficients.get(at).copied().unwrap_or(0.0);
        }
        at += width(term);
    }
    if all > 0.0 && all.is_finite() {
        for term in terms.iter_mut().filter(|term| term.form == Form::Delay) {
            term.set(LATE_SHARE, all);
        }
    }
}

/// Whether `shape` is a plain delay.
pub fn is_delay(shape: &Shape) -> bool {
    Timing::of(shape) == Some(Timing(Acts::Delay, Wrap::Plain))
}

/// Whether one of `terms` already states the delay, the lag or the hysteresis of `shape`. Its size is a number of that
/// term: a second one would repeat it, and the two could balance each other. To first order a delay subtracts the slope of
/// the `rotation`, so an error proportional to that slope repeats it as well.
pub fn is_said_by(terms: &[Shape], shape: &Shape, rotation: &str) -> bool {
    let goes_with_slope = |shape: &Shape| {
        let slope = Driver::new(Wrap::RateOf, rotation);
        shape.acts == Acts::Bias && shape.drivers == [slope]
    };
    let of = |shape: &Shape| match Timing::of(shape) {
        None if goes_with_slope(shape) => Some(Timing(Acts::Delay, Wrap::Plain)),
        timing => timing,
    };
    let timing = of(shape);
    let remembers = matches!(shape.drivers.first(), Some(one) if matches!(one.wrap, Wrap::LagOf | Wrap::BranchOf));
    terms
        .iter()
        .any(|term| (timing.is_some() && of(term) == timing) || (remembers && term.says(shape)))
}

#[cfg(test)]
mod tests {
    use super::is_said_by;
    use crate::model::{Acts, Driver, Form, Shape, Wrap};

    fn late(wrap: Wrap) -> Shape {
        Shape::new("any", Acts::Delay, Driver::new(wrap, "reference"), Form::Delay)
    }

    #[test]
    fn one_is_late_in_one_way_once() {
        let terms = [late(Wrap::LagOf), late(Wrap::Plain)];
        let is_said = |terms: &[Shape], shape: &Shape| is_said_by(terms, shape, "reference");
        assert!(is_said(&terms, &late(Wrap::Plain)));
        assert!(!is_said(&terms[..1], &late(Wrap::Plain)));
        // An error over the slope of the reference is a delay; one over the slope of another field is not.
        let goes_with = |field: &str| {
            let driver = Driver::new(Wrap::RateOf, field);
            Shape::new("rate_dependence", Acts::Bias, driver, Form::Linear)
        };
        assert!(is_said(&terms, &goes_with("reference")));
        assert!(is_said(&[goes_with("reference")], &late(Wrap::Plain)));
        assert!(!is_said(&terms, &goes_with("temperature")));
        // A driver has one hysteresis, of one width.
        let play = |width: f64| {
            let driver = Driver::new(Wrap::BranchOf, "temperature");
            Shape::new("thermal_hysteresis", Acts::Bias, driver, Form::Linear)
                .with("half_width", width)
        };
        assert!(is_said(&[play(1.0)], &play(3.0)));
        // Two axes without delay carry no information on it.
        let constant = Shape { form: Form::Constant, ..late(Wrap::Plain) };
        assert!(!is_said(std::slice::from_ref(&constant), &constant));
    }
}
