//! The notation of a property in a plan: a formula, or a built-in one.

use super::property::{Always, Kind, Property, Sometimes, Stated};
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;

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

wire::either! { OrFormula<Always>, "a formula over signals, or a property such as { recovers = {} }",
    text(text) => Ok(match Always::ALL.iter().find(|known| known.name() == text) {
        Some(known) => OrFormula::BuiltIn(*known),
        None => OrFormula::Formula(text.to_owned()),
    }),
    map(map) => Always::deserialize(map).map(OrFormula::BuiltIn),
}

wire::either! { OrFormula<Sometimes>, "a formula over signals, or a state such as \"gyro_silent\"",
    text(text) => match Sometimes::ALL.iter().find(|known| known.name() == text) {
        Some(known) => Ok(OrFormula::BuiltIn(*known)),
        None if is_name(text) => Err(serde::de::Error::unknown_variant(text, &Sometimes::NAMES)),
        None => Ok(OrFormula::Formula(text.to_owned())),
    },
    map(map) => Sometimes::deserialize(map).map(OrFormula::BuiltIn),
}

/// A name has neither spaces nor operators.
fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
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
