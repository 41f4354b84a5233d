//! A number with its unit, as a person writes it: `1.5 deg`.
//!
//! The unit is mandatory: a reading in millimetres taken for metres spoils a day. An answer in another unit of the same
//! dimension is converted to the unit of the plan.

use identification::dataset::Unit;
use plan::{Answer, Band};
use record::figures;

/// Longest answer, in bytes. A number with all its digits and a unit has 30.
pub const ANSWER_BYTES_MAX: usize = 64;

/// The unit of a plain number.
const ONE: &str = "1";

/// Everyday units that data packages lack: each with a package unit and the factor to it.
const EVERYDAY: [(&str, Unit, f64); 11] = [
    ("mm", Unit::Metre, 1e-3),
    ("cm", Unit::Metre, 1e-2),
    ("mm/s", Unit::MetrePerSecond, 1e-3),
    ("ms", Unit::Second, 1e-3),
    ("min", Unit::Second, 60.0),
    ("h", Unit::Second, 3_600.0),
    ("mrad", Unit::Radian, 1e-3),
    ("degC", Unit::Celsius, 1.0),
    ("mV", Unit::Volt, 1e-3),
    ("mA", Unit::Ampere, 1e-3),
    ("%", Unit::One, 1e-2),
];

/// Why an answer is refused. The message is for the person who gave it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Nothing was typed.
    #[error("nothing was given, expected a number{}, {range}", in_unit(unit))]
    Empty {
        unit: String,
        /// Allowed range.
        range: Band,
    },
    /// Longer than any number.
    #[error("longer than {ANSWER_BYTES_MAX} bytes, expected a number{}", in_unit(unit))]
    TooLong { unit: String },
    /// A decimal comma, or a thousands separator.
    #[error("a comma in \"{text}\", expected a decimal point")]
    Comma { text: String },
    /// The text does not begin with a finite number.
    #[error("\"{text}\" is no number, expected one{} such as \"{example}\"", in_unit(unit))]
    NoNumber { text: String, unit: String, example: String },
    #[error("no unit, expected a number in {unit} such as \"{number} {unit}\"")]
    NoUnit { number: String, unit: String },
    /// The unit has another dimension.
    #[error("\"{given}\" is no unit for this, expected {unit}")]
    OtherUnit {
        /// The text.
        given: String,
        unit: String,
    },
    #[error("{value} is out of range, expected {}", figures::with_unit(range.to_string(), unit))]
    OutOfRange {
        /// The value and its unit.
        value: String,
        range: Band,
        unit: String,
    },
}

/// Reads `text` as a value in the unit of `answer`.
///
/// # Errors
/// When the text is not a number, has no unit or a wrong one, or is out of range.
pub fn read(text: &str, answer: &Answer) -> Result<f64, Refusal> {
    let unit = &answer.unit;
    let (number, given) = split(text.trim(), answer)?;
    let value = match given {
        "" if unit == ONE => number,
        "" => {
            let number = figures::value(number, 0.0);
            return Err(Refusal::NoUnit { number, unit: unit.clone() });
        }
        given => convert(number, given, unit)
            .ok_or_else(|| Refusal::OtherUnit { given: given.to_owned(), unit: unit.clone() })?,
    };
    in_range(value, answer).map(|()| value).map_err(|refusal| match refusal {
        // The number as written, so that the person notices a wrong unit.
        Refusal::OutOfRange { range, unit, .. } if given != unit => {
            Refusal::OutOfRange { value: text.trim().to_owned(), range, unit }
        }
        refusal => refusal,
    })
}

/// Like [`read`] with an optional unit, for places whose documentation defines it.
///
/// # Errors
/// As for [`read`].
pub fn read_unit_implied(text: &str, answer: &Answer) -> Result<f64, Refusal> {
    match split(text.trim(), answer)? {
        (value, "") => in_range(value, answer).map(|()| value),
        _ => read(text, answer),
    }
}

/// ` in deg`, or nothing for a plain number.
pub(super) fn in_unit(unit: &str) -> String {
    if unit == ONE { String::new() } else { format!(" in {unit}") }
}

fn in_range(value: f64, answer: &Answer) -> Result<(), Refusal> {
    let Answer { unit, range, .. } = answer;
    if range.contains(value) {
        return Ok(());
    }
    let value = figures::quantity(value, 0.0, unit);
    Err(Refusal::OutOfRange { value, range: *range, unit: unit.clone() })
}

/// A finite number, and the text after it.
fn split<'t>(text: &'t str, answer: &Answer) -> Result<(f64, &'t str), Refusal> {
    let Answer { unit, range, .. } = answer;
    if text.is_empty() {
        return Err(Refusal::Empty { unit: unit.clone(), range: *range });
    }
    if text.len() > ANSWER_BYTES_MAX {
        return Err(Refusal::TooLong { unit: unit.clone() });
    }
    if text.contains(',') {
        return Err(Refusal::Comma { text: text.to_owned() });
    }
    let numeric = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    let end = text.find(|c| !numeric(c)).unwrap_or(text.len());
    // The longest prefix that is a number: the e of "5e" is not an exponent.
    let number = (1..=end).rev().find_map(|end| {
        let (number, rest) = text.split_at_checked(end)?;
        number.parse::<f64>().ok().map(|value| (value, rest.trim()))
    });
    number.filter(|(value, _)| value.is_finite()).ok_or_else(|| Refusal::NoNumber {
        text: text.to_owned(),
        unit: unit.clone(),
        example: figures::quantity(example(*range), 0.0, unit),
    })
}

/// A number in the range.
fn example(range: Band) -> f64 {
    match (range.lower(), range.upper()) {
        (Some(lower), Some(upper)) => lower.midpoint(upper),
        (Some(end), None) | (None, Some(end)) => end,
        (None, None) => 1.5,
    }
}

fn convert(number: f64, from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(number);
    }
    let ((from, scale_from), (to, scale_to)) = (known(from)?, known(to)?);
    (from.dimension() == to.dimension()).then(|| number * scale_from / scale_to)
}

/// A known unit, with its factor to SI.
fn known(text: &str) -> Option<(Unit, f64)> {
    if let Some(unit) = Unit::parse(text) {
        return Some((unit, unit.si()));
    }
    let (_, unit, scale) = EVERYDAY.iter().find(|(everyday, ..)| *everyday == text)?;
    Some((*unit, scale * unit.si()))
}
