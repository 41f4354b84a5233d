//! Units: which numbers are comparable, and the conversion factors.

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    /// Exponents of metre, kilogram, second, ampere, kelvin, degree Celsius and radian. Degree Celsius is separate from
    /// kelvin because its zero differs: no factor converts one into the other.
    dimension: [i8; 7],
    /// Its size in base units is `factor` times ten to the power of `tens`.
    factor: f64,
    tens: i32,
}

const NONE: [i8; 7] = [0; 7];
const SECOND: [i8; 7] = [0, 0, 1, 0, 0, 0, 0];
const RADIAN: [i8; 7] = [0, 0, 0, 0, 0, 0, 1];
const HERTZ: [i8; 7] = [0, 0, -1, 0, 0, 0, 0];
const NEWTON: [i8; 7] = [1, 1, -2, 0, 0, 0, 0];
const PASCAL: [i8; 7] = [-1, 1, -2, 0, 0, 0, 0];
const JOULE: [i8; 7] = [2, 1, -2, 0, 0, 0, 0];
const WATT: [i8; 7] = [2, 1, -3, 0, 0, 0, 0];
const COULOMB: [i8; 7] = [0, 0, 1, 1, 0, 0, 0];
const VOLT: [i8; 7] = [2, 1, -3, -1, 0, 0, 0];
const OHM: [i8; 7] = [2, 1, -3, -2, 0, 0, 0];
const FARAD: [i8; 7] = [-2, -1, 4, 2, 0, 0, 0];
const HENRY: [i8; 7] = [2, 1, -2, -2, 0, 0, 0];
const TESLA: [i8; 7] = [0, 1, -2, -1, 0, 0, 0];

/// Units that take an SI prefix. The kilogram has the size of a thousand grams.
const PREFIXED: [(&str, [i8; 7], f64, i32); 24] = [
    ("m", [1, 0, 0, 0, 0, 0, 0], 1.0, 0),
    ("g", [0, 1, 0, 0, 0, 0, 0], 1.0, -3),
    ("s", SECOND, 1.0, 0),
    ("A", [0, 0, 0, 1, 0, 0, 0], 1.0, 0),
    ("K", [0, 0, 0, 0, 1, 0, 0], 1.0, 0),
    ("rad", RADIAN, 1.0, 0),
    ("Hz", HERTZ, 1.0, 0),
    ("N", NEWTON, 1.0, 0),
    ("Nm", JOULE, 1.0, 0),
    ("Pa", PASCAL, 1.0, 0),
    ("bar", PASCAL, 1.0, 5),
    ("J", JOULE, 1.0, 0),
    ("Wh", JOULE, 36.0, 2),
    ("W", WATT, 1.0, 0),
    ("VA", WATT, 1.0, 0),
    ("var", WATT, 1.0, 0),
    ("Ah", COULOMB, 36.0, 2),
    ("V", VOLT, 1.0, 0),
    ("Ohm", OHM, 1.0, 0),
    ("ohm", OHM, 1.0, 0),
    ("Ω", OHM, 1.0, 0),
    ("F", FARAD, 1.0, 0),
    ("H", HENRY, 1.0, 0),
    ("T", TESLA, 1.0, 0),
];

/// Unicode has two characters for `µ` that look alike.
const PREFIXES: [(&str, i32); 10] = [
    ("", 0),
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

const CELSIUS: [i8; 7] = [0, 0, 0, 0, 0, 1, 0];
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Units without prefixes.
const ALONE: [(&str, [i8; 7], f64, i32); 24] = [
    ("sec", SECOND, 1.0, 0),
    ("min", SECOND, 60.0, 0),
    ("h", SECOND, 36.0, 2),
    ("degC", CELSIUS, 1.0, 0),
    ("°C", CELSIUS, 1.0, 0),
    ("deg", RADIAN, DEGREE, 0),
    ("°", RADIAN, DEGREE, 0),
    ("rev", RADIAN, 360.0 * DEGREE, 0),
    ("rpm", [0, 0, -1, 0, 0, 0, 1], 6.0 * DEGREE, 0),
    ("dps", [0, 0, -1, 0, 0, 0, 1], DEGREE, 0),
    ("%", NONE, 1.0, -2),
    ("ppm", NONE, 1.0, -6),
    ("1", NONE, 1.0, 0),
    ("l", [3, 0, 0, 0, 0, 0, 0], 1.0, -3),
    ("L", [3, 0, 0, 0, 0, 0, 0], 1.0, -3),
    ("kph", [1, 0, -1, 0, 0, 0, 0], 1.0 / 36.0, 1),
    ("mph", [1, 0, -1, 0, 0, 0, 0], 0.447_04, 0),
    ("kn", [1, 0, -1, 0, 0, 0, 0], 1.852 / 3.6, 0),
    ("kt", [1, 0, -1, 0, 0, 0, 0], 1.852 / 3.6, 0),
    ("m²", [2, 0, 0, 0, 0, 0, 0], 1.0, 0),
    ("s²", [0, 0, 2, 0, 0, 0, 0], 1.0, 0),
    ("m2", [2, 0, 0, 0, 0, 0, 0], 1.0, 0),
    ("s2", [0, 0, 2, 0, 0, 0, 0], 1.0, 0),
    ("s^2", [0, 0, 2, 0, 0, 0, 0], 1.0, 0),
];

/// Signs between the factors of a product.
pub(crate) const TIMES: [char; 2] = ['*', '·'];

impl Unit {
    /// The unit with this notation, if known: `mV`, `km/h`, `m/s^2`, `N*m`, `1/m`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split('/');
        let mut factors = parts.next()?.split(TIMES).map(Self::single);
        let first = factors.next()?;
        // Behind a `/`, it is not clear what a product divides.
        let mut unit = factors.try_fold(first?, |unit, factor| unit.times(factor?))?;
        for part in parts {
            unit = unit.over(Self::single(part)?)?;
        }
        Some(unit)
    }

    fn single(text: &str) -> Option<Self> {
        if let Some((_, dimension, factor, tens)) = ALONE.iter().find(|(name, ..)| *name == text) {
            return Some(Self { dimension: *dimension, factor: *factor, tens: *tens });
        }
        PREFIXES.iter().find_map(|(prefix, power)| {
            let rest = text.strip_prefix(prefix)?;
            let (_, dimension, factor, tens) = PREFIXED.iter().find(|(name, ..)| *name == rest)?;
            Some(Self { dimension: *dimension, factor: *factor, tens: tens + power })
        })
    }

    pub(crate) fn times(self, other: Self) -> Option<Self> {
        let factor = self.factor * other.factor;
        Some(Self { factor, tens: self.tens + other.tens, dimension: self.exponents(other, 1)? })
    }

    pub(crate) fn over(self, other: Self) -> Option<Self> {
        let factor = self.factor / other.factor;
        Some(Self { factor, tens: self.tens - other.tens, dimension: self.exponents(other, -1)? })
    }

    /// `None` if an exponent overflows.
    fn exponents(self, other: Self, sign: i8) -> Option<[i8; 7]> {
        let mut dimension = self.dimension;
        for (mine, theirs) in dimension.iter_mut().zip(other.dimension) {
            *mine = mine.checked_add(theirs.checked_mul(sign)?)?;
        }
        Some(dimension)
    }

    /// The factor and power of ten that convert a number in `self` to `other`, if they have the same dimension.
    pub(crate) fn in_terms_of(self, other: Self) -> Option<(f64, i32)> {
        let factor = if self.factor == other.factor { 1.0 } else { self.factor / other.factor };
        (self.dimension == other.dimension).then_some((factor, self.tens - other.tens))
    }

    pub(crate) fn one() -> Self {
        Self { dimension: NONE, factor: 1.0, tens: 0 }
    }
}

/// True if both units are known, and a number in one is another number in the other.
pub fn units_differ(one: &str, other: &str) -> bool {
    let (Some(one), Some(other)) = (Unit::parse(one), Unit::parse(other)) else { return false };
    let ratio = one.in_terms_of(other).map(|(factor, tens)| factor * 10_f64.powi(tens));
    ratio.is_none_or(|ratio| (ratio - 1.0).abs() > 1e-9)
}

#[cfg(test)]
mod tests {
    use super::Unit;

    fn ratio(from: &str, to: &str) -> Option<f64> {
        let (from, to) = (Unit::parse(from)?, Unit::parse(to)?);
        let (factor, tens) = from.in_terms_of(to)?;
        Some(factor * 10f64.powi(tens))
    }

    #[test]
    fn units_of_one_kind_have_a_ratio() {
        for (from, to, expected) in [
            ("V", "mV", 1e3),
            ("min", "s", 60.0),
            ("km/h", "m/s", 1.0 / 3.6),
            ("kph", "km/h", 1.0),
            ("kn", "km/h", 1.852),
            ("deg", "rad", std::f64::consts::PI / 180.0),
            ("rpm", "rad/s", std::f64::consts::TAU / 60.0),
            ("rpm", "dps", 6.0),
            ("kWh", "J", 3.6e6),
            ("Ah", "mAh", 1e3),
            ("%", "1", 0.01),
            ("kbar", "Pa", 1e8),
            ("m/s/s", "m/s^2", 1.0),
            ("µV", "μV", 1.0),
            ("kΩ", "Ohm", 1e3),
            ("N*m", "Nm", 1.0),
            ("kN·m", "J", 1e3),
            ("N*m/A", "Wh/A", 1.0 / 3.6e3),
            ("deg/sec", "dps", 1.0),
            ("1/km", "1/m", 1e-3),
        ] {
            let found = ratio(from, to).unwrap_or_else(|| panic!("{from} in {to}"));
            assert!((found / expected - 1.0).abs() < 1e-12, "{from} in {to}: {found}");
        }
    }

    #[test]
    fn other_units_have_none() {
        for (from, to) in [("V", "A"), ("degC", "K"), ("rad/s", "Hz"), ("m", "min"), ("%", "deg")] {
            assert_eq!(ratio(from, to), None, "{from} in {to}");
        }
        for text in ["", "/", "V/", "*", "V*", "W/m*K", "volt", "kmin", "mdegC", "kk"] {
            assert!(Unit::parse(text).is_none(), "{text}");
        }
    }
}
