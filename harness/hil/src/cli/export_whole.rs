//! `hil export --tables`, `--mcap` and `--mf4`: all contents of a record.

use super::failure::Failure;
use super::progress::Screen;
use super::say;
use crate::choices::one_of;
use clap::builder::TypedValueParser;
use exchange::Exported;
use exchange::tables::survey::Survey;
use exchange::tables::{Ears, Format, survey};
use harness::run::load_recorded;
use record::figures;
use record::header::Header;
use record::outcome::Outcome;
use record::run_folder::RunFolder;
use std::path::Path;

/// What tables are written as.
pub(super) fn table_format() -> impl TypedValueParser<Value = Format> {
    one_of([
        ("parquet", "Apache Parquet: small, with typed columns", Format::Parquet),
        ("csv", "CSV: for tools that read nothing else", Format::Csv),
    ])
}

/// Where a run is written, and as what.
pub(super) enum Whole<'a> {
    Tables(&'a Path, Format),
    Mcap(&'a Path),
    Mf4(&'a Path),
}

impl Whole<'_> {
    pub(super) fn write(
        &self,
        folder: &RunFolder,
        plan: Option<&str>,
        screen: &Screen,
    ) -> Result<Outcome, Failure> {
        match self {
            Self::Tables(..) => {}
            Self::Mcap(path) => ends_in(path, "mcap")?,
            Self::Mf4(path) => ends_in(path, "mf4")?,
        }
        let survey = survey(folder)?;
        let ears = ears_of(&survey, plan, screen)?;
        let sum = |exported: &Exported| -> (u64, usize) {
            (exported.written.iter().map(|(_, rows)| rows).sum(), exported.written.len())
        };
        let exported = match *self {
            Self::Tables(out, format) => {
                let exported = exchange::tables::export(folder, survey, out, format, ears)?;
                for (table, rows) in &exported.written {
                    let file = out.join(format!("{table}.{}", format.name()));
                    let rows = figures::counted(*rows, "row", "rows");
                    say(&format!("{}: {rows}\n", file.display()))?;
                }
                exported
            }
            Self::Mcap(path) => {
                let exported = exchange::mcap::export(folder, survey, path, ears)?;
                let (messages, topics) = sum(&exported);
                say(&format!("{}: {messages} messages on {topics} topics\n", path.display()))?;
                exported
            }
            Self::Mf4(path) => {
                let exported = exchange::mf4::export(folder, survey, path, ears)?;
                let (records, groups) = sum(&exported);
                say(&format!("{}: {records} records in {groups} groups\n", path.display()))?;
                exported
            }
        };
        ended(folder, exported.survey, screen)
    }
}

/// Checks the extension, so that a slip does not overwrite a record or another file of a run folder.
fn ends_in(path: &Path, end: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|found| found == end) {
        return Ok(());
    }
    Err(Failure::arguments(
        format!("the name {} does not end in .{end}", path.display()),
        format!("give --{end} a name that ends in .{end}"),
    ))
}

/// Reports what the export lacks, and fails if that is the rest of the record.
fn ended(folder: &RunFolder, survey: Survey, screen: &Screen) -> Result<Outcome, Failure> {
    if survey.left_out > 0 {
        let left_out = survey.left_out;
        screen.note(&format!(
            "{left_out} values of more quantities or tags than there may be columns are left out"
        ));
    }
    match survey.cut {
        None => Ok(Outcome::Passed),
        Some(source) => {
            screen.note(&format!("exported as far as the record goes: {} records", survey.records));
            Err(folder.unreadable(source).into())
        }
    }
}

/// Decoders of the traffic; prints a note if there are none.
fn ears_of(survey: &Survey, plan: Option<&str>, screen: &Screen) -> Result<Ears, Failure> {
    let known = ears(&survey.header, plan)?;
    if known.is_none() && survey.of_device {
        screen.note("messages are not decoded: name the plan of the run with --plan FILE");
        return Ok(Ears::deaf());
    }
    Ok(known.unwrap_or_else(Ears::of_base))
}

/// The given plan, or else that of the record, determines whose messages they are; `None` if neither is known.
pub(super) fn ears(header: &Header, plan: Option<&str>) -> Result<Option<Ears>, Failure> {
    Ok(load_recorded(header, plan)?.map(|(_, rig)| Ears::of_rig(&rig)))
}
