//! One signal of a message.

use super::number::{Coding, RANGE_SLACK_COUNTS, Scale};
use super::printed::Format;
use super::selection::Carried;
use crate::bits::BitField;
use crate::file::SignalValue;
use crate::hint;

/// Allowed excess of a printed number over the range into which it rounds, in units of the last decimal.
const PRINTED_SLACK: f64 = 0.5 + 1e-6;

/// A number in a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name, unique within its message.
    pub name: String,
    /// Unit of its values, as written in the file; may be empty.
    pub unit: String,
    /// The smallest value that is sent, in its unit.
    pub minimum: f64,
    /// The largest value that is sent, in its unit.
    pub maximum: f64,
    /// Documentation from the file.
    pub doc: String,
    /// Which of the message's frames carry it.
    pub carried: Carried,
    /// True for a multiplexer: its number on the wire selects the multiplexed signals of a frame.
    pub multiplexes: bool,
    /// Named values of the file: the number on the wire and its name.
    pub named_values: Vec<(i64, String)>,
    /// Its value until another is set, in its unit (`GenSigStartValue` of a DBC).
    pub start: f64,
    pub(super) scale: Scale,
    pub(super) storage: Storage,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Storage {
    Bits { field: BitField, coding: Coding },
    Printed { format: Format },
}

impl Signal {
    /// A signal of this range, in each frame, without a unit, documentation and named values.
    pub(super) fn new(
        name: String,
        (minimum, maximum): (f64, f64),
        scale: Scale,
        storage: Storage,
    ) -> Self {
        Self {
            name,
            unit: String::new(),
            minimum,
            maximum,
            doc: String::new(),
            carried: Carried::Always,
            multiplexes: false,
            named_values: Vec::new(),
            start: 0f64.clamp(minimum, maximum),
            scale,
            storage,
        }
    }

    /// The value in its unit.
    ///
    /// # Errors
    /// When it has no value of that name: what is wrong, and what to write instead.
    pub fn value_of(&self, value: &SignalValue) -> Result<f64, (String, String)> {
        let name = match value {
            SignalValue::Number(value) => return Ok(*value),
            SignalValue::Named(name) => name,
        };
        let names: Vec<(&str, f64)> = self.names().collect();
        if let Some((_, value)) = names.iter().find(|(known, _)| known == name) {
            return Ok(*value);
        }
        let help = if names.is_empty() {
            "its values have no names: write the number".to_owned()
        } else {
            let known: Vec<&str> = names.iter().map(|(known, _)| *known).collect();
            hint::proposal(name, &known)
        };
        Err((format!("`{}` has no value `{name}`", self.name), help))
    }

    /// Whether all of its bits are in the first `bytes` bytes of its message.
    pub(super) fn is_within(&self, bytes: usize) -> bool {
        match self.storage {
            Storage::Bits { field, .. } => *field.bytes().end() < bytes,
            Storage::Printed { .. } => true,
        }
    }

    /// The value of one count, in its unit; zero for floating-point numbers.
    pub fn resolution(&self) -> f64 {
        let step = match self.storage {
            Storage::Bits { coding, .. } if coding.is_float() => 0.0,
            Storage::Bits { .. } => 1.0,
            Storage::Printed { format } => format.resolution(),
        };
        step * self.scale.factor.abs()
    }

    /// The value that a receiver reads, where the signal counts in steps and `value` is between two of them: rounding
    /// would make half a switch a whole one.
    pub fn sent_instead_of(&self, value: f64) -> Option<f64> {
        let (sent, step) = (self.as_sent(value), self.resolution());
        (step > 0.0 && self.scale.is_another(sent, value, step)).then_some(sent)
    }

    /// Applies a declared range if its bits can represent a value in it; otherwise returns `false` and changes
    /// nothing.
    pub(super) fn narrow(&mut self, minimum: f64, maximum: f64) -> bool {
        let narrowed = (self.minimum.max(minimum), self.maximum.min(maximum));
        // Both comparisons are false for NaN.
        if !(minimum <= maximum && narrowed.0 <= narrowed.1) {
            return false;
        }
        let before = (self.minimum, self.maximum);
        (self.minimum, self.maximum) = narrowed;
        let is_within = self.holds(self.as_sent(self.nearest(narrowed.0)));
        if !is_within {
            (self.minimum, self.maximum) = before;
        }
        is_within
    }

    /// Sets the range to that of its bits.
    pub(super) fn widen(&mut self) {
        if let Storage::Bits { field, coding } = self.storage {
            let (least, greatest) = coding.limits(field.length());
            (self.minimum, self.maximum) = self.scale.range(least, greatest);
        }
    }

    /// The value clamped to the range, or moved to the next count or floating-point number inwards if rounding would
    /// leave the range.
    pub(super) fn nearest(&self, value: f64) -> f64 {
        let value = value.clamp(self.minimum, self.maximum);
        if self.holds(self.as_sent(value)) {
            return value;
        }
        let number = self.scale.number(value);
        let beside = match self.storage {
            Storage::Bits { coding: Coding::Float32, .. } => {
                let rounded = number as f32;
                [rounded.next_down(), rounded.next_up()].map(f64::from)
            }
            _ => [-1.0, 1.0].map(|step| libm::round(number) + step),
        };
        let beside = beside.map(|number| self.scale.physical(number));
        beside.into_iter().find(|value| self.holds(*value)).unwrap_or(value)
    }

    /// True if the value is in the range, apart from the rounding error of decimal fractions in binary.
    fn holds(&self, value: f64) -> bool {
        let slack = RANGE_SLACK_COUNTS * self.scale.factor.abs();
        (self.minimum - slack..=self.maximum + slack).contains(&value)
    }

    /// The name of `value`, if the file has one.
    pub fn name_of(&self, value: f64) -> Option<&str> {
        let number = libm::round(self.scale.number(value));
        self.named_values
            .iter()
            .find(|(named, _)| *named as f64 == number)
            .map(|(_, name)| name.as_str())
    }

    /// The named values, in its unit.
    pub fn names(&self) -> impl Iterator<Item = (&str, f64)> {
        let value = |number: i64| self.scale.physical(number as f64);
        self.named_values.iter().map(move |(number, name)| (name.as_str(), value(*number)))
    }

    /// Writes the value to the bytes of its message; `false` if it is out of range.
    pub(super) fn put(&self, value: f64, data: &mut [u8]) -> bool {
        let Storage::Bits { field, .. } = self.storage else { return true };
        self.number_of(value).map(|raw| field.set(data, raw)).is_some()
    }

    /// The number printed for the value; `None` if it is out of range.
    pub(super) fn printed(&self, value: f64) -> Option<f64> {
        let slack = PRINTED_SLACK * self.resolution();
        (self.minimum - slack..=self.maximum + slack)
            .contains(&value)
            .then(|| self.scale.number(value))
    }

    pub(super) fn read(&self, data: &[u8]) -> f64 {
        match self.storage {
            Storage::Bits { field, coding } => {
                self.scale.physical(coding.number(field.get(data), field.length()))
            }
            Storage::Printed { .. } => f64::NAN,
        }
    }

    /// The largest number on the wire, if that is an unsigned integer.
    pub(super) fn greatest_number(&self) -> Option<u64> {
        let Storage::Bits { coding: Coding::Unsigned, .. } = self.storage else { return None };
        self.number_of(self.maximum)
    }

    /// Number of bits; zero for a printed number.
    pub(super) const fn bits(&self) -> u32 {
        match self.storage {
            Storage::Bits { field, .. } => field.length(),
            Storage::Printed { .. } => 0,
        }
    }

    /// Its bits in these bytes.
    pub(super) fn selector(&self, data: &[u8]) -> u64 {
        match self.storage {
            Storage::Bits { field, .. } => field.get(data),
            Storage::Printed { .. } => 0,
        }
    }

    /// The bits that encode this value, as one number; `None` if it is out of range.
    pub fn number_of(&self, value: f64) -> Option<u64> {
        let Storage::Bits { field, coding } = self.storage else { return None };
        coding.raw(value, field.length(), self.scale, (self.minimum, self.maximum))
    }

    /// What stands on the line for this value, as one number that is another one for another text or other bits; `None` if
    /// the value is out of range.
    pub(crate) fn on_the_line(&self, value: f64) -> Option<u64> {
        match self.storage {
            Storage::Bits { .. } => self.number_of(value),
            // A negative zero is printed without its sign.
            Storage::Printed { format } => {
                self.printed(value).map(|number| format.rounded(number + 0.0).to_bits())
            }
        }
    }

    /// True if a received value is outside the range of a sender.
    pub fn is_out_of_range(&self, value: f64) -> bool {
        let is_within = self.minimum <= value && value <= self.maximum;
        // The end of a range may lie between two counts.
        !is_within
            && match self.storage {
                Storage::Bits { .. } => self.number_of(value).is_none(),
                Storage::Printed { .. } => self.printed(value).is_none(),
            }
    }

    /// The value that a receiver reads: the nearest that the bits can represent. Returns the value itself if it is out
    /// of range.
    pub fn as_sent(&self, value: f64) -> f64 {
        let number = match self.storage {
            Storage::Bits { field, coding } => {
                self.number_of(value).map(|raw| coding.number(raw, field.length()))
            }
            Storage::Printed { format } => self.printed(value).map(|number| format.rounded(number)),
        };
        number.map_or(value, |number| self.scale.physical(number))
    }

    /// The value whose bits are `selector`.
    pub fn selecting(&self, selector: u64) -> f64 {
        match self.storage {
            Storage::Bits { field, coding } => {
                self.scale.physical(coding.number(selector, field.length()))
            }
            Storage::Printed { .. } => self.scale.physical(selector as f64),
        }
    }

    /// True if its bits can represent this number.
    pub(super) fn reaches(&self, selector: u64) -> bool {
        match self.storage {
            Storage::Bits { field, .. } => field.reaches(selector),
            Storage::Printed { .. } => false,
        }
    }

    /// True if both have a bit in common, in any frames.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        match (self.storage, other.storage) {
            (Storage::Bits { field, .. }, Storage::Bits { field: another, .. }) => {
                field.overlaps(another)
            }
            _ => false,
        }
    }
}
