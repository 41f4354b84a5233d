//! One signal of a message.

use super::bits::BitField;
use super::number::{Coding, Scale};
use super::printed::Format;

/// How far a printed number may lie beside the range that it rounds into, in units of the last decimal.
const PRINTED_SLACK: f64 = 0.5 + 1e-6;

/// A number in a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name, unique within its message.
    pub name: String,
    /// Unit of its values, as the file writes it; empty where it has none.
    pub unit: String,
    /// The least value that is sent, in its unit.
    pub minimum: f64,
    /// The greatest value that is sent, in its unit.
    pub maximum: f64,
    /// What the file says of it.
    pub doc: String,
    /// Which of the message's frames carry it.
    pub carried: Carried,
    /// Names of values, as far as the file has any: the number on the wire and its name.
    pub named_values: Vec<(i64, String)>,
    /// Its value before anything says another, in its unit (`GenSigStartValue` of a DBC).
    pub start: f64,
    pub(super) scale: Scale,
    pub(super) storage: Storage,
}

/// Which frames of a message carry a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carried {
    /// Each.
    Always,
    /// Each, and its number on the wire says which multiplexed signals the frame has.
    Multiplexer,
    /// Those whose multiplexer has this number.
    When(u64),
}

/// How a signal's number is in its message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Storage {
    Bits { field: BitField, coding: Coding },
    Printed { format: Format },
}

impl Signal {
    /// The difference that one count makes, in its unit; zero for floating-point numbers.
    pub fn resolution(&self) -> f64 {
        let step = match self.storage {
            Storage::Bits { coding, .. } if coding.is_float() => 0.0,
            Storage::Bits { .. } => 1.0,
            Storage::Printed { format } => format.resolution(),
        };
        step * self.scale.factor.abs()
    }

    /// The name of `value` where the file has one.
    pub fn name_of(&self, value: f64) -> Option<&str> {
        let number = libm::round(self.scale.number(value));
        self.named_values
            .iter()
            .find(|(named, _)| *named as f64 == number)
            .map(|(_, name)| name.as_str())
    }

    /// The values that have a name, in its unit.
    pub fn names(&self) -> impl Iterator<Item = (&str, f64)> {
        let value = |number: i64| self.scale.physical(number as f64);
        self.named_values.iter().map(move |(number, name)| (name.as_str(), value(*number)))
    }

    /// Writes the value into the bytes of its message; `false` where it is out of range.
    pub(super) fn put(&self, value: f64, data: &mut [u8]) -> bool {
        let Storage::Bits { field, coding } = self.storage else { return true };
        let range = (self.minimum, self.maximum);
        let raw = coding.raw(value, field.length(), self.scale, range);
        raw.map(|raw| field.set(data, raw)).is_some()
    }

    /// The number that is printed for the value; `None` where it is out of range.
    pub(super) fn printed(&self, value: f64) -> Option<f64> {
        let slack = PRINTED_SLACK * self.resolution();
        (self.minimum - slack..=self.maximum + slack)
            .contains(&value)
            .then(|| self.scale.number(value))
    }

    /// The value in the bytes of its message.
    pub(super) fn read(&self, data: &[u8]) -> f64 {
        match self.storage {
            Storage::Bits { field, coding } => {
                self.scale.physical(coding.number(field.get(data), field.length()))
            }
            Storage::Printed { .. } => f64::NAN,
        }
    }

    /// The number on the wire that a multiplexer has in these bytes.
    pub(super) fn selector(&self, data: &[u8]) -> u64 {
        match self.storage {
            Storage::Bits { field, .. } => field.get(data),
            Storage::Printed { .. } => 0,
        }
    }

    /// The value whose number on the wire is `selector`.
    pub(crate) fn selecting(&self, selector: u64) -> f64 {
        self.scale.physical(selector as f64)
    }

    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let together = match (self.carried, other.carried) {
            (Carried::When(one), Carried::When(another)) => one == another,
            _ => true,
        };
        match (self.storage, other.storage) {
            (Storage::Bits { field, .. }, Storage::Bits { field: another, .. }) => {
                together && field.overlaps(another)
            }
            _ => false,
        }
    }
}
