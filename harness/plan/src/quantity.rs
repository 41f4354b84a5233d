//! Names of quantities in a plan, and filters on their observations.

mod schema;

use super::band::Band;
use super::name::{EXPECTED_NAME, Name};
use super::quantities::{
    self, CHOSEN, NAMES, OPERATOR_PREFIX, Quantity, REACTION_PREFIX, SDO_PREFIX, UDS_PREFIX,
    UNEXPECTED_PREFIX,
};
use super::speakers::OfMessage;
use serde::{Deserialize, Deserializer, de};
use std::collections::BTreeMap;
use std::fmt;

/// The name of a quantity: one of [`quantities::QUANTITIES`], `operator.<answer>`, `reaction.<name>`, `uds.<name>`,
/// `sdo.<name>`, `unexpected.<line>`, or, for the messages of a rig, `<node>.<signal>`, `<node>.<message>.<signal>` and
/// `period.<node>.<message>`. In a plan with a single device these are `signal.<signal>` and `period.<message>`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct QuantityName(String);

impl QuantityName {
    /// `None` if there is no such quantity.
    pub fn new(name: &str) -> Option<Self> {
        let chosen =
            |(prefix, _): &(&str, &str)| name.strip_prefix(prefix).and_then(Name::new).is_some();
        let known = CHOSEN.iter().any(chosen) || quantities::find(name).is_some();
        (known || OfMessage::of(name).is_some()).then(|| Self(name.to_owned()))
    }

    /// The part of a node's messages that it refers to; `None` if it is in the table or an operator gives it.
    pub fn of_message(&self) -> Option<OfMessage<'_>> {
        let known = self.is_chosen() || self.entry().is_some();
        if known { None } else { OfMessage::of(&self.0) }
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Its entry in the table; `None` for an operator's answer.
    pub fn entry(&self) -> Option<&'static Quantity> {
        quantities::find(&self.0)
    }

    /// The reaction's name, if it is a reaction time.
    pub fn reaction(&self) -> Option<&str> {
        self.0.strip_prefix(REACTION_PREFIX)
    }

    /// The step, `sdo` or `uds`, and the name that it gives to what it reads, if a step reads this quantity.
    pub fn read(&self) -> Option<(&'static str, &str)> {
        let of = |prefix: &'static str| {
            Some((prefix.trim_end_matches('.'), self.0.strip_prefix(prefix)?))
        };
        [SDO_PREFIX, UDS_PREFIX].into_iter().find_map(of)
    }

    /// The line, if it is what came there unexpectedly.
    pub fn line(&self) -> Option<&str> {
        self.0.strip_prefix(UNEXPECTED_PREFIX)
    }

    /// Whether the plan or its rig chooses the last part of its name.
    pub(crate) fn is_chosen(&self) -> bool {
        CHOSEN.iter().any(|(prefix, _)| self.0.starts_with(prefix))
    }

    /// The answer's name, if an operator gives this quantity.
    pub fn operator_answer(&self) -> Option<&str> {
        self.0.strip_prefix(OPERATOR_PREFIX)
    }
}

impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for QuantityName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::new(&name).ok_or_else(|| {
            if let Some(node) = OfMessage::misnamed(&name) {
                return de::Error::custom(format_args!(
                    "`{node}` cannot be the name of a node, expected {EXPECTED_NAME}"
                ));
            }
            let known = NAMES.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            de::Error::custom(format_args!("unknown quantity `{name}`, expected one of {known}"))
        })
    }
}

/// Selects the observations of a quantity whose tags all match. In a file:
/// `where = { direction = -1, temperature = [20, 30] }`.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(transparent)]
pub struct Filter(BTreeMap<String, TagMatch>);

/// The condition on one tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TagMatch {
    /// This number.
    Equal(f64),
    /// In this band.
    Within(Band),
}

impl Filter {
    /// Whether every tag is present and matches.
    pub fn matches(&self, tag_of: impl Fn(&str) -> Option<f64>) -> bool {
        self.0.iter().all(|(tag, wanted)| {
            tag_of(tag).is_some_and(|value| match wanted {
                TagMatch::Equal(number) => value == *number,
                TagMatch::Within(band) => band.contains(value),
            })
        })
    }

    /// The tags that must have one exact value.
    pub fn equalities(&self) -> BTreeMap<String, f64> {
        let equal = |(tag, wanted): (&String, &TagMatch)| match wanted {
            TagMatch::Equal(number) => Some((tag.clone(), *number)),
            TagMatch::Within(_) => None,
        };
        self.0.iter().filter_map(equal).collect()
    }

    /// The tags in the filter.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

wire::either! { TagMatch, "a number or a band",
    finite(value) => Ok(TagMatch::Equal(value)),
    list(list) => Band::deserialize(list).map(TagMatch::Within),
    map(map) => Band::deserialize(map).map(TagMatch::Within),
}

#[cfg(test)]
mod tests {
    use super::{Filter, QuantityName};
    use crate::observation::Observation;
    use std::collections::BTreeMap;

    #[test]
    fn a_filter_asks_for_every_tag() {
        let filter: Filter =
            toml::from_str("direction = -1\ntemperature = [20, 30]\nrun = { at_least = 2 }")
                .unwrap();
        for (direction, temperature, run, expected) in [
            (-1.0, 25.0, 2.0, true),
            (1.0, 25.0, 2.0, false),
            (-1.0, 31.0, 2.0, false),
            (-1.0, 25.0, 1.0, false),
            (-1.0, f64::NAN, 2.0, false),
        ] {
            let mut observation = Observation {
                quantity: "table.error".to_owned(),
                value: 0.0,
                uncertainty: 0.0,
                tags: [("direction", direction), ("temperature", temperature), ("run", run)]
                    .map(|(tag, value)| (tag.to_owned(), value))
                    .into(),
            };
            assert_eq!(filter.matches(|tag| observation.tag(tag)), expected);
            observation.tags.remove("run");
            assert!(!filter.matches(|tag| observation.tag(tag)), "a tag is absent");
        }
    }

    #[test]
    fn quantities_are_those_of_the_table_and_of_operators() {
        assert!(QuantityName::new("table.error").is_some());
        assert_eq!(QuantityName::new("operator.gap").unwrap().operator_answer(), Some("gap"));
        assert!(QuantityName::new("table.eror").unwrap().of_message().is_some());
        assert!(QuantityName::new("table.error").unwrap().of_message().is_none());
        assert!(QuantityName::new("eror").is_none());
        assert!(QuantityName::new("operator.").is_none());
    }

    #[test]
    fn a_node_in_capitals_is_told_the_rule_for_names() {
        let read = |name: &str| {
            let text = format!("q = \"{name}\"");
            toml::from_str::<BTreeMap<String, QuantityName>>(&text).unwrap_err().to_string()
        };
        for name in ["period.VCU.VcuCmd", "VCU.GearCmd"] {
            let told = read(name);
            assert!(told.contains("`VCU` cannot be the name of a node, expected a name"), "{told}");
        }
        assert!(read("eror").contains("unknown quantity `eror`"));
    }
}
