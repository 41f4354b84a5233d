//! Look-up tables of a file.

use super::parts;
use crate::error::{Mistake, Read};
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
) -> Read<BTreeMap<String, Arc<Lookup>>> {
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

fn points(table: &LookupTable, place: &Place, files: &mut dyn Files) -> Read<Points> {
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
            let text = parts::text(files, csv, &place)?;
            from_csv(csv, &text, &place)
        }
        _ => Err(Mistake::new(place.clone(), "a table has its points in one way")
            .help("`x` and `y`; `x`, `y` and `z`; or `csv`")),
    }
}

fn count(found: usize, expected: usize, what: &str, place: &Place) -> Read {
    if found == expected {
        return Ok(());
    }
    Err(Mistake::new(place.clone(), format!("{found} {what}, and {expected} points")))
}

fn axis(points: &[f64], name: &str, place: &Place) -> Read {
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
fn from_csv(file: &str, text: &str, place: &Place) -> Read<Points> {
    let (mut y, mut columns) = (Vec::new(), 2);
    let numbers = parts::csv((file, text), place, usize::MAX, |headers| {
        let along: Result<Vec<f64>, _> = headers.iter().skip(1).map(str::parse).collect();
        y = along.unwrap_or_default();
        columns = if y.is_empty() { 2 } else { headers.len() };
        Ok((0..columns).collect())
    })?;
    let rows = numbers.chunks_exact(columns);
    let (x, values): (Vec<f64>, Vec<&[f64]>) = rows.map(|row| (row[0], &row[1..])).unzip();
    Ok((x, y, values.concat()))
}
