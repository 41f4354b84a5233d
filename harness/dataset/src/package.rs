//! Validates a descriptor.

use super::descriptor::{self, Descriptor, Hil, Resource, place};
use super::dialect;
use super::error::{DatasetError, Defect};
use super::thermometer::Scale;
use identification::dataset::{Axis, Constant, Drive, Kind, Role, Unit};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// The cell that means a missing value unless the schema states others (Frictionless, `missingValues`).
const MISSING: &str = "";

/// File extensions of tables.
const ENDS: [&str; 8] = ["csv", "csv.gz", "mf4", "mdf", "bag", "mcap", "db3", ZSTD];

/// File extension of ROS 2 bags that are compressed as a whole.
const ZSTD: &str = "zstd";

/// A valid package whose tables have not been read yet.
#[derive(Debug)]
pub(super) struct Package {
    pub name: String,
    pub kind: Kind,
    pub drive: Option<Drive>,
    pub constants: BTreeMap<String, Constant>,
    pub fields: Vec<Field>,
    pub tables: Vec<Table>,
    pub notices: Vec<String>,
}

/// A valid field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub role: Role,
    pub axis: Option<Axis>,
    pub unit: Unit,
    /// Of a temperature: the scale of its cells.
    pub scale: Scale,
    /// Whether its cells are words instead of numbers.
    pub text: bool,
}

/// A file with rows.
#[derive(Debug)]
pub(super) struct Table {
    pub name: String,
    pub path: PathBuf,
    pub format: Format,
    pub delimiter: u8,
    /// Names of the fields whose numbers have a decimal comma.
    pub commas: BTreeSet<String>,
    pub missing: BTreeSet<String>,
    /// The group with the rows, in an MDF file, or the topic, in a ROS bag, if given.
    #[cfg_attr(
        not(feature = "files"),
        expect(dead_code, reason = "files without groups are read then")
    )]
    pub group: Option<String>,
}

/// Format of a table, by the extension of its file, in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    /// `.mf4` or `.mdf`.
    Mdf,
    /// `.bag`, `.mcap` or `.db3`.
    RosBag,
}

impl Format {
    fn of(path: &Path) -> Self {
        match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
            Some("mf4" | "mdf") => Self::Mdf,
            Some("bag" | "mcap" | "db3") => Self::RosBag,
            _ => Self::Csv,
        }
    }
}

impl Table {
    /// A placeholder for a file that was read in another way.
    pub(super) fn of(path: &Path) -> Self {
        let (name, missing, commas) = (String::new(), BTreeSet::new(), BTreeSet::new());
        let (path, format) = (path.to_owned(), Format::Csv);
        Self { name, path, format, delimiter: b',', commas, missing, group: None }
    }
}

/// Validates the descriptor `text` from `file`.
pub(super) fn understand(file: &Path, text: &str) -> Result<Package, DatasetError> {
    let written: Descriptor = serde_json::from_str(text.trim_start_matches('\u{feff}'))
        .map_err(|error| bad_json(file, text, error))?;
    let context = Context { file, text };
    let folder = file.parent().unwrap_or(Path::new(""));
    let hil = written.hil.ok_or_else(|| context.missing("the property hil"))?;
    let kind_text = hil.kind.as_deref().ok_or_else(|| context.missing("hil.kind"))?;
    let kind = Kind::parse(kind_text).ok_or_else(|| {
        context.unknown("kind", kind_text, Kind::ALL.iter().map(|kind| kind.name()), &["kind"])
    })?;
    let mut notices: Vec<String> = hil
        .others
        .keys()
        .map(|key| format!("hil.{key} is not known and was passed over"))
        .collect();
    let drive = drive(&context, &hil)?;
    let constants = constants(&context, &hil)?;
    let (mut fields, mut tables) = (None::<Vec<Field>>, Vec::<Table>::new());
    for (index, resource) in written.resources.iter().enumerate() {
        if resource.schema.is_none() && !is_table(resource) {
            let name = resource.name.clone().unwrap_or_else(|| format!("resource {}", index + 1));
            notices.push(format!("{name} is no table and was passed over"));
            continue;
        }
        let (table, these) = table(&context, folder, index, resource)?;
        match &fields {
            None => fields = Some(these),
            Some(first) if !same_fields(first, &these) => {
                let other = tables.first().map(|first| first.path.display().to_string());
                let defect = Defect::OtherFields { other: other.unwrap_or_default() };
                return Err(DatasetError::new(&table.path, defect));
            }
            Some(_) => {}
        }
        tables.push(table);
    }
    let fields = fields.ok_or_else(|| context.missing("a table (a resource with a schema)"))?;
    check_roles(&context, kind, &fields)?;
    let has = |role| fields.iter().any(|field| field.role == role);
    let drive = drive.or_else(|| match kind {
        Kind::Odometry if has(Role::DriveDistance) => Some(Drive::Synchro),
        Kind::Odometry => Some(Drive::Differential),
        _ => None,
    });
    let folder_name = || folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = written.name.or_else(folder_name).unwrap_or_else(|| "data".to_owned());
    Ok(Package { name, kind, drive, constants, fields, tables, notices })
}

/// Context of mistakes in the descriptor.
struct Context<'a> {
    file: &'a Path,
    text: &'a str,
}

impl Context<'_> {
    fn error(&self, defect: Defect, words: &[&str]) -> DatasetError {
        DatasetError::new(self.file, defect).shown(self.text, place(self.text, words))
    }

    fn missing(&self, what: &'static str) -> DatasetError {
        self.error(Defect::NoProperty(what), &[])
    }

    fn unknown(
        &self,
        what: &'static str,
        found: &str,
        known: impl Iterator<Item = &'static str>,
        after: &[&str],
    ) -> DatasetError {
        let defect = Defect::Unknown { what, found: found.to_owned(), known: known.collect() };
        self.error(defect, &[after, &[found]].concat())
    }
}

fn bad_json(file: &Path, text: &str, error: serde_json::Error) -> DatasetError {
    let line_begin: usize =
        text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
    let at = (line_begin + error.column().saturating_sub(1)).min(text.len());
    let end = text[..].char_indices().map(|(begin, c)| begin + c.len_utf8()).find(|end| *end > at);
    DatasetError::new(file, Defect::Json(error)).shown(text, end.map(|end| at.min(end - 1)..end))
}

fn drive(context: &Context<'_>, hil: &Hil) -> Result<Option<Drive>, DatasetError> {
    let Some(found) = hil.drive.as_deref() else { return Ok(None) };
    let known = Drive::ALL.iter().map(|drive| drive.name());
    let drive = Drive::parse(found);
    drive.map(Some).ok_or_else(|| context.unknown("drive", found, known, &["drive"]))
}

/// `scales` are known as well, where they can be converted.
fn unit(
    context: &Context<'_>,
    found: &str,
    scales: &[Scale],
    after: &[&str],
) -> Result<Unit, DatasetError> {
    Unit::parse(found).ok_or_else(|| {
        let scales = scales.iter().map(|scale| scale.text());
        let known = Unit::ALL.iter().map(|unit| unit.text()).chain(scales);
        context.unknown("unit", found, known, after)
    })
}

/// Beginnings of the names of constants that something is divided by.
const SIZES: [&str; 4] = ["wheel", "track", "encoder_ticks", "ticks"];

fn constants(context: &Context<'_>, hil: &Hil) -> Result<BTreeMap<String, Constant>, DatasetError> {
    let mut constants = BTreeMap::new();
    for (name, written) in &hil.constants {
        if !written.value.is_finite() {
            return Err(context.error(Defect::Constant(name.clone()), &[name]));
        }
        let is_size = SIZES.iter().any(|size| name.starts_with(size));
        if is_size && written.value <= 0.0 {
            return Err(context.error(Defect::Size(name.clone()), &[name]));
        }
        let unit = unit(context, &written.unit, &[], &[name, "unit"])?;
        constants.insert(name.clone(), Constant { value: written.value, unit });
    }
    Ok(constants)
}

fn is_table(resource: &Resource) -> bool {
    let known = |text: &str| ENDS.iter().any(|end| text.ends_with(end));
    resource.format.as_deref().is_some_and(known)
        || resource.path.as_ref().and_then(|path| path.as_str()).is_some_and(known)
}

fn table(
    context: &Context<'_>,
    folder: &Path,
    index: usize,
    resource: &Resource,
) -> Result<(Table, Vec<Field>), DatasetError> {
    let unsupported = |what: &str| context.error(Defect::Unsupported(what.to_owned()), &[]);
    let path = match &resource.path {
        Some(serde_json::Value::String(path)) => path,
        Some(_) => return Err(unsupported("a resource has several paths, expected one file each")),
        None => return Err(context.missing("the path of a resource")),
    };
    let plain = plain_path(path).map_err(|why| {
        let defect = Defect::Path { path: path.clone(), why };
        context.error(defect, &["path", path])
    })?;
    if plain.extension().is_some_and(|end| end.eq_ignore_ascii_case(ZSTD)) {
        let what = "a bag that is compressed as a whole is not read: `zstd -d` unpacks it";
        return Err(context.error(Defect::Unsupported(what.to_owned()), &["path", path]));
    }
    if let Some(encoding) = &resource.encoding
        && !["utf-8", "utf8", "utf-8-sig", "ascii"].contains(&encoding.to_lowercase().as_str())
    {
        let what = format!("the encoding {encoding} is not read, expected utf-8");
        return Err(context.error(Defect::Unsupported(what), &["encoding", encoding]));
    }
    let dialect = resource.dialect.as_ref();
    if dialect.and_then(|dialect| dialect.header) == Some(false) {
        return Err(unsupported("a table without a header is not read, expected a header row"));
    }
    let delimiter = dialect::delimiter(dialect).map_err(unsupported)?;
    let commas = dialect::commas(resource).map_err(unsupported)?;
    let schema =
        resource.schema.as_ref().ok_or_else(|| context.missing("the schema of a table"))?;
    let missing = match &schema.missing_values {
        None => BTreeSet::from([MISSING.to_owned()]),
        Some(words) => words.iter().map(|word| word.trim().to_owned()).collect(),
    };
    let mut fields = Vec::<Field>::new();
    for written in &schema.fields {
        let field = field(context, written)?;
        let fail =
            |defect| Err(context.error(defect, &["fields", &written.name]).in_field(&written.name));
        if fields.iter().any(|other| other.name == field.name) {
            return fail(Defect::NameTwice);
        }
        if let Some(other) = fields.iter().find(|other| clash(other, &field)) {
            return fail(Defect::RoleTwice { role: field.role, other: other.name.clone() });
        }
        fields.push(field);
    }
    let file_stem = path.rsplit('/').next().unwrap_or(path);
    let file_stem = file_stem.trim_end_matches(".gz").trim_end_matches(".csv");
    let format = Format::of(plain);
    let file_stem = match plain.file_stem().and_then(|stem| stem.to_str()) {
        Some(stem) if format != Format::Csv => stem,
        _ => file_stem,
    };
    let name = match resource.name.as_deref().unwrap_or(file_stem) {
        "" => format!("{}", index + 1),
        name => name.to_owned(),
    };
    let group = dialect.and_then(|dialect| dialect.group.clone());
    let path = folder.join(plain);
    Ok((Table { name, path, format, delimiter, commas, missing, group }, fields))
}

/// Whether two fields have the same meaning.
fn clash(one: &Field, other: &Field) -> bool {
    let apart = one.role.has_axes() && one.axis.is_some() && other.axis.is_some();
    one.role == other.role && !one.role.repeats() && !(apart && one.axis != other.axis)
}

fn field(context: &Context<'_>, written: &descriptor::Field) -> Result<Field, DatasetError> {
    let name = written.name.as_str();
    let inside = |error: DatasetError| error.in_field(name);
    let after = |word| ["fields", name, word];
    let missing = |what| inside(context.error(Defect::NoProperty(what), &["fields", name]));
    let role = written.role.as_deref().ok_or_else(|| missing("the role"))?;
    let role = Role::parse(role).ok_or_else(|| {
        let known = Role::ALL.iter().map(|role| role.name());
        inside(context.unknown("role", role, known, &after("role")))
    })?;
    let scale = written.unit.as_deref().and_then(Scale::parse);
    let unit = match written.unit.as_deref() {
        Some(_) if scale.is_some() => Unit::Celsius,
        Some(found) => unit(context, found, &Scale::CONVERTED, &after("unit")).map_err(inside)?,
        // Their values are not used in calculations.
        None if matches!(role, Role::Run | Role::Ignore) => Unit::One,
        None => return Err(missing("the unit")),
    };
    if !role.dimensions().is_empty() && !role.dimensions().contains(&unit.dimension()) {
        let found = written.unit.clone().unwrap_or_default();
        let words = ["fields", name, "unit", &found];
        let defect = Defect::WrongUnit { found: found.clone(), role };
        return Err(inside(context.error(defect, &words)));
    }
    let axis = match written.axis.as_deref() {
        None => None,
        Some(found) => Some(Axis::parse(found).ok_or_else(|| {
            let known = Axis::ALL.iter().map(|axis| axis.name());
            inside(context.unknown("axis", found, known, &after("axis")))
        })?),
    };
    let numbers = matches!(written.kind.as_deref(), None | Some("number" | "integer" | "any"));
    let text = match role {
        Role::Run | Role::Ignore => true,
        Role::Auxiliary => !numbers,
        _ if numbers => false,
        role => {
            let found = written.kind.clone().unwrap_or_default();
            let words = ["fields", name, "type", &found];
            let defect = Defect::WrongType { found: found.clone(), role };
            return Err(inside(context.error(defect, &words)));
        }
    };
    let scale = scale.unwrap_or(Scale::Celsius);
    Ok(Field { name: name.to_owned(), role, axis, unit, scale, text })
}

/// Accepts only a path inside the folder.
fn plain_path(path: &str) -> Result<&Path, &'static str> {
    if path.contains("://") {
        return Err("is remote");
    }
    let plain = Path::new(path);
    if path.is_empty() {
        return Err("is empty");
    }
    for component in plain.components() {
        match component {
            Component::Normal(_) | Component::CurDir => {}
            Component::ParentDir => return Err("leaves the folder"),
            Component::RootDir | Component::Prefix(_) => return Err("is absolute"),
        }
    }
    Ok(plain)
}

/// Whether the fields are the same, in any order.
fn same_fields(one: &[Field], other: &[Field]) -> bool {
    one.len() == other.len() && one.iter().all(|field| other.contains(field))
}

fn check_roles(context: &Context<'_>, kind: Kind, fields: &[Field]) -> Result<(), DatasetError> {
    let has = |role: &Role| fields.iter().any(|field| field.role == *role);
    for alternatives in kind.required() {
        if alternatives.iter().any(|group| group.iter().all(has)) {
            continue;
        }
        let group = |group: &&[Role]| {
            group.iter().map(|role| role.name()).collect::<Vec<_>>().join(" and ")
        };
        let expected = alternatives.iter().map(group).collect::<Vec<_>>().join(", or ");
        return Err(context.error(Defect::NoRole { kind, expected }, &["fields"]));
    }
    Ok(())
}
