//! Errors in data packages: the place, the problem, and the expectation.

use super::thermometer::Scale;
use identification::dataset::{Kind, Role, Unit};
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A mistake in a data package, which makes all of it unusable.
#[derive(Debug)]
pub struct DatasetError(Box<Inner>);

#[derive(Debug)]
struct Inner {
    file: PathBuf,
    row: Option<Row>,
    field: Option<String>,
    defect: Defect,
    shown: Option<(NamedSource<String>, Range<usize>)>,
}

/// A row of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Number of the data row, from 1; 0 is the header.
    pub number: u64,
    /// Line of the file on which it begins, from 1; 0 in a file without lines.
    pub line: u64,
}

/// The problem.
#[derive(Debug, thiserror::Error)]
pub enum Defect {
    #[error("failed to read it: {0}")]
    Unreadable(#[source] io::Error),
    #[error("it holds more than {max} {what}")]
    TooLong {
        max: u64,
        /// The unit of the limit.
        what: &'static str,
    },
    #[error("it is no data package: {0}")]
    Json(#[source] serde_json::Error),
    #[error("{0} is missing")]
    NoProperty(&'static str),
    /// A word that the contract does not define.
    #[error("{what} `{}` is not known", shortened(found))]
    Unknown {
        /// What the word should be.
        what: &'static str,
        found: String,
        known: Vec<&'static str>,
    },
    #[error("{} is no unit of {}, expected one of {}", shortened(found), role.name(), allowed(*role))]
    WrongUnit {
        /// The unit, as the package states it.
        found: String,
        role: Role,
    },
    #[error("type {} cannot be {}, expected number or integer", shortened(found), role.name())]
    WrongType { found: String, role: Role },
    #[error("{} is the role of {other}, too{}", role.name(), if role.has_axes() { "" } else { ", expected one field" })]
    RoleTwice {
        role: Role,
        /// The field that has it already.
        other: String,
    },
    #[error("two fields have this name")]
    NameTwice,
    #[error("data of kind `{}` need a field of role {expected}", kind.name())]
    NoRole {
        kind: Kind,
        /// The role, or the choice of roles.
        expected: String,
    },
    #[error("the constant {0} is not finite")]
    Constant(String),
    #[error("the constant `{0}` is a size, expected more than zero")]
    Size(String),
    #[error("the path {path:?} {why}, expected a file in the folder of the package")]
    Path { path: String, why: &'static str },
    /// A feature of the standard that is not supported.
    #[error("{0}")]
    Unsupported(String),
    #[error("its fields are not those of {other}, expected the same names, roles, axes and units")]
    OtherFields {
        /// The file of the first resource.
        other: String,
    },
    #[error("the file is empty, expected a header row")]
    Empty,
    #[error("no row can be used, expected at least one")]
    NoRows,
    #[error("the header has no such field, expected every field of the schema")]
    NotInHeader,
    #[error("the schema has no such field, expected every field of the header")]
    NotInSchema,
    #[error("the header seems to have {seen:?} between its fields, expected {used:?}")]
    Delimiter {
        /// The delimiter of the dialect.
        used: char,
        seen: char,
    },
    #[error("found {found} cells, expected {expected} as in the header")]
    Ragged { found: usize, expected: usize },
    #[error("found {:?}, expected a number", shortened(.0))]
    NotANumber(String),
    #[error("found {:?}, expected a finite number", shortened(.0))]
    NotFinite(String),
    #[error("found {0}, expected +1 (counter-clockwise) or -1 (clockwise)")]
    Direction(f64),
    #[error("found bytes that are no UTF-8, expected text")]
    NotText,
    #[error("time {how} in run {run:?}: {now} after {before}, expected it to grow")]
    Time {
        /// Backwards, or not at all.
        how: &'static str,
        run: String,
        before: f64,
        now: f64,
    },
    #[error("every cell is empty, expected values of {}", .0.name())]
    AllMissing(Role),
    /// The MDF file or ROS bag cannot be read.
    #[error("{0}")]
    Malformed(String),
    /// The MDF file has no group, or the ROS bag no topic, with this name, or several.
    #[error("{count} groups have the name {name:?}, expected one")]
    Group {
        name: String,
        count: usize,
        /// The names of all groups that have one.
        known: Vec<String>,
    },
    #[error("the file has no channel of this name, expected one for every field that is used")]
    NoChannel(
        /// The channels of the file.
        Vec<String>,
    ),
    #[error("{0} channels have this name, expected one")]
    Channels(usize),
    /// The rows cannot come from one group.
    #[error("{0}")]
    OtherRaster(&'static str),
    #[error("the gzip file is cut short")]
    CutShort,
    #[error("the gzip file is damaged: {0}")]
    Damaged(#[source] io::Error),
}

/// A text of the file, which may be a whole line of it.
fn shortened(text: &str) -> String {
    const SHOWN_CHARS_MAX: usize = 60;
    let mut characters = text.chars();
    let mut shown: String = characters.by_ref().take(SHOWN_CHARS_MAX).collect();
    if characters.next().is_some() {
        shown.push_str("...");
    }
    shown
}

/// The first channels of a file.
fn listed(channels: &[String]) -> String {
    const LISTED_MAX: usize = 20;
    let first = channels[..channels.len().min(LISTED_MAX)].join(", ");
    match channels.len().saturating_sub(LISTED_MAX) {
        0 => format!("channels: {first}"),
        more => format!("channels: {first} and {more} more"),
    }
}

/// The permitted units of a role.
fn allowed(role: Role) -> String {
    let units = Unit::ALL.iter().filter(|unit| role.dimensions().contains(&unit.dimension()));
    let mut texts: Vec<_> = units.map(|unit| unit.text()).collect();
    if texts.contains(&Unit::Celsius.text()) {
        texts.extend(Scale::CONVERTED.map(Scale::text));
    }
    texts.join(", ")
}

impl Defect {
    fn advice(&self) -> Option<String> {
        Some(match self {
            Self::Unknown { what, known, .. } => {
                let other = if *what == "unit" { "; state any other unit as 1" } else { "" };
                format!("known: {}{other}", known.join(", "))
            }
            Self::Json(_) => "a data package is a folder with a datapackage.json, which says what the columns of its \
                 tables are: docs/data-packages.md"
                .to_owned(),
            Self::Delimiter { seen, .. } => format!(
                "\"dialect\": {{\"delimiter\": {:?}}} in its resource says so, and numbers with a decimal comma need \
                 \"decimalChar\": \",\" there too",
                seen.to_string()
            ),
            Self::NotANumber(cell) if cell.replacen(',', ".", 1).parse::<f64>().is_ok() => {
                if cell.contains(',') {
                    "numbers with a decimal comma need \"dialect\": {\"decimalChar\": \",\"} in the resource"
                } else {
                    "the package says that numbers here have a decimal comma (decimalChar)"
                }
                .to_owned()
            }
            Self::NotANumber(cell) if cell.contains(':') => {
                "a time is a number of seconds, from any beginning: convert time stamps".to_owned()
            }
            Self::NotANumber(_) => {
                "a missing number is an empty cell; text is for the roles run, auxiliary and ignore, and an \
                 auxiliary field of text needs \"type\": \"string\""
                    .to_owned()
            }
            Self::NotText => "save it as UTF-8: spreadsheets often write Latin-1 or Windows-1252, in which `°` and \
                 `ä` are other bytes; an MDF 4 file ends in .mf4, a ROS bag in .bag, .db3 or .mcap, and other formats \
                 are not read"
                .to_owned(),
            Self::NotFinite(_) => "a missing number is an empty cell".to_owned(),
            Self::RoleTwice { role, .. } if role.has_axes() => {
                "give each an axis of its own (x, y or z), or make one auxiliary".to_owned()
            }
            Self::Group { known, .. } => format!("groups: {}", known.join(", ")),
            Self::NoChannel(channels) => listed(channels),
            Self::Channels(_) => {
                "\"dialect\": { \"group\": NAME } of the resource says which group has the rows"
                    .to_owned()
            }
            Self::NotInSchema => "a field that is not needed has the role ignore".to_owned(),
            _ => return None,
        })
    }
}

impl DatasetError {
    /// A defect of `file` as a whole.
    pub(super) fn new(file: &Path, defect: Defect) -> Self {
        let inner = Inner { file: file.to_owned(), row: None, field: None, defect, shown: None };
        Self(Box::new(inner))
    }

    pub(super) fn at_row(mut self, row: Row) -> Self {
        self.0.row = Some(row);
        self
    }

    pub(super) fn in_field(mut self, field: &str) -> Self {
        self.0.field = Some(field.to_owned());
        self
    }

    /// Marks the place in the text of the file.
    pub(super) fn shown(mut self, text: &str, place: Option<Range<usize>>) -> Self {
        self.0.shown = place.map(|place| {
            let name = self.0.file.display().to_string();
            (NamedSource::new(name, text.to_owned()).with_language("json"), place)
        });
        self
    }

    /// The problem.
    pub fn defect(&self) -> &Defect {
        &self.0.defect
    }
}

impl fmt::Display for DatasetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.file.display())?;
        match self.0.row {
            None => {}
            Some(Row { number: 0, line }) => write!(f, ", line {line}")?,
            Some(Row { number, line: 0 }) => write!(f, ", row {number}")?,
            Some(Row { number, line }) => write!(f, ", row {number} (line {line})")?,
        }
        if let Some(field) = &self.0.field {
            write!(f, ", field {}", shortened(field).escape_debug())?;
        }
        write!(f, ": {}", self.0.defect)
    }
}

impl std::error::Error for DatasetError {}

impl Diagnostic for DatasetError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.defect.advice().map(|advice| Box::new(advice) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.shown.as_ref().map(|(text, _)| text as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, place) = self.0.shown.as_ref()?;
        let label = LabeledSpan::new_with_span(Some("here".to_owned()), place.clone());
        Some(Box::new(std::iter::once(label)))
    }
}

#[cfg(test)]
mod tests {
    use super::{DatasetError, Defect};
    use std::path::Path;

    /// Found by a user: a header of one field of 100,000 characters was printed whole.
    #[test]
    fn a_long_text_makes_a_short_message() {
        let text = "x".repeat(100_000);
        let field = DatasetError::new(Path::new("data.csv"), Defect::NotInSchema).in_field(&text);
        assert!(field.to_string().len() < 200, "{field}");
        let cell = Defect::NotANumber(text);
        assert!(cell.to_string().len() < 200, "{cell}");
    }
}
