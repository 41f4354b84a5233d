//! The seed of a run, as a plan states it.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

/// Seed of a run whose plan states none.
pub const SEED: u64 = 1;

/// A seed. Whole numbers of TOML end at 2^63 - 1: a larger seed is its digits, as a string.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed(pub u64);

impl Serialize for Seed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match i64::try_from(self.0) {
            Ok(small) => serializer.serialize_i64(small),
            Err(_) => serializer.serialize_str(&self.0.to_string()),
        }
    }
}

impl<'de> Deserialize<'de> for Seed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(u64),
            Digits(String),
        }
        let seed = match Written::deserialize(deserializer) {
            Ok(Written::Number(number)) => Some(number),
            Ok(Written::Digits(digits)) => digits.parse().ok(),
            Err(_) => None,
        };
        let expected = "no seed: expected a whole number, at least 0, or its digits as a string";
        seed.map(Self).ok_or_else(|| D::Error::custom(expected))
    }
}

impl JsonSchema for Seed {
    fn schema_name() -> Cow<'static, str> {
        "Seed".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{ "type": "integer", "minimum": 0 }, { "type": "string", "pattern": "^[0-9]+$" }]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Seed;

    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    struct Plan {
        seed: Seed,
    }

    #[test]
    fn every_seed_comes_back_from_a_file() {
        for seed in [0, 1, i64::MAX as u64, i64::MAX as u64 + 1, u64::MAX] {
            let text = toml::to_string(&Plan { seed: Seed(seed) }).unwrap();
            assert_eq!(toml::from_str::<Plan>(&text).unwrap().seed.0, seed, "{text}");
        }
        for wrong in ["-1", "1.5", "\"7a\"", "\"18446744073709551616\"", "true"] {
            let error = toml::from_str::<Plan>(&format!("seed = {wrong}")).unwrap_err();
            assert!(error.message().starts_with("no seed"), "{wrong}: {error}");
        }
    }
}
