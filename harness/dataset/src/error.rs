//! Why a data package cannot be used: where, what is wrong there, and what was expected.

use identification::dataset::{Kind, Role, Unit};
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A mistake in a data package. Nothing of the package is used then.
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
    /// Which row of data, from 1; the header is none.
    pub number: u64,
    /// Which line of the file it begins in, from 1; 0 in a file that has no lines.
    pub line: u64,
}

/// What is wrong.
#[derive(Debug, thiserror::Error)]
pub enum Defect {
    /// There is no such folder or file, or it cannot be read.
    #[error("failed to read it: {0}")]
    Unreadable(#[source] io::Error),
    /// It has more than is read.
    #[error("it holds more than {max} {what}")]
    TooLong {
        /// How many are read.
        max: u64,
        /// Of what.
        what: &'static str,
    },
    /// The descriptor is no JSON, or not of the shape of a data package.
    #[error("it is no data package: {0}")]
    Json(#[source] serde_json::Error),
    /// A property that is needed.
    #[error("{0} is missing")]
    NoProperty(&'static str),
    /// A word that is not of the contract.
    #[error("{what} `{found}` is not known")]
    Unknown {
        /// What it was to be.
        what: &'static str,
        /// What it says.
        found: String,
        /// What it can say.
        known: Vec<&'static str>,
    },
    /// A unit that measures something else than the role is.
    #[error("{unit} is no unit of {}, expected one of {}", role.name(), allowed(*role))]
    WrongUnit {
        /// The unit.
        unit: Unit,
        /// The role.
        role: Role,
    },
    /// The type of a field that must hold numbers.
    #[error("type {found} cannot be {}, expected number or integer", role.name())]
    WrongType {
        /// The type.
        found: String,
        /// The role.
        role: Role,
    },
    /// Two fields for one thing.
    #[error("{} is the role of {other}, too{}", role.name(), if role.has_axes() { "" } else { ", expected one field" })]
    RoleTwice {
        /// The role.
        role: Role,
        /// The field that has it already.
        other: String,
    },
    /// Two fields have one name.
    #[error("two fields have this name")]
    NameTwice,
    /// What the kind needs is not there.
    #[error("{} need a field of role {expected}", kind.name())]
    NoRole {
        /// The kind.
        kind: Kind,
        /// The role, or the choice of roles.
        expected: String,
    },
    /// A constant that is none.
    #[error("the constant {0} is not finite")]
    Constant(String),
    /// A path that is refused.
    #[error("the path {path:?} {why}, expected a file in the folder of the package")]
    Path {
        /// The path.
        path: String,
        /// Why it is refused.
        why: &'static str,
    },
    /// Something of the standard that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// Two tables that do not go together.
    #[error("its fields are not those of {other}, expected the same names, roles, axes and units")]
    OtherFields {
        /// The file of the first resource.
        other: String,
    },
    /// A file with nothing in it.
    #[error("the file is empty, expected a header row")]
    Empty,
    /// No row can be used.
    #[error("no row can be used, expected at least one")]
    NoRows,
    /// The schema has it, the header does not.
    #[error("the header has no such field, expected every field of the schema")]
    NotInHeader,
    /// The header has it, the schema does not.
    #[error("the schema has no such field, expected every field of the header")]
    NotInSchema,
    /// A row that is too long or too short.
    #[error("found {found} cells, expected {expected} as in the header")]
    Ragged {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Text where a number belongs.
    #[error("found {0:?}, expected a number")]
    NotANumber(String),
    /// Not a number, or infinite.
    #[error("found {0:?}, expected a finite number")]
    NotFinite(String),
    /// Neither way round.
    #[error("found {0}, expected +1 (counter-clockwise) or -1 (clockwise)")]
    Direction(f64),
    /// Bytes that are no text.
    #[error("found bytes that are no UTF-8, expected text")]
    NotText,
    /// Time that does not move on.
    #[error("time {how} in run {run:?}: {now} after {before}, expected it to grow")]
    Time {
        /// Backwards, or not at all.
        how: &'static str,
        /// Label of the run.
        run: String,
        /// The time in the row before.
        before: f64,
        /// The time in this row.
        now: f64,
    },
    /// A field without which nothing can be said has nothing in it.
    #[error("every cell is empty, expected values of {}", .0.name())]
    AllMissing(Role),
    /// The MDF file cannot be read.
    #[error("{0}")]
    Mdf(String),
    /// The MDF file has no such group, or several.
    #[error("{count} groups have the name {name:?}, expected one")]
    Group {
        /// The name.
        name: String,
        /// How many groups have it.
        count: usize,
        /// The names of all, as far as they have one.
        known: Vec<String>,
    },
    /// No channel of an MDF file has the name of the field.
    #[error("the file has no channel of this name, expected one for every field that is used")]
    NoChannel,
    /// Several channels of an MDF file have the name of the field.
    #[error("{0} channels have this name, expected one")]
    Channels(usize),
    /// The rows cannot be those of one group.
    #[error("{0}")]
    OtherRaster(&'static str),
    /// The compressed file ends too early.
    #[error("the gzip file is cut short")]
    CutShort,
    /// The compressed file is damaged.
    #[error("the gzip file is damaged: {0}")]
    Damaged(#[source] io::Error),
}

/// Units in which a role can be.
fn allowed(role: Role) -> String {
    let units = Unit::ALL.iter().filter(|unit| role.dimensions().contains(&unit.dimension()));
    units.map(|unit| unit.text()).collect::<Vec<_>>().join(", ")
}

impl Defect {
    fn advice(&self) -> Option<String> {
        Some(match self {
            Self::Unknown { known, .. } => format!("known: {}", known.join(", ")),
            Self::NotANumber(_) => {
                "a missing number is an empty cell; text is for the roles run, auxiliary and ignore, and an \
                 auxiliary field of text needs \"type\": \"string\""
                    .to_owned()
            }
            Self::NotFinite(_) => "a missing number is an empty cell".to_owned(),
            Self::RoleTwice { role, .. } if role.has_axes() => {
                "give each an axis of its own (x, y or z), or make one auxiliary".to_owned()
            }
            Self::Group { known, .. } => format!("groups: {}", known.join(", ")),
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
    /// Something is wrong with `file` as a whole.
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

    /// Shows the place in the text of the file.
    pub(super) fn shown(mut self, text: &str, place: Option<Range<usize>>) -> Self {
        self.0.shown = place.map(|place| {
            let name = self.0.file.display().to_string();
            (NamedSource::new(name, text.to_owned()).with_language("json"), place)
        });
        self
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.0.file
    }

    /// The row of the table, where it is in one.
    pub fn row(&self) -> Option<Row> {
        self.0.row
    }

    /// The field, where it is about one.
    pub fn field(&self) -> Option<&str> {
        self.0.field.as_deref()
    }

    /// What is wrong.
    pub fn defect(&self) -> &Defect {
        &self.0.defect
    }
}

impl fmt::Display for DatasetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.file.display())?;
        match self.0.row {
            None => {}
            Some(Row { number, line: 0 }) => write!(f, ", row {number}")?,
            Some(Row { number, line }) => write!(f, ", row {number} (line {line})")?,
        }
        if let Some(field) = &self.0.field {
            write!(f, ", field {}", field.escape_debug())?;
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
