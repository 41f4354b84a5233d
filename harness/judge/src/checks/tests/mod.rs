//! Checks as a plan declares them, on observations as the engine makes them.

mod properties;
mod table;

use plan::Declared;
use plan::observation::Observation;
use record::outcome::{Measurement, Verdict};

/// A measurement of `quantity` with this check, both in TOML.
fn declared(quantity: &str, check: &str) -> Declared {
    let text = format!(
        "name = \"m\"\ndoc = \"d\"\nquantity = \"{quantity}\"\nunit = \"u\"\ncheck = {check}\n"
    );
    toml::from_str(&text).unwrap_or_else(|error| panic!("{check}: {error}"))
}

fn observation(quantity: &str, value: f64, uncertainty: f64, tags: &[(&str, f64)]) -> Observation {
    Observation {
        quantity: quantity.to_owned(),
        value,
        uncertainty,
        tags: tags.iter().map(|&(tag, value)| (tag.to_owned(), value)).collect(),
    }
}

/// Table errors with this standard uncertainty, one per second; the temperature rises by 1 degC each.
fn table_errors(values: &[f64], uncertainty: f64) -> Vec<Observation> {
    let tags = |index: usize| {
        let index = index as f64;
        [("time", index), ("temperature", 20.0 + index), ("run", 1.0 + index)]
    };
    let each = |(index, &value): (usize, &f64)| {
        observation("table.error", value, uncertainty, &tags(index))
    };
    values.iter().enumerate().map(each).collect()
}

fn judge(declared: &Declared, observations: &[Observation]) -> Measurement {
    super::judge(declared, &observations.iter().collect())
}

fn verdict(check: &str, observations: &[Observation]) -> Verdict {
    judge(&declared("table.error", check), observations).verdict
}

fn judged(check: &str, observations: &[Observation]) -> Measurement {
    judge(&declared("table.error", check), observations)
}
