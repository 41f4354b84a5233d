//! A table in an MDF file.

use super::channels::{Channel, Each, Group, Source, Wanted, take};
use super::error::{DatasetError, Defect};
use super::package::{Field, Table};
use super::table::Rows;
use bus_log::LogError;
use bus_log::mdf4::channels as mdf4;
use std::fs::File;
use std::io::BufReader;

/// Appends the content of `table`, which has this `index`.
pub(super) fn read(
    rows: &mut Rows,
    fields: &[Field],
    table: &Table,
    index: usize,
    notices: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let fail = |defect| DatasetError::new(&table.path, defect);
    let file = File::open(&table.path).map_err(|error| fail(Defect::Unreadable(error)))?;
    let reader = mdf4::Reader::new(&table.path, BufReader::new(file))?;
    let groups = reader.groups().iter().map(group).collect();
    take(&mut Mdf { reader, groups }, rows, fields, table, index, notices)
}

struct Mdf {
    reader: mdf4::Reader<'static>,
    groups: Vec<Group>,
}

impl Source for Mdf {
    fn groups(&self) -> &[Group] {
        &self.groups
    }

    fn read(
        &mut self,
        group: usize,
        wanted: &[Wanted],
        each: Each<'_>,
    ) -> Result<Option<(String, Option<String>)>, DatasetError> {
        let found = self.reader.read(group, wanted, &mut |cells| each(&cells))?;
        if !self.reader.is_unfinished() {
            return Ok(None);
        }
        let why = match &found.ended {
            Some(LogError::Malformed { place, defect, .. }) => Some(format!("{place}: {defect}")),
            _ => None,
        };
        Ok(Some((format!("{} records", found.records), why)))
    }
}

fn group(group: &mdf4::Group) -> Group {
    let channel = |one: &mdf4::Channel| Channel {
        name: one.name.clone(),
        unit: one.unit.clone(),
        is_time: one.is_time,
    };
    Group { name: group.name.clone(), channels: group.channels.iter().map(channel).collect() }
}

impl From<LogError> for DatasetError {
    fn from(error: LogError) -> Self {
        match error {
            LogError::Malformed { path, place, defect, .. } => {
                Self::new(&path, Defect::Malformed(format!("{place}: {defect}")))
            }
            LogError::Unreadable { path, source } => Self::new(&path, Defect::Unreadable(source)),
            LogError::Empty { path, .. } => {
                Self::new(&path, Defect::Malformed("the file is empty".to_owned()))
            }
            LogError::Unwritable { ref path, .. } | LogError::Before1970 { ref path, .. } => {
                Self::new(path, Defect::Malformed(error.to_string()))
            }
        }
    }
}
