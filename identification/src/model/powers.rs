//! Powers of a driver: parts of one polynomial, each with the lower orders that it needs.

use super::{Driver, Form, Shape, Wrap};

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

    /// Power of its driver, if it is one.
    fn power(&self) -> Option<usize> {
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

#[cfg(test)]
mod tests {
    use super::{Driver, Form, Shape};
    use crate::model::Acts;

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
}
