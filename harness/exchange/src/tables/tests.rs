//! What is written into a table can be read back.

use super::cell::{Cell, Column, Kind};
use super::csv::CsvTable;
use super::parquet::{COLUMNS_KEY, ParquetTable};
use super::survey::Survey;
use super::{Ears, Format, Row, RowSink, Rows, Table, export, survey, tagged};
use crate::ExportError;
use controller::mission::{Report, State, Uncertainty};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use proptest::prelude::*;
use record::header::Header;
use record::outcome::samples::summary;
use record::run_folder::RunFolder;
use record::samples::{self, any_record, observation, one_of_each, record};
use record::sink::{Level, RecordSink};
use record::{Device, Record, RecordKind};
use std::collections::BTreeMap;
use std::convert::Infallible;
use wire::time::Timestamp;
use wire::units::{Angle, Length};

/// Keeps rows.
#[derive(Default)]
struct Kept(BTreeMap<Table, Vec<Vec<Cell<'static>>>>);

impl RowSink for Kept {
    type Error = Infallible;

    fn row(&mut self, _: Timestamp, table: Table, row: &Row<'_>) -> Result<(), Infallible> {
        let owned = row.iter().map(|cell| match cell {
            Cell::Text(text) => Cell::text(text.to_string()),
            Cell::Float(number) => Cell::Float(*number),
            Cell::Integer(number) => Cell::Integer(*number),
            Cell::Bool(yes) => Cell::Bool(*yes),
            Cell::Missing => Cell::Missing,
        });
        self.0.entry(table).or_default().push(owned.collect());
        Ok(())
    }
}

fn rows_of(records: &[Record]) -> (Survey, Kept) {
    let survey = Survey::of(&Header::default(), records.iter().cloned().map(Ok));
    let (mut rows, mut kept) = (Rows::new(survey, Ears::of_base()), Kept::default());
    for record in records {
        let Ok(()) = rows.take(record, &mut kept);
    }
    (rows.into_survey(), kept)
}

fn is_of(cell: &Cell<'_>, kind: Kind) -> bool {
    match cell {
        Cell::Missing => true,
        Cell::Float(number) => kind == Kind::Float && number.is_finite(),
        Cell::Integer(_) => kind == Kind::Integer,
        Cell::Bool(_) => kind == Kind::Bool,
        Cell::Text(text) => kind == Kind::Text && !text.is_empty(),
    }
}

fn through_parquet(columns: &[Column], rows: &[Vec<Cell<'static>>]) -> Vec<Vec<Cell<'static>>> {
    let file = tempfile::tempfile().unwrap();
    let mut table = ParquetTable::new(file.try_clone().unwrap(), columns, &[]).unwrap();
    rows.iter().for_each(|row| table.row(row).unwrap());
    table.finish().unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let cell = |field: &Field| match field {
        Field::Null => Cell::Missing,
        Field::Bool(yes) => Cell::Bool(*yes),
        Field::Long(number) => Cell::Integer(*number),
        Field::Double(number) => Cell::Float(*number),
        Field::Str(text) => Cell::text(text.clone()),
        other => panic!("{other:?}"),
    };
    let read =
        |row: parquet::record::Row| row.get_column_iter().map(|(_, field)| cell(field)).collect();
    reader.get_row_iter(None).unwrap().map(|row| read(row.unwrap())).collect()
}

fn through_csv(columns: &[Column], rows: &[Vec<Cell<'static>>]) -> Vec<Vec<Cell<'static>>> {
    let mut bytes = Vec::new();
    let mut table = CsvTable::new(&mut bytes, columns).unwrap();
    rows.iter().for_each(|row| table.row(row).unwrap());
    table.finish().unwrap();
    let mut reader = csv::Reader::from_reader(&bytes[..]);
    let names = reader.headers().unwrap().clone();
    assert!(names.iter().eq(columns.iter().map(|column| &*column.name)));
    let cell = |(text, column): (&str, &Column)| match column.kind {
        _ if text.is_empty() => Cell::Missing,
        Kind::Float => Cell::Float(text.parse().unwrap()),
        Kind::Integer => Cell::Integer(text.parse().unwrap()),
        Kind::Bool => Cell::Bool(text.parse().unwrap()),
        Kind::Text => Cell::text(text.to_owned()),
    };
    let read = |row: csv::StringRecord| row.iter().zip(columns).map(cell).collect();
    reader.records().map(|row| read(row.unwrap())).collect()
}

proptest! {
    #[test]
    fn whatever_was_recorded_comes_out_again(records in prop::collection::vec(any_record(), 1..40)) {
        let (survey, kept) = rows_of(&records);
        for (table, rows) in &kept.0 {
            let columns = table.columns(&survey);
            let names: std::collections::BTreeSet<_> =
                columns.iter().map(|column| column.name.to_lowercase()).collect();
            prop_assert_eq!(names.len(), columns.len());
            for row in rows {
                prop_assert_eq!(row.len(), columns.len());
                prop_assert!(row.iter().zip(&columns).all(|(cell, column)| is_of(cell, column.kind)));
            }
            prop_assert_eq!(&through_csv(&columns, rows), rows);
            prop_assert_eq!(&through_parquet(&columns, rows), rows);
        }
    }
}

#[test]
fn each_kind_of_record_has_its_rows() {
    let (survey, kept) = rows_of(&one_of_each());
    let shown = kept.0.iter().flat_map(|(table, rows)| {
        let columns = table.columns(&survey);
        rows.iter().map(move |row| {
            let named = row.iter().zip(&columns).filter(|(cell, _)| **cell != Cell::Missing);
            let cells = named.map(|(cell, column)| match cell {
                Cell::Float(number) => format!("{}={number}", column.name),
                Cell::Integer(number) => format!("{}={number}", column.name),
                Cell::Bool(yes) => format!("{}={yes}", column.name),
                Cell::Text(text) => format!("{}={text:?}", column.name),
                Cell::Missing => String::new(),
            });
            format!("{}: {}", table.name(), cells.collect::<Vec<_>>().join(" "))
        })
    });
    insta::assert_snapshot!(shown.collect::<Vec<_>>().join("\n"));
}

#[test]
fn what_an_estimator_says_of_itself_is_in_the_table() {
    let uncertainty = Uncertainty {
        heading: Angle::from_deg(0.25),
        x: Length::from_m(0.002),
        y: Length::from_m(0.003),
    };
    let state = State { uncertainty: Some(uncertainty), ..samples::state(0.0, 0.0) };
    let kind = RecordKind::Report(Report::State(state));
    let (survey, kept) =
        rows_of(&[Record { at: Timestamp::ZERO, device: Device::Controller, kind }]);
    let row = &kept.0[&Table::States][0];
    let columns = Table::States.columns(&survey);
    let told = row.iter().zip(&columns).filter(|(_, column)| column.name.contains("uncertainty"));
    let told: Vec<_> = told.map(|(cell, column)| (&*column.name, cell.clone())).collect();
    let expected =
        [("heading_uncertainty_deg", 0.25), ("x_uncertainty_m", 0.002), ("y_uncertainty_m", 0.003)];
    assert_eq!(told, expected.map(|(name, value)| (name, Cell::Float(value))));
}

#[test]
fn columns_are_named_by_their_units() {
    for table in Table::ALL {
        for column in table.fixed_columns() {
            let named = super::cell::with_unit(&column.name, &column.unit);
            assert_eq!(named, column.name, "{}", table.name());
            assert!(!column.doc.is_empty());
        }
    }
}

#[test]
fn tags_take_no_name_that_is_taken() {
    let fixed = Table::Observations.fixed_columns().to_vec();
    let columns = tagged(fixed, &["Value", "during.a b", "during.a_b", "temperature", "time"]);
    let names: Vec<_> = columns[5..].iter().map(|column| &*column.name).collect();
    let expected =
        ["tag_Value", "during_a_b", "tag_during_a_b", "temperature_celsius", "tag_time_s"];
    assert_eq!(names, expected);
}

#[test]
fn parquet_says_what_its_columns_are() {
    let file = tempfile::tempfile().unwrap();
    let columns = Table::Truth.fixed_columns();
    let plan = [("hil.plan", "laps".to_owned())];
    ParquetTable::new(file.try_clone().unwrap(), columns, &plan).unwrap().finish().unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let facts = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let fact =
        |key: &str| facts.iter().find(|fact| fact.key == key).unwrap().value.clone().unwrap();
    assert_eq!(fact("hil.plan"), "laps");
    let columns: serde_json::Value = serde_json::from_str(&fact(COLUMNS_KEY)).unwrap();
    assert_eq!(columns["bias_deg_per_h"]["unit"], "deg/h");
}

fn folder(path: &std::path::Path, records: Vec<Record>, ended: bool) -> RunFolder {
    let folder = RunFolder::create(path).unwrap();
    let mut sink = folder.record_sink(&Header::default(), Level::Full).unwrap();
    records.into_iter().for_each(|record| sink.record(record));
    if ended {
        sink.finish();
        folder.write_summary(&summary()).unwrap();
    }
    drop(sink);
    folder
}

#[test]
fn an_export_replaces_its_own_files_and_no_others() {
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), one_of_each(), true);
    let out = dir.path().join("tables");
    export(&run, survey(&run).unwrap(), &out, Format::Csv, Ears::of_base()).unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let exported =
        export(&run, survey(&run).unwrap(), &out, Format::Parquet, Ears::of_base()).unwrap();
    assert!(!out.join("states.csv").exists() && out.join("notes.txt").exists());
    let package = std::fs::read_to_string(out.join(super::PACKAGE)).unwrap();
    let package: serde_json::Value = serde_json::from_str(&package).unwrap();
    for (table, rows) in &exported.written {
        let resources = package["resources"].as_array().unwrap();
        let resource = resources.iter().find(|one| one["name"] == *table).unwrap();
        assert_eq!(resource["rows"], *rows);
        assert!(out.join(resource["path"].as_str().unwrap()).is_file());
    }
    // A data set is not a package of tables.
    std::fs::write(out.join(super::PACKAGE), r#"{"profile": "data-package"}"#).unwrap();
    let error =
        export(&run, survey(&run).unwrap(), &out, Format::Parquet, Ears::of_base()).unwrap_err();
    assert!(
        matches!(error, ExportError::Foreign { .. })
            && error.to_string().starts_with("refused to replace"),
        "{error}"
    );
}

#[test]
fn a_folder_of_somebody_else_stays_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), one_of_each(), true);
    let out = dir.path().join("tables");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("thesis.txt"), "mine").unwrap();
    let export = || export(&run, survey(&run).unwrap(), &out, Format::Parquet, Ears::of_base());
    let error = export().unwrap_err();
    assert!(
        matches!(error, ExportError::Foreign { .. })
            && error.to_string().contains("tables: it holds files"),
        "{error}"
    );
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
    std::fs::remove_file(out.join("thesis.txt")).unwrap();
    export().unwrap();
}

#[test]
fn what_is_left_of_a_record_is_exported_and_said() {
    let dir = tempfile::tempdir().unwrap();
    let run = folder(&dir.path().join("run"), one_of_each(), false);
    let exported =
        export(&run, survey(&run).unwrap(), &dir.path().join("tables"), Format::Csv, Ears::deaf())
            .unwrap();
    assert!(exported.survey.cut.is_some());
    assert_eq!(exported.survey.records, one_of_each().len() as u64);
    let package = std::fs::read_to_string(dir.path().join("tables/datapackage.json")).unwrap();
    assert!(package.contains("the record is cut short"), "{package}");
}

#[test]
fn quantities_and_tags_are_bounded_and_counted() {
    let tags: Vec<String> = (0..300).map(|n| format!("t{n}")).collect();
    let tags: Vec<(&str, f64)> = tags.iter().map(|tag| (tag.as_str(), 1.0)).collect();
    let many =
        (0..1_500).map(|n| record(1.0, Device::Plan, observation(&format!("q{n}"), 0.0, &[])));
    let records = many.chain([record(2.0, Device::Plan, observation("q0", 0.0, &tags))]);
    let survey = Survey::of(&Header::default(), records.map(Ok));
    assert_eq!(survey.quantities.len(), super::survey::QUANTITIES_MAX);
    assert_eq!(survey.tags().len(), super::survey::TAGS_MAX);
    assert_eq!(survey.left_out, (1_500 - 1_024) + (300 - 256));
}
