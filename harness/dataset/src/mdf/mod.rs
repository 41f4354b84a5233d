//! A table in an MDF file: channels are columns, and the records of a group are rows.

mod choice;
mod nearest;

use super::error::{DatasetError, Defect, Row};
use super::package::{Field, Table};
use super::table::{Given, Origin, Rows};
use bus_log::LogError;
use bus_log::mdf4::channels::{Cell, Found, Group, Reader, Wanted};
use choice::{Choice, choose};
use identification::dataset::{Role, Unit};
use nearest::Nearest;
use std::fs::File;
use std::io::BufReader;

/// Appends the content of `table`, which has this `index`. Rows are the records of the group with the measured
/// channels; a value of another group goes to the row nearest in time.
pub(super) fn read(
    rows: &mut Rows,
    fields: &[Field],
    table: &Table,
    index: usize,
    notices: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let fail = |defect| DatasetError::new(&table.path, defect);
    let file = File::open(&table.path).map_err(|error| fail(Defect::Unreadable(error)))?;
    let mut reader = Reader::new(&table.path, BufReader::new(file))?;
    let choice = choose(reader.groups(), fields, table)?;
    notices.extend(units(reader.groups(), fields, &choice));
    let run = rows.run_of(fields, table);
    let begin = rows.origins.len();
    let wanted: Vec<Wanted> = choice.own.iter().map(|(_, wanted)| *wanted).collect();
    let mut number = 0;
    let found = reader.read(choice.group, &wanted, &mut |cells| {
        number += 1;
        let row = Row { number, line: 0 };
        rows.begin_row(Origin { table: index, row }, run).map_err(fail)?;
        let mut own = choice.own.iter().zip(&cells).peekable();
        for (at, field) in fields.iter().enumerate() {
            // In field order: fields of this group have a cell, the others none yet.
            let cell = own.next_if(|((of, _), _)| *of == at).map(|(_, cell)| cell);
            rows.take(at, field, given(cell))
                .map_err(|defect| fail(defect).at_row(row).in_field(&field.name))?;
        }
        Ok::<_, DatasetError>(())
    })?;
    notices.extend(unfinished(&reader, table, &found));
    for (group, channels) in &choice.others {
        let time = choice.time.unwrap_or_default();
        let times = &rows.columns[time][begin..];
        let mut nearest = Nearest::new(times, channels.len()).map_err(fail)?;
        // The first wanted channel is the time.
        let wanted: Vec<Wanted> = channels.iter().map(|(_, wanted)| *wanted).collect();
        let found = reader.read(*group, &wanted, &mut |cells| {
            nearest.take(&cells);
            Ok::<_, DatasetError>(())
        })?;
        notices.extend(unfinished(&reader, table, &found));
        for (number, (field, _)) in channels.iter().enumerate().skip(1) {
            let (values, told) = nearest.column(number - 1);
            notices.push(format!("{} has times of its own: {told}", fields[*field].name));
            rows.columns[*field][begin..].copy_from_slice(&values);
        }
    }
    Ok(())
}

fn given(cell: Option<&Cell>) -> Given<'_> {
    match cell {
        None | Some(Cell::Missing) => Given::Missing,
        Some(Cell::Number(number)) => Given::Number(*number),
        Some(Cell::Text(text)) => Given::Word(text),
    }
}

/// A notice about the end of a file that its writer did not finish.
fn unfinished(reader: &Reader<BufReader<File>>, table: &Table, found: &Found) -> Option<String> {
    if !reader.is_unfinished() {
        return None;
    }
    let file = table.path.file_name().unwrap_or_default().to_string_lossy();
    let records = found.records;
    let why = match &found.ended {
        Some(LogError::Malformed { place, defect, .. }) => format!(" ({place}: {defect})"),
        _ => String::new(),
    };
    Some(format!("{file} was not finished by who wrote it: {records} records are there{why}"))
}

/// Fields whose unit in the file differs, if known. The unit of the package applies.
fn units(groups: &[Group], fields: &[Field], choice: &Choice) -> Vec<String> {
    let own = choice.own.iter().map(|one| (choice.group, one));
    let others = choice.others.iter().flat_map(|(group, all)| all.iter().map(|one| (*group, one)));
    let differs = |(group, (field, wanted)): (usize, &(usize, Wanted))| {
        let unit = groups.get(group)?.channels.get(wanted.channel)?.unit.trim();
        let field = &fields[*field];
        let is_other = Unit::parse(unit).is_some_and(|unit| unit != field.unit);
        (is_other && !matches!(field.role, Role::Run | Role::Ignore)).then(|| {
            format!(
                "{} is in {unit} by its file, taken as {} as the package says",
                field.name, field.unit
            )
        })
    };
    own.chain(others).filter_map(differs).collect()
}

impl From<LogError> for DatasetError {
    fn from(error: LogError) -> Self {
        match error {
            LogError::Malformed { path, place, defect, .. } => {
                Self::new(&path, Defect::Mdf(format!("{place}: {defect}")))
            }
            LogError::Unreadable { path, source } => Self::new(&path, Defect::Unreadable(source)),
            LogError::Unwritable { ref path, .. } | LogError::Before1970 { ref path, .. } => {
                Self::new(path, Defect::Mdf(error.to_string()))
            }
        }
    }
}
