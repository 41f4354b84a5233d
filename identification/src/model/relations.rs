//! What one term has to do with another: powers of a driver are parts of one polynomial, each with the lower orders that it
//! needs, and what is late is late in one way.

use super::{Acts, Driver, Form, LATE_SHARE, Shape, Wrap};

impl Shape {
    /// Whether it is a straight line or a lower power of the drivers of `other`, a power or a product with its own
    /// zero.
    pub fn is_lower_order_of(&self, other: &Self) -> bool {
        let mine = self.power().unwrap_or(0);
        let is_lower = match other.form {
            Form::Product => mine == 1,
            _ => mine > 0 && mine < other.power().unwrap_or(0),
        };
        // A straight line over time is called a trend.
        let same = |driver: &Driver| {
            let wrap = self.drivers[0].wrap;
            self.drivers[0].field == driver.field
                && (wrap == driver.wrap || (wrap == Wrap::Trend && driver.wrap == Wrap::Plain))
        };
        is_lower
            && self.known
            && self.acts == other.acts
            && self.drivers.len() == 1
            && other.number("origin").is_some()
            && other.drivers.iter().any(same)
    }

    /// Whether it is the square of a field through a lag, and not the square of what has come through a lag.
    pub fn is_heat(&self) -> bool {
        let is_late = |driver: &Driver| driver.wrap == Wrap::LagOf;
        self.form == Form::Quadratic && self.drivers.first().is_some_and(is_late)
    }

    /// Power of its driver, if it is one.
    fn power(&self) -> Option<usize> {
        if self.is_heat() {
            return None;
        }
        [Form::Linear, Form::Quadratic, Form::Cubic]
            .iter()
            .position(|form| *form == self.form)
            .map(|at| at + 1)
    }

    /// Whether they are different powers of one driver: parts of one polynomial.
    pub fn shares_polynomial(&self, other: &Self) -> bool {
        let are_powers = self.power().is_some() && other.power().is_some();
        let differ = self.power() != other.power();
        are_powers && differ && self.acts == other.acts && self.drivers == other.drivers
    }

    /// Number of causes in `terms`: a polynomial is one.
    pub fn causes(terms: &[Self]) -> usize {
        let is_first = |index: &usize| {
            !terms[..*index].iter().any(|before| before.shares_polynomial(&terms[*index]))
        };
        (0..terms.len()).filter(is_first).count()
    }
}

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
    // Readings in another unit may fall where what is measured rises.
    if all != 0.0 && all.is_finite() {
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

    #[test]
    fn a_polynomial_is_one_cause_and_another_driver_or_kind_is_another() {
        let power = |acts, driver: &str, form| Shape::new("any", acts, Driver::plain(driver), form);
        let polynomial = [Form::Cubic, Form::Linear, Form::Quadratic]
            .map(|form| power(Acts::Bias, "temperature", form));
        assert_eq!(Shape::causes(&polynomial), 1);
        let other = power(Acts::Bias, "supply", Form::Linear);
        let of_scale = power(Acts::Scale, "temperature", Form::Linear);
        let bump = power(Acts::Bias, "temperature", Form::Bump);
        let terms = [&polynomial[..], &[other, of_scale, bump]].concat();
        assert_eq!(Shape::causes(&terms), 4);
        // Two lags of one field are two causes, not a polynomial.
        let lag = |constant| polynomial[1].clone().with("time_constant", constant);
        assert_eq!(Shape::causes(&[lag(3.0), lag(40.0)]), 2);
    }

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
