//! Cells and columns: what a table is made of, whatever file it goes into.

use std::borrow::Cow;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Real numbers in the column's unit.
    Float,
    /// Whole numbers.
    Integer,
    /// Yes or no.
    Bool,
    /// UTF-8.
    Text,
}

impl Kind {
    /// Its name in JSON Schema and in Frictionless' table schema.
    pub const fn json_type(self) -> &'static str {
        match self {
            Self::Float => "number",
            Self::Integer => "integer",
            Self::Bool => "boolean",
            Self::Text => "string",
        }
    }
}

/// One value, of the kind of its column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell<'a> {
    /// Not known: empty in CSV, null in Parquet, absent in JSON.
    Missing,
    /// Of a [`Kind::Float`] column. What is not finite counts as missing: no tool treats it alike.
    Float(f64),
    /// Of a [`Kind::Integer`] column.
    Integer(i64),
    /// Of a [`Kind::Bool`] column.
    Bool(bool),
    /// Of a [`Kind::Text`] column.
    Text(Cow<'a, str>),
}

impl<'a> Cell<'a> {
    /// Text, borrowed or owned. Empty text is missing: CSV does not tell the two apart.
    pub fn text(text: impl Into<Cow<'a, str>>) -> Self {
        let text = text.into();
        if text.is_empty() { Self::Missing } else { Self::Text(text) }
    }

    /// A count; more than an `i64` holds is not known.
    pub fn count(count: u64) -> Self {
        i64::try_from(count).map_or(Self::Missing, Self::Integer)
    }

    /// A number, where there is one.
    pub fn maybe(number: Option<f64>) -> Self {
        number.map_or(Self::Missing, Self::from)
    }
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Float(number) } else { Self::Missing }
    }
}

impl From<bool> for Cell<'_> {
    fn from(yes: bool) -> Self {
        Self::Bool(yes)
    }
}

/// A column: its name, what it holds, and what that means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name, unique in its table. It ends in its unit where it has one: `x_m`, `heading_deg`.
    pub name: Cow<'static, str>,
    /// What it holds.
    pub kind: Kind,
    /// Unit of its values, as in plans (`deg/s`); empty where it has none.
    pub unit: Cow<'static, str>,
    /// What it is.
    pub doc: Cow<'static, str>,
}

impl Column {
    /// A column whose name already ends in its unit.
    pub const fn new(
        name: &'static str,
        kind: Kind,
        unit: &'static str,
        doc: &'static str,
    ) -> Self {
        let (name, unit, doc) = (Cow::Borrowed(name), Cow::Borrowed(unit), Cow::Borrowed(doc));
        Self { name, kind, unit, doc }
    }

    /// A column of numbers whose name comes from a plan or a record. Whatever is no letter or digit becomes `_`, and the
    /// unit is put behind it: `during.lap` is `during_lap`, `temperature` in degC `temperature_celsius`.
    pub fn measured(name: &str, unit: &str, doc: String) -> Self {
        let unit = if unit == "1" { "" } else { unit };
        let plain =
            |character: char| if character.is_ascii_alphanumeric() { character } else { '_' };
        let name: String = name.chars().map(plain).collect();
        Self {
            name: with_unit(&name, unit).into(),
            kind: Kind::Float,
            unit: unit.to_owned().into(),
            doc: doc.into(),
        }
    }

    /// What it is, with its unit.
    pub fn described(&self) -> String {
        match &*self.unit {
            "" => self.doc.to_string(),
            unit => format!("{}, in {unit}", self.doc),
        }
    }
}

/// `temperature` and `degC` give `temperature_celsius`, `rate` and `deg/s` give `rate_deg_per_s`.
pub fn with_unit(name: &str, unit: &str) -> String {
    let words = unit_in_words(unit);
    if words.is_empty() || name.ends_with(&format!("_{words}")) {
        return name.to_owned();
    }
    format!("{name}_{words}")
}

/// A unit as it stands in a name: letters, digits and `_` alone.
fn unit_in_words(unit: &str) -> String {
    match unit {
        "" | "1" => return String::new(),
        "degC" | "Cel" | "°C" => return "celsius".to_owned(),
        "%" => return "percent".to_owned(),
        _ => {}
    }
    let mut words = String::new();
    for character in unit.chars() {
        match character {
            '/' => words.push_str("_per_"),
            '°' => words.push_str("deg"),
            'µ' | 'μ' => words.push('u'),
            '^' => {}
            other if other.is_ascii_alphanumeric() => words.push(other),
            _ if words.ends_with('_') => {}
            _ => words.push('_'),
        }
    }
    words.trim_matches('_').to_owned()
}

#[cfg(test)]
mod tests {
    use super::{Cell, with_unit};

    #[test]
    fn names_end_in_their_units() {
        let named = |(name, unit)| with_unit(name, unit);
        let found = [
            ("x", "m"),
            ("rate", "deg/s"),
            ("acceleration", "deg/s^2"),
            ("temperature", "degC"),
            ("share", "%"),
            ("run", "1"),
            ("duty", ""),
            ("x_m", "m"),
            ("odd", "\n,\""),
        ]
        .map(named);
        let expected = [
            "x_m",
            "rate_deg_per_s",
            "acceleration_deg_per_s2",
            "temperature_celsius",
            "share_percent",
            "run",
            "duty",
            "x_m",
            "odd",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn what_is_no_number_is_missing() {
        assert_eq!(Cell::from(f64::NAN), Cell::Missing);
        assert_eq!(Cell::from(f64::INFINITY), Cell::Missing);
        assert_eq!(Cell::count(u64::MAX), Cell::Missing);
    }
}
