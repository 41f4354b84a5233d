//! Units of parameters as a finding writes them (`deg/s/(K/s)`): their size in SI and their dimension.

use identification::dataset::{Dimension, Unit};

/// Powers of: time, angle, length, temperature, voltage, current, magnetic field, count.
pub type Powers = [i8; 8];

/// A unit expression: its SI value and its dimension. Radians count as a dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// One of it in SI.
    pub si: f64,
    /// Its dimension.
    pub powers: Powers,
}

impl Quantity {
    /// A plain number.
    pub const ONE: Self = Self { si: 1.0, powers: [0; 8] };

    /// Reads products, quotients, powers (`^2`, `2` or superscripts) and parentheses of the contract's units, `K`, `h`,
    /// `min`, `%` and `ppm`. `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        if text.is_empty() {
            return Some(Self::ONE);
        }
        let mut rest = text.as_str();
        let quantity = expression(&mut rest, DEPTH_MAX)?;
        rest.is_empty().then_some(quantity)
    }

    fn times(self, other: Self, power: i8) -> Self {
        let mut powers = self.powers;
        for (mine, theirs) in powers.iter_mut().zip(other.powers) {
            *mine = mine.saturating_add(theirs.saturating_mul(power));
        }
        Self { si: self.si * other.si.powi(i32::from(power)), powers }
    }
}

/// Maximum depth of nested parentheses.
const DEPTH_MAX: usize = 8;

fn expression(rest: &mut &str, depth: usize) -> Option<Quantity> {
    let mut total = factor(rest, depth)?;
    loop {
        let sign = match rest.chars().next() {
            Some('/') => -1,
            Some('*' | '·') => 1,
            _ => return Some(total),
        };
        *rest = &rest[rest.chars().next()?.len_utf8()..];
        total = total.times(factor(rest, depth)?, sign);
    }
}

fn factor(rest: &mut &str, depth: usize) -> Option<Quantity> {
    let unit = if let Some(inner) = rest.strip_prefix('(') {
        *rest = inner;
        let quantity = expression(rest, depth.checked_sub(1)?)?;
        *rest = rest.strip_prefix(')')?;
        quantity
    } else if let Some(after) = rest.strip_prefix('1') {
        *rest = after;
        Quantity::ONE
    } else {
        let end = rest.find(|c: char| !(c.is_alphabetic() || c == '%')).unwrap_or(rest.len());
        let unit = named(&rest[..end])?;
        *rest = &rest[end..];
        unit
    };
    let powered = rest.strip_prefix('^').unwrap_or(rest);
    let (negative, digits) = powered.strip_prefix('-').map_or((false, powered), |d| (true, d));
    for (text, power) in [("2", 2), ("3", 3), ("4", 4), ("1", 1), ("²", 2), ("³", 3)] {
        if let Some(after) = digits.strip_prefix(text) {
            *rest = after;
            return Some(Quantity::ONE.times(unit, if negative { -power } else { power }));
        }
    }
    Some(unit)
}

fn named(text: &str) -> Option<Quantity> {
    /// Seconds in an hour and in a minute.
    const HOUR: f64 = 3600.0;
    const MINUTE: f64 = 60.0;
    let time = |si| Quantity { si, powers: [1, 0, 0, 0, 0, 0, 0, 0] };
    Some(match text {
        "K" => Quantity { si: 1.0, powers: [0, 0, 0, 1, 0, 0, 0, 0] },
        "h" => time(HOUR),
        "min" => time(MINUTE),
        "%" => Quantity { si: 1e-2, ..Quantity::ONE },
        "ppm" => Quantity { si: 1e-6, ..Quantity::ONE },
        "mm" => Quantity { si: 1e-3, powers: [0, 0, 1, 0, 0, 0, 0, 0] },
        _ => {
            let unit = Unit::parse(text)?;
            let powers = match unit.dimension() {
                Dimension::Time => [1, 0, 0, 0, 0, 0, 0, 0],
                Dimension::Angle => [0, 1, 0, 0, 0, 0, 0, 0],
                Dimension::Length => [0, 0, 1, 0, 0, 0, 0, 0],
                Dimension::Temperature => [0, 0, 0, 1, 0, 0, 0, 0],
                Dimension::Voltage => [0, 0, 0, 0, 1, 0, 0, 0],
                Dimension::Current => [0, 0, 0, 0, 0, 1, 0, 0],
                Dimension::MagneticField => [0, 0, 0, 0, 0, 0, 1, 0],
                Dimension::Count => [0, 0, 0, 0, 0, 0, 0, 1],
                Dimension::Frequency => [-1, 0, 0, 0, 0, 0, 0, 0],
                Dimension::Number => [0; 8],
                // Their texts contain a slash, so they are parsed as quotients.
                Dimension::AngularRate | Dimension::Speed | Dimension::Acceleration => return None,
            };
            Quantity { si: unit.si(), powers }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn units_of_parameters_are_read() {
        let parse = |text| Quantity::parse(text).expect(text);
        let degree = std::f64::consts::PI / 180.0;
        assert_eq!(
            parse("deg/s/(K/s)"),
            Quantity { si: degree, powers: [0, 1, 0, -1, 0, 0, 0, 0] }
        );
        assert_eq!(
            parse("deg/h"),
            Quantity { si: degree / 3600.0, powers: [-1, 1, 0, 0, 0, 0, 0, 0] }
        );
        assert_eq!(parse("m/s2"), parse("m/s/s"));
        assert_eq!(parse("1/K^2"), parse("1/(K*K)"));
        assert_eq!(parse("1"), Quantity::ONE);
        assert_eq!(parse("ppm/K").powers, parse("1/K").powers);
    }

    #[test]
    fn other_texts_are_not_units() {
        for text in ["furlong", "deg/", "(deg", "deg)", "/s", "((((((((((s))))))))))"] {
            assert_eq!(Quantity::parse(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn no_text_is_a_panic(text in "\\PC{0,20}") {
            let _ = Quantity::parse(&text);
        }
    }
}
