//! The notation of a property in a plan: a formula, or a built-in one.

use super::property::{Always, Kind, Property, Sometimes, Stated};
use schemars::JsonSchema;
use serde::de::{Error as _, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;

/// As a plan has it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Property")]
struct Entry {
    /// What verdicts and reports call a formula. Its text, where this is left out.
    name: Option<String>,
    /// It must hold at every moment of every run: a formula over signals, or a property of the paper's robot.
    always: Option<OrFormula<Always>>,
    /// It must come about in at least one run of a campaign: a formula over signals, or a state of the paper's robot.
    sometimes: Option<OrFormula<Sometimes>>,
}

/// A text is a formula, unless it is the name of what is built in.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum OrFormula<T> {
    BuiltIn(T),
    Formula(String),
}

/// A set of built-in properties, recognised by name.
trait BuiltIn: Sized {
    const EXPECTED: &'static str;

    /// The meaning of a text: a name has neither spaces nor operators.
    fn of_text<E: serde::de::Error>(text: &str) -> Result<OrFormula<Self>, E>;
}

impl BuiltIn for Always {
    const EXPECTED: &'static str =
        "a formula over signals, or a property such as { recovers = {} }";

    fn of_text<E: serde::de::Error>(text: &str) -> Result<OrFormula<Self>, E> {
        match Self::ALL.iter().find(|known| known.name() == text) {
            Some(known) => Ok(OrFormula::BuiltIn(*known)),
            None => Ok(OrFormula::Formula(text.to_owned())),
        }
    }
}

impl BuiltIn for Sometimes {
    const EXPECTED: &'static str = "a formula over signals, or a state such as \"gyro_silent\"";

    fn of_text<E: serde::de::Error>(text: &str) -> Result<OrFormula<Self>, E> {
        if let Some(known) = Self::ALL.iter().find(|known| known.name() == text) {
            return Ok(OrFormula::BuiltIn(*known));
        }
        if !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(E::unknown_variant(text, &Self::NAMES));
        }
        Ok(OrFormula::Formula(text.to_owned()))
    }
}

impl<'de, T: BuiltIn + Deserialize<'de>> Deserialize<'de> for OrFormula<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<T>(std::marker::PhantomData<T>);
        impl<'de, T: BuiltIn + Deserialize<'de>> Visitor<'de> for Either<T> {
            type Value = OrFormula<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(T::EXPECTED)
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                T::of_text(text)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(OrFormula::BuiltIn)
            }
        }
        deserializer.deserialize_any(Either(std::marker::PhantomData))
    }
}

impl<'de> Deserialize<'de> for Property {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Entry { name, always, sometimes } = Entry::deserialize(deserializer)?;
        let stated = |kind, formula: String| {
            let name = name.clone().unwrap_or_else(|| formula.clone());
            Self::Stated(Stated { name, kind, formula })
        };
        let property = match (always, sometimes) {
            (Some(OrFormula::Formula(formula)), None) => stated(Kind::Always, formula),
            (None, Some(OrFormula::Formula(formula))) => stated(Kind::Sometimes, formula),
            (Some(OrFormula::BuiltIn(always)), None) => Self::Always(always),
            (None, Some(OrFormula::BuiltIn(sometimes))) => Self::Sometimes(sometimes),
            (None, None) => return Err(D::Error::custom("missing field `always` or `sometimes`")),
            (Some(_), Some(_)) => {
                return Err(D::Error::custom(
                    "`always` beside `sometimes`: make it two properties",
                ));
            }
        };
        match (&property, name) {
            (Self::Stated(Stated { name, .. }), _) if name.trim().is_empty() => {
                Err(D::Error::custom("an empty property"))
            }
            (Self::Stated(_), _) | (_, None) => Ok(property),
            (_, Some(_)) => Err(D::Error::custom(format!(
                "`name` beside `{}`, which has its own: leave it out",
                property.name()
            ))),
        }
    }
}

impl JsonSchema for Property {
    fn schema_name() -> Cow<'static, str> {
        Entry::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        Entry::json_schema(generator)
    }
}
