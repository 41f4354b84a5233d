//! What faults strike, by name.

use crate::Name;
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// The target of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// The gyro or its line.
    Gyro,
    /// The base or its line or bus.
    Base,
    /// The table or its line.
    Table,
    /// The computer that runs the controller or the program under test.
    Host,
    /// The person who answers questions.
    Operator,
    /// The only device of a plan, or its line or bus.
    Device,
    /// All traffic of a node of a rig, all traffic on a line, or a message or signal of a node, by name.
    Node(TargetName),
}

/// The name of a node or a line, or of a message or signal of a node (`cells.CellStatus`, `cells.VoltageMax`,
/// `cells.CellStatus.VoltageMax`); small enough to be `Copy`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct TargetName {
    length: u8,
    /// Length of the node's name.
    node: u8,
    bytes: [u8; Self::LEN_MAX],
}

impl TargetName {
    /// Longest name: a node, a message and a signal.
    pub const LEN_MAX: usize = 31 + 2 * (1 + 64);

    /// `None` if `text` is neither a [`Name`] nor a name followed by a message or signal, or if it is too long.
    pub fn new(text: &str) -> Option<Self> {
        let (node, part) = match text.split_once('.') {
            Some((node, part)) => (node, Some(part)),
            None => (text, None),
        };
        Name::new(node)?;
        let is_word = |word: &str| {
            let rest = |c: char| c.is_alphanumeric() || c == '_';
            !word.is_empty() && word.chars().all(rest)
        };
        if part.is_some_and(|part| !part.split('.').all(is_word)) {
            return None;
        }
        let mut bytes = [0; Self::LEN_MAX];
        bytes.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
        Some(Self { length: text.len() as u8, node: node.len() as u8, bytes })
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        // The bytes come from a `str`.
        str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }

    /// The node or the line.
    pub fn node(&self) -> &str {
        self.as_str().get(..usize::from(self.node)).unwrap_or_default()
    }

    /// The message or signal of the node, if given.
    pub fn part(&self) -> Option<&str> {
        self.as_str().get(usize::from(self.node) + 1..)
    }
}

impl fmt::Debug for TargetName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl Target {
    /// The targets of every rig with the paper's robot or a single device; all others are names of nodes and lines.
    const KNOWN: [Self; 6] =
        [Self::Gyro, Self::Base, Self::Table, Self::Host, Self::Operator, Self::Device];

    /// Its name in a plan.
    pub fn name(&self) -> &str {
        match self {
            Self::Gyro => "gyro",
            Self::Base => "base",
            Self::Table => "table",
            Self::Host => "host",
            Self::Operator => "operator",
            Self::Device => "device",
            Self::Node(name) => name.as_str(),
        }
    }

    /// The node or line that the fault concerns; for the known targets, their whole name.
    pub fn node(&self) -> &str {
        match self {
            Self::Node(name) => name.node(),
            known => known.name(),
        }
    }

    /// The message or signal of a node, if given.
    pub fn part(&self) -> Option<&str> {
        match self {
            Self::Node(name) => name.part(),
            _ => None,
        }
    }

    /// The target with this name; `None` if it is not a valid name.
    pub fn named(name: &str) -> Option<Self> {
        let known = Self::KNOWN.into_iter().find(|known| known.name() == name);
        known.or_else(|| TargetName::new(name).map(Self::Node))
    }
}

impl Serialize for Target {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Target {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::named(&name).ok_or_else(|| {
            let known = Self::KNOWN.map(|known| format!("`{}`", known.name())).join(", ");
            D::Error::custom(format_args!(
                "unknown variant `{name}`, expected one of {known}, or the name of a node or a line, or of a message or signal of a \
                 node"
            ))
        })
    }
}

impl JsonSchema for Target {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Target".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let known: Vec<String> = Self::KNOWN.iter().map(|known| known.name().to_owned()).collect();
        schemars::json_schema!({
            "type": "string",
            "description": "What a fault strikes: one of these, or a node or a line of the rig by its name, or a message or \
                            signal of a node (`cells.CellStatus`, `cells.VoltageMax`).",
            "anyOf": [{ "enum": known }, { "pattern": "^[a-z][a-z0-9_-]{0,30}(\\.\\w+){0,2}$" }],
        })
    }
}
