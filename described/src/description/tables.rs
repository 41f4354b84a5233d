//! Look-up tables of a file.

use crate::error::Mistake;
use crate::file::LookupTable;
use crate::files::Files;
use crate::lookup::Lookup;
use crate::place::Place;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Both axes, the second empty in one dimension, and the values.
type Points = (Vec<f64>, Vec<f64>, Vec<f64>);

pub(super) fn tables(
    tables: &BTreeMap<String, LookupTable>,
    files: &mut dyn Files,
) -> Result<BTreeMap<String, Arc<Lookup>>, Mistake> {
    let all = Place::file().key("table");
    let read = |(name, table): (&String, &LookupTable)| {
        let place = all.key(name);
        let (x, y, values) = points(table, &place, files)?;
        let at = |key: &str| place.key(if table.csv.is_some() { "csv" } else { key });
        axis(&x, "x", &at("x"))?;
        if !y.is_empty() {
            axis(&y, "y", &at("y"))?;
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            let text = format!("{value} is not a value of a table");
            return Err(Mistake::new(at(if table.z.is_some() { "z" } else { "y" }), text));
        }
        Ok((name.clone(), Arc::new(Lookup::new(x, y, values, table.outside))))
    };
    tables.iter().map(read).collect()
}

fn points(table: &LookupTable, place: &Place, files: &mut dyn Files) -> Result<Points, Mistake> {
    match (&table.x, &table.y, &table.z, &table.csv) {
        (Some(x), Some(y), None, None) => {
            count(y.len(), x.len(), "values", &place.key("y"))?;
            Ok((x.clone(), Vec::new(), y.clone()))
        }
        (Some(x), Some(y), Some(z), None) => {
            count(z.len(), x.len(), "rows", &place.key("z"))?;
            for (row, values) in z.iter().enumerate() {
                count(values.len(), y.len(), "values", &place.key("z").index(row))?;
            }
            if y.is_empty() {
                return Err(Mistake::new(place.key("y"), "an axis has two points or more"));
            }
            Ok((x.clone(), y.clone(), z.concat()))
        }
        (None, None, None, Some(csv)) => {
            let place = place.key("csv");
            let text = files.text(csv).map_err(|error| {
                Mistake::new(place.clone(), format!("failed to read `{csv}`: {error}"))
            })?;
            from_csv(csv, &text, &place)
        }
        _ => Err(Mistake::new(place.clone(), "a table has its points in one way")
            .help("`x` and `y`; `x`, `y` and `z`; or `csv`")),
    }
}

fn count(found: usize, expected: usize, what: &str, place: &Place) -> Result<(), Mistake> {
    if found == expected {
        return Ok(());
    }
    Err(Mistake::new(place.clone(), format!("{found} {what}, and {expected} points")))
}

fn axis(points: &[f64], name: &str, place: &Place) -> Result<(), Mistake> {
    if points.len() < 2 {
        return Err(Mistake::new(place.clone(), "an axis has two points or more"));
    }
    if let Some(point) = points.iter().find(|point| !point.is_finite()) {
        return Err(Mistake::new(place.clone(), format!("{point} is not a point of an axis")));
    }
    match points.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => {
            let text = format!("`{name}` does not increase from {} to {}", pair[0], pair[1]);
            Err(Mistake::new(place.clone(), text))
        }
        None => Ok(()),
    }
}

/// Two columns; or, if the first line has numbers after its first cell, the second axis there and the first one below.
fn from_csv(file: &str, text: &str, place: &Place) -> Result<Points, Mistake> {
    let failed = |error: csv::Error| Mistake::new(place.clone(), format!("`{file}`: {error}"));
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(failed)?.clone();
    let along: Result<Vec<f64>, _> = headers.iter().skip(1).map(str::parse).collect();
    let y = along.unwrap_or_default();
    let columns = if y.is_empty() { 2 } else { headers.len() };
    let (mut x, mut values) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(failed)?;
        let line = record.position().map_or(0, csv::Position::line);
        for column in 0..columns {
            let cell = record.get(column).unwrap_or_default();
            let number = cell.parse::<f64>().map_err(|_| {
                let text = format!("`{file}` line {line}: `{cell}` is not a number");
                Mistake::new(place.clone(), text)
            })?;
            if column == 0 { x.push(number) } else { values.push(number) }
        }
    }
    Ok((x, y, values))
}
