//! The band that a figure must lie in, ends inclusive and optionally open.

use crate::number;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, de};
use std::borrow::Cow;
use std::fmt;

/// A closed interval, possibly open-ended: `[-0.25, 0.25]`, `{ at_most = 3 }` or `{ at_least = 0.9 }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    lower: Option<f64>,
    upper: Option<f64>,
}

impl Band {
    /// From `lower` to `upper`; `None` if the band is empty or an end is not finite.
    pub fn new(lower: f64, upper: f64) -> Option<Self> {
        (lower.is_finite() && upper.is_finite() && lower <= upper)
            .then_some(Self { lower: Some(lower), upper: Some(upper) })
    }

    /// Everything up to `upper`, a finite number.
    pub const fn at_most(upper: f64) -> Self {
        Self { lower: None, upper: Some(upper) }
    }

    /// Everything from `lower`, a finite number.
    pub const fn at_least(lower: f64) -> Self {
        Self { lower: Some(lower), upper: None }
    }

    /// The band without ends that no figure between `least` and `greatest` can pass, so that no margin to them is
    /// required.
    pub fn of_figures_within(self, least: f64, greatest: f64) -> Self {
        Self {
            lower: self.lower.filter(|lower| *lower > least),
            upper: self.upper.filter(|upper| *upper < greatest),
        }
    }

    /// Lower end, inclusive.
    pub const fn lower(self) -> Option<f64> {
        self.lower
    }

    /// Upper end, inclusive.
    pub const fn upper(self) -> Option<f64> {
        self.upper
    }

    /// Distance of `value` from the nearer end, negative outside. Minus infinity if `value` is not finite.
    pub fn margin(self, value: f64) -> f64 {
        if !value.is_finite() {
            return f64::NEG_INFINITY;
        }
        let above = self.lower.map_or(f64::INFINITY, |lower| apart(value, lower));
        let below = self.upper.map_or(f64::INFINITY, |upper| apart(upper, value));
        above.min(below)
    }

    /// Whether `value` is finite and inside.
    pub fn contains(self, value: f64) -> bool {
        self.margin(value) >= 0.0
    }
}

/// `a - b`; zero if rounding alone makes the two differ: three counts of 0.1 V are 0.30000000000000004 V.
fn apart(a: f64, b: f64) -> f64 {
    let apart = a - b;
    if apart.abs() <= 4.0 * f64::EPSILON * a.abs().max(b.abs()) { 0.0 } else { apart }
}

impl fmt::Display for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.lower, self.upper) {
            (Some(lower), Some(upper)) => write!(f, "{lower} to {upper}"),
            (Some(lower), None) => write!(f, "at least {lower}"),
            (None, Some(upper)) => write!(f, "at most {upper}"),
            (None, None) => f.write_str("anything"),
        }
    }
}

/// The open-ended form.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ends {
    #[serde(default, with = "number::Finite")]
    at_least: Option<f64>,
    #[serde(default, with = "number::Finite")]
    at_most: Option<f64>,
}

#[derive(Deserialize)]
struct End(#[serde(with = "number::Finite")] f64);

const FORMS: &str = "a band: `[lower, upper]`, `{ at_most = x }` or `{ at_least = x }`";

wire::either! { Band, FORMS,
    list(list) => match Vec::<End>::deserialize(list)?[..] {
        [End(lower), End(upper)] => checked(Band { lower: Some(lower), upper: Some(upper) }),
        ref ends => Err(de::Error::invalid_length(ends.len(), &FORMS)),
    },
    map(map) => {
        let ends = Ends::deserialize(map)?;
        checked(Band { lower: ends.at_least, upper: ends.at_most })
    },
}

fn checked<E: de::Error>(band: Band) -> Result<Band, E> {
    match (band.lower, band.upper) {
        (Some(lower), Some(upper)) if lower > upper => Err(E::custom(format_args!(
            "the band's lower end {lower} is above its upper end {upper}"
        ))),
        (None, None) => Err(E::custom("a band needs `at_most`, `at_least` or both")),
        _ => Ok(band),
    }
}

impl JsonSchema for Band {
    fn schema_name() -> Cow<'static, str> {
        "Band".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = json_schema!({ "type": "number" });
        json_schema!({
            "description": "A band, ends included: `[lower, upper]`, `{ at_most = x }` or `{ at_least = x }`.",
            "anyOf": [
                { "type": "array", "items": number, "minItems": 2, "maxItems": 2 },
                {
                    "type": "object",
                    "properties": { "at_least": number, "at_most": number },
                    "minProperties": 1,
                    "additionalProperties": false
                }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Band;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Holder {
        band: Band,
    }

    fn read(text: &str) -> Result<Band, String> {
        toml::from_str::<Holder>(&format!("band = {text}"))
            .map(|holder| holder.band)
            .map_err(|error| error.message().to_owned())
    }

    #[test]
    fn three_forms_are_read() {
        assert_eq!(read("[-0.25, 0.25]"), Ok(Band::new(-0.25, 0.25).unwrap()));
        assert_eq!(read("[0, 1]"), Ok(Band::new(0.0, 1.0).unwrap()));
        assert_eq!(read("{ at_most = 3 }"), Ok(Band::at_most(3.0)));
        assert_eq!(read("{ at_least = 0.9 }"), Ok(Band::at_least(0.9)));
        assert_eq!(read("{ at_least = 0, at_most = 1 }"), Ok(Band::new(0.0, 1.0).unwrap()));
    }

    #[test]
    fn nonsense_is_refused() {
        for bad in [
            "[1, 0]",
            "[1]",
            "[1, 2, 3]",
            "[-inf, 1]",
            "[nan, 1]",
            "3",
            "{}",
            "{ at_most = nan }",
            "{ at_most = 0, at_least = 1 }",
            "{ below = 1 }",
            "[\"a\", 1]",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn ends_are_included_and_nothing_but_numbers_is_inside() {
        let band = Band::new(-1.0, 1.0).unwrap();
        for (value, inside) in [
            (-1.0, true),
            (1.0, true),
            (1.000_000_1, false),
            (f64::NAN, false),
            (f64::INFINITY, false),
        ] {
            assert_eq!(band.contains(value), inside, "{value}");
        }
        assert!(!Band::at_least(0.0).contains(f64::INFINITY));
        // 0.30000000000000004
        assert!(Band::at_most(0.3).contains(0.1 * 3.0));
    }
}
