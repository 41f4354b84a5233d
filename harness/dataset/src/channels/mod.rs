//! A table in a file of measured channels: channels are columns, and the records of one group are rows.

mod choice;
mod nearest;

use super::error::{DatasetError, Row};
use super::package::{Field, Table};
use super::table::{Given, Origin, Rows};
pub(super) use bus_log::mdf4::channels::{Cell, Wanted};
use choice::{Choice, choose};
use identification::dataset::{Role, Unit};
use nearest::Nearest;

/// A group of channels with common times.
#[derive(Debug)]
pub(super) struct Group {
    /// Its name in the file; empty if unnamed.
    pub name: String,
    pub channels: Vec<Channel>,
}

/// A channel of a group.
#[derive(Debug)]
pub(super) struct Channel {
    pub name: String,
    /// Unit of its values in the file; empty without a unit.
    pub unit: String,
    /// Whether it is the time of the group's records, in seconds.
    pub is_time: bool,
}

/// Takes the values of a record, one per requested channel.
pub(super) type Each<'a> = &'a mut dyn FnMut(&[Cell]) -> Result<(), DatasetError>;

/// An open file of measured channels.
pub(super) trait Source {
    fn groups(&self) -> &[Group];

    /// Passes the values of each record of a group to `each`, in the order of the file. Returns what is there of a file
    /// that its writer did not finish, and why no more, as far as that is known.
    fn read(
        &mut self,
        group: usize,
        wanted: &[Wanted],
        each: Each<'_>,
    ) -> Result<Option<(String, Option<String>)>, DatasetError>;
}

/// Appends the content of `table`, which has this `index`. Rows are the records of the group with the measured
/// channels; a value of another group goes to the row nearest in time.
pub(super) fn take(
    source: &mut dyn Source,
    rows: &mut Rows,
    fields: &[Field],
    table: &Table,
    index: usize,
    notices: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let fail = |defect| DatasetError::new(&table.path, defect);
    let choice = choose(source.groups(), fields, table)?;
    notices.extend(units(source.groups(), fields, &choice));
    let run = rows.run_of(fields, table);
    let begin = rows.origins.len();
    let wanted: Vec<Wanted> = choice.own.iter().map(|(_, wanted)| *wanted).collect();
    let mut number = 0;
    let ended = source.read(choice.group, &wanted, &mut |cells| {
        number += 1;
        let row = Row { number, line: 0 };
        rows.begin_row(Origin { table: index, row }, run).map_err(fail)?;
        let mut own = choice.own.iter().zip(cells).peekable();
        for (at, field) in fields.iter().enumerate() {
            // In field order: fields of this group have a cell, the others none yet.
            let cell = own.next_if(|((of, _), _)| *of == at).map(|(_, cell)| cell);
            rows.take(at, field, given(cell))
                .map_err(|defect| fail(defect).at_row(row).in_field(&field.name))?;
        }
        Ok(())
    })?;
    let file = table.path.file_name().unwrap_or_default().to_string_lossy();
    let unfinished = |(what, why): (String, Option<String>)| {
        let why = why.map_or_else(String::new, |why| format!(" ({why})"));
        format!("{file} was not finished by its writer: it has {what}{why}")
    };
    notices.extend(ended.map(unfinished));
    for (group, channels) in &choice.others {
        let time = choice.time.unwrap_or_default();
        let times = &rows.columns[time][begin..];
        let mut nearest = Nearest::new(times, channels.len()).map_err(fail)?;
        // The first wanted channel is the time.
        let wanted: Vec<Wanted> = channels.iter().map(|(_, wanted)| *wanted).collect();
        let ended = source.read(*group, &wanted, &mut |cells| {
            nearest.take(cells);
            Ok(())
        })?;
        notices.extend(ended.map(unfinished));
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
