//! Drivers: a field of the data, or a function of one, in the form of the contract.

use crate::problem::Channels;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// The function of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Wrap {
    /// The field itself.
    Plain,
    /// Its rate of change with time.
    RateOf,
    /// The field through a first-order lag.
    LagOf,
    /// The field through play: the branch of a hysteresis.
    BranchOf,
    /// Absolute value of the field.
    Abs,
    /// Sign of the field.
    Sign,
    /// Cosine and sine of that multiple of an angle, 1 to [`Wrap::HARMONICS`].
    Harmonic(u8),
    /// Zero before a time, one after it.
    Step,
    /// Cosine and sine of a period.
    Periodic,
    /// Growth with time.
    Trend,
}

impl Wrap {
    /// Maximum cycles per turn.
    pub const HARMONICS: u8 = 32;

    const WRAPPED: [(Self, &'static str); 8] = [
        (Self::RateOf, "rate_of"),
        (Self::LagOf, "lag_of"),
        (Self::BranchOf, "branch_of"),
        (Self::Abs, "abs"),
        (Self::Sign, "sign"),
        (Self::Step, "step"),
        (Self::Periodic, "periodic"),
        (Self::Trend, "trend"),
    ];

    /// The function of that name.
    fn parse(name: &str) -> Option<Self> {
        if let Some(order) = name.strip_prefix("harmonic_") {
            let order = order.parse().ok().filter(|order| (1..=Self::HARMONICS).contains(order));
            return order.map(Self::Harmonic);
        }
        Self::WRAPPED.into_iter().find(|(_, text)| *text == name).map(|(wrap, _)| wrap)
    }
}

/// What an effect depends on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Driver {
    /// The function.
    pub wrap: Wrap,
    /// Name of the field.
    pub field: String,
}

impl Driver {
    /// The field itself.
    pub fn plain(field: &str) -> Self {
        Self { wrap: Wrap::Plain, field: field.to_owned() }
    }

    /// The rotation itself.
    pub(crate) fn rotation(channels: &Channels) -> Self {
        Self::plain(&channels.rotation_name)
    }

    /// A function of the field.
    pub fn new(wrap: Wrap, field: &str) -> Self {
        Self { wrap, field: field.to_owned() }
    }

    /// Parses the form of the contract; `None` for an unknown function.
    pub fn parse(text: &str) -> Option<Self> {
        let Some(inner) = text.strip_suffix(')') else {
            return (!text.is_empty() && !text.contains('(')).then(|| Self::plain(text));
        };
        let (name, field) = inner.split_once('(')?;
        let wrap = Wrap::parse(name)?;
        (!field.is_empty() && !field.contains('(')).then(|| Self::new(wrap, field))
    }
}

impl fmt::Display for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Wrap::Harmonic(order) = self.wrap {
            return write!(f, "harmonic_{order}({})", self.field);
        }
        match Wrap::WRAPPED.into_iter().find(|(wrap, _)| *wrap == self.wrap) {
            None => f.write_str(&self.field),
            Some((_, name)) => write!(f, "{name}({})", self.field),
        }
    }
}

impl Serialize for Driver {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl JsonSchema for Driver {
    fn schema_name() -> Cow<'static, str> {
        "Driver".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let functions = Wrap::WRAPPED.map(|(_, name)| name).join("|");
        json_schema!({
            "description": "What an effect sees: a field of the data, or a function of one such as `rate_of(temperature)`.",
            "type": "string",
            "pattern": format!(r"^(?:[^()]+|(?:{functions}|harmonic_[0-9]+)\([^()]+\))$")
        })
    }
}

impl<'de> Deserialize<'de> for Driver {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| {
            serde::de::Error::custom(format_args!(
                "`{text}` is no driver, expected a field or a function of one such as `rate_of(temperature)`"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Driver;

    #[test]
    fn what_is_written_is_read() {
        for text in
            ["temperature", "rate_of(coil)", "harmonic_2(heading)", "harmonic_31(x)", "trend(time)"]
        {
            assert_eq!(Driver::parse(text).map(|d| d.to_string()).as_deref(), Some(text));
        }
        for text in [
            "",
            "f(x)",
            "harmonic_0(x)",
            "harmonic_33(x)",
            "rate_of()",
            "rate_of(rate_of(x))",
            "rate_of(x",
            "x)",
        ] {
            assert_eq!(Driver::parse(text), None, "{text}");
        }
    }
}
