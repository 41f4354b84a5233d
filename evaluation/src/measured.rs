//! Real data sets: reads data packages on disk, as far as the sets of the project need it.

use flate2::read::MultiGzDecoder;
use identification::dataset::{Axis, Column, Constant, Dataset, Drive, Kind, Role, Unit};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

#[derive(Deserialize)]
struct Package {
    name: String,
    hil: Hil,
    resources: Vec<Resource>,
}

#[derive(Deserialize)]
struct Hil {
    kind: String,
    drive: Option<String>,
    #[serde(default)]
    constants: BTreeMap<String, Quantity>,
}

#[derive(Deserialize)]
struct Quantity {
    value: f64,
    unit: String,
}

#[derive(Deserialize)]
struct Resource {
    path: String,
    schema: Schema,
}

#[derive(Deserialize)]
struct Schema {
    fields: Vec<Field>,
}

#[derive(Deserialize)]
struct Field {
    name: String,
    unit: String,
    role: String,
    axis: Option<String>,
}

/// Reads the package in `folder`. Words of a field become numbers in order of appearance.
///
/// # Errors
///
/// A message, if the package cannot be read or is of an unknown kind.
pub fn read(folder: &Path) -> Result<Dataset, String> {
    let text = std::fs::read_to_string(folder.join("datapackage.json"))
        .map_err(|error| format!("{}: {error}", folder.display()))?;
    let package: Package = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let unit = |text: &str| Unit::parse(text).ok_or_else(|| format!("no unit `{text}`"));
    let mut constants = BTreeMap::new();
    for (name, quantity) in &package.hil.constants {
        let constant = Constant { value: quantity.value, unit: unit(&quantity.unit)? };
        constants.insert(name.clone(), constant);
    }
    let resource = package.resources.first().ok_or("no table")?;
    let (names, cells) = table(&folder.join(&resource.path))?;
    let mut columns = Vec::new();
    let mut runs: Vec<String> = vec!["0".to_owned(); cells.len()];
    for field in &resource.schema.fields {
        let role = Role::parse(&field.role).ok_or_else(|| format!("no role `{}`", field.role))?;
        let at = names.iter().position(|name| *name == field.name).ok_or("no such column")?;
        if role == Role::Run {
            runs = cells.iter().map(|row| row[at].clone()).collect();
            continue;
        }
        if role == Role::Ignore {
            continue;
        }
        let axis = match field.axis.as_deref() {
            Some("x") => Some(Axis::X),
            Some("y") => Some(Axis::Y),
            Some("z") => Some(Axis::Z),
            _ => None,
        };
        let values = numbers(cells.iter().map(|row| row[at].as_str()));
        columns.push(Column {
            name: field.name.clone(),
            role,
            axis,
            unit: unit(&field.unit)?,
            values,
        });
    }
    let kind = Kind::parse(&package.hil.kind)
        .ok_or_else(|| format!("kind `{}` is not known", package.hil.kind))?;
    let drive = match package.hil.drive.as_deref() {
        None => None,
        Some(text) => Some(Drive::parse(text).ok_or_else(|| format!("no drive `{text}`"))?),
    };
    Ok(of_whole_rows(Dataset {
        name: package.name,
        kind,
        drive,
        constants,
        columns,
        run_of_row: Vec::new(),
        run_labels: runs,
        notices: Vec::new(),
    }))
}

/// Names of the columns, and the cells of every row.
fn table(path: &Path) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
    let file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let input: Box<dyn Read> = if path.extension().is_some_and(|end| end == "gz") {
        Box::new(MultiGzDecoder::new(file))
    } else {
        Box::new(file)
    };
    let mut reader = csv::Reader::from_reader(input);
    let names = reader.headers().map_err(|error| error.to_string())?;
    let names = names.iter().map(str::to_owned).collect();
    let rows: Result<Vec<Vec<String>>, csv::Error> =
        reader.records().map(|row| Ok(row?.iter().map(str::to_owned).collect())).collect();
    Ok((names, rows.map_err(|error| error.to_string())?))
}

fn numbers<'a>(cells: impl Iterator<Item = &'a str>) -> Vec<f64> {
    let mut words: Vec<&str> = Vec::new();
    cells
        .map(|cell| match cell.trim() {
            "" => f64::NAN,
            text => text.parse().unwrap_or_else(|_| {
                let place = words.iter().position(|word| *word == text).unwrap_or_else(|| {
                    words.push(text);
                    words.len() - 1
                });
                place as f64
            }),
        })
        .collect()
}

/// Drops rows that lack a measured value. `run_labels` holds the run of each row on input.
fn of_whole_rows(mut dataset: Dataset) -> Dataset {
    let needed = |column: &&Column| !column.role.is_reference() && column.role != Role::Auxiliary;
    let is_whole = |row: &usize| {
        dataset.columns.iter().filter(needed).all(|column| column.values[*row].is_finite())
    };
    let keep: Vec<usize> = (0..dataset.run_labels.len()).filter(is_whole).collect();
    for column in &mut dataset.columns {
        column.values = keep.iter().map(|&row| column.values[row]).collect();
    }
    let mut labels: Vec<String> = Vec::new();
    let mut of_row = Vec::with_capacity(keep.len());
    for &row in &keep {
        let label = &dataset.run_labels[row];
        let place = labels.iter().position(|known| known == label).unwrap_or_else(|| {
            labels.push(label.clone());
            labels.len() - 1
        });
        of_row.push(place);
    }
    dataset.run_of_row = of_row;
    dataset.run_labels = labels;
    dataset
}

/// A finding in some lines.
pub fn summary(finding: &identification::finding::Finding) -> String {
    use std::fmt::Write;
    let mut text = format!(
        "{:?}, floor {:.3e} {}\n",
        finding.verdict, finding.noise_floor.value, finding.noise_floor.unit
    );
    for sentence in finding.in_words() {
        let _ = writeln!(text, "  {sentence}");
    }
    for one in std::iter::once(&finding.held_out).chain(&finding.held_out_also) {
        let _ = writeln!(
            text,
            "  {} {:.5} -> {:.5} {} [{:.4} {:.4}]",
            one.quantity.as_deref().unwrap_or("-"),
            one.before,
            one.after,
            one.unit,
            one.ci95[0],
            one.ci95[1]
        );
    }
    for parameter in &finding.base {
        let _ = writeln!(
            text,
            "  base {} {:.5} +- {:.5} {}",
            parameter.name,
            parameter.value,
            parameter.standard_error.unwrap_or(f64::NAN),
            parameter.unit
        );
    }
    for effect in &finding.effects {
        let _ = write!(
            text,
            "  * {} {} {:?} {:?} {} p {:.1e} ho {:.5} -> {:.5}:",
            effect.name,
            effect.term,
            effect.axis,
            effect.drivers,
            effect.form,
            effect.p_value,
            effect.held_out_before,
            effect.held_out_after
        );
        for parameter in effect.parameters.iter().take(6) {
            let _ = write!(
                text,
                " {} {:.4}+-{:.4} {}",
                parameter.name,
                parameter.value,
                parameter.standard_error.unwrap_or(f64::NAN),
                parameter.unit
            );
        }
        let rivals: Vec<String> = effect
            .rivals
            .iter()
            .map(|rival| format!("{} {:.2}", rival.name, rival.probability))
            .collect();
        let _ = writeln!(text, " rivals {rivals:?}");
    }
    for model in &finding.path {
        let _ = write!(text, "  path {}", if model.chosen { "->" } else { "  " });
        for (name, error) in &model.held_out {
            let _ = write!(text, " {name} {:.5}+-{:.5}", error.value, error.standard_error);
        }
        let _ = writeln!(text, " {:?}", model.effects);
    }
    for left in &finding.left {
        let _ = writeln!(
            text,
            "  left {:?} {} {:.4}",
            left.drivers, left.shape, left.share_of_residual_variance
        );
    }
    for one in &finding.set_aside {
        let _ = writeln!(text, "  aside {} of {} at {:?}", one.rows, one.quantity, one.times);
    }
    for notice in &finding.notices {
        let _ = writeln!(text, "  note {notice}");
    }
    text
}
