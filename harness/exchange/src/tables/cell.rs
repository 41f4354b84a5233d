//! Cells, rows and columns of tables, independent of the file format.

use std::borrow::Cow;
use wire::time::Timestamp;

wire::tabled! {
    /// Type of the values of a column.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Kind {
        /// Real numbers in the column's unit.
        Float = "number",
        Integer = "integer",
        Bool = "boolean",
        Text = "string",
    }
    /// Its name in JSON Schema and in Frictionless' table schema.
    pub fn json_type() -> &'static str
}

#[derive(Debug, Clone, PartialEq)]
pub enum Cell<'a> {
    /// Unknown: empty in CSV, null in Parquet, absent in JSON.
    Missing,
    /// In a [`Kind::Float`] column. A non-finite value counts as missing, because tools treat it differently.
    Float(f64),
    /// In a [`Kind::Integer`] column.
    Integer(i64),
    /// In a [`Kind::Bool`] column.
    Bool(bool),
    /// In a [`Kind::Text`] column.
    Text(Cow<'a, str>),
}

impl<'a> Cell<'a> {
    /// Text, borrowed or owned. Empty text is missing: CSV cannot tell the two apart.
    pub fn text(text: impl Into<Cow<'a, str>>) -> Self {
        let text = text.into();
        if text.is_empty() { Self::Missing } else { Self::Text(text) }
    }

    /// A count; missing if it does not fit into an `i64`.
    pub fn count(count: u64) -> Self {
        i64::try_from(count).map_or(Self::Missing, Self::Integer)
    }

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

pub type Row<'a> = Vec<Cell<'a>>;

pub(crate) fn time<'a>(at: Timestamp) -> Cell<'a> {
    at.as_secs_f64().into()
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name, unique in its table. It ends in the unit, if there is one: `x_m`, `heading_deg`.
    pub name: Cow<'static, str>,
    pub kind: Kind,
    /// Unit of its values, as in plans (`deg/s`); empty without a unit.
    pub unit: Cow<'static, str>,
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

    /// A column of numbers whose name comes from a plan or a record. Any character other than a letter or digit becomes
    /// `_`, and the unit is appended: `during.lap` is `during_lap`, `temperature` in degC `temperature_celsius`.
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

/// A unit as part of a name: only letters, digits and `_`.
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
