//! The runs of one plan at a bench, one after another: how many pass, and how far their figures are apart.

use super::{Style, closing_line, in_cell, keep_whole, lines, printable};
use plan::confidence::{Z_95, wilson};
use record::figures;
use record::outcome::{Measurement, Outcome, PropertySummary, Summary};
use std::fmt::Write;

const HEADER: [&str; 8] =
    ["procedure", "measurement", "passed", "95 % interval", "least", "mean", "greatest", "band"];

/// Formats the runs as a table, one line per measurement and property of each plan, then a line for each run that did not
/// pass, and a closing line.
pub fn repeated_table(summaries: &[Summary], style: Style) -> String {
    let mut table = style.table(&HEADER);
    let mut told = Vec::new();
    for first in summaries {
        if told.contains(&&first.plan) {
            continue;
        }
        told.push(&first.plan);
        let runs: Vec<&Summary> = summaries.iter().filter(|one| one.plan == first.plan).collect();
        for one in &first.measurements {
            let all = runs.iter().flat_map(|run| run.measurements.iter().map(|one| (*run, one)));
            table.add_row(measured(&first.plan, one, all.filter(|(_, own)| own.name == one.name)));
        }
        for one in &first.properties {
            let all = runs.iter().flat_map(|run| run.properties.iter().map(|one| (*run, one)));
            table.add_row(held(&first.plan, one, all.filter(|(_, own)| own.name == one.name)));
        }
    }
    keep_whole(&mut table, &[0, 1], style);
    let mut text = if table.is_empty() { String::new() } else { lines(&table) + "\n" };
    for summary in summaries {
        if let (Some(reason), Some(run)) = (&summary.reason, summary.repetition()) {
            let (plan, outcome) = (printable(&summary.plan), summary.outcome.name());
            let _ = writeln!(text, "{plan}, run {run}: {outcome}: {}", printable(reason));
        }
    }
    text + &closing_line(summaries) + "\n"
}

/// One that broke off might have measured otherwise later, or broken a property.
const fn is_whole(run: &Summary) -> bool {
    matches!(run.outcome, Outcome::Passed | Outcome::Failed)
}

fn measured<'a>(
    plan: &str,
    one: &Measurement,
    runs: impl Iterator<Item = (&'a Summary, &'a Measurement)> + Clone,
) -> [String; HEADER.len()] {
    let accepted = runs.clone().map(|(run, own)| is_whole(run) && own.verdict.is_acceptable());
    let values: Vec<f64> =
        runs.filter(|(run, _)| is_whole(run)).filter_map(|(_, own)| own.value).collect();
    let shown = |value: f64| {
        let limits = one.lower.into_iter().chain(one.upper);
        in_cell(&figures::quantity_beside(value, 0.0, &one.unit, limits))
    };
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let least = values.iter().copied().min_by(f64::total_cmp);
    let greatest = values.iter().copied().max_by(f64::total_cmp);
    let [least, mean, greatest] =
        [least, least.map(|_| mean), greatest].map(|one| one.map_or_else(nothing, shown));
    let band = in_cell(&figures::band(one.lower, one.upper, &one.unit));
    let (passed, interval) = share(accepted);
    [in_cell(plan), in_cell(&one.name), passed, interval, least, mean, greatest, band]
}

fn held<'a>(
    plan: &str,
    one: &PropertySummary,
    runs: impl Iterator<Item = (&'a Summary, &'a PropertySummary)>,
) -> [String; HEADER.len()] {
    let judged = runs.filter_map(|(run, own)| own.held.map(|held| held && is_whole(run)));
    let (passed, interval) = share(judged);
    let word = if one.always { "always" } else { "sometimes" }.to_owned();
    let [least, mean, greatest] = [nothing(), nothing(), nothing()];
    [in_cell(plan), in_cell(&one.name), passed, interval, least, mean, greatest, word]
}

/// `19 of 20`, and the 95 % Wilson interval of the share.
fn share(runs: impl Iterator<Item = bool>) -> (String, String) {
    let judged: Vec<bool> = runs.collect();
    let good = judged.iter().filter(|good| **good).count();
    match wilson(good as u64, judged.len() as u64, Z_95) {
        Some(interval) => (format!("{good} of {}", judged.len()), interval.percent()),
        None => ("not judged".to_owned(), nothing()),
    }
}

fn nothing() -> String {
    "-".to_owned()
}

#[cfg(test)]
mod tests {
    use super::repeated_table;
    use crate::console::Style;
    use record::Bench;
    use record::outcome::samples::{properties, summary};
    use record::outcome::{Outcome, Summary};

    fn run(repetition: u32, value: f64) -> Summary {
        let mut run = Summary {
            bench: Some(Bench { repetition: Some(repetition), ..Bench::default() }),
            properties: properties(),
            outcome: Outcome::Passed,
            reason: None,
            ..summary()
        };
        run.measurements[0].value = Some(value);
        run
    }

    #[test]
    fn the_runs_of_a_plan_are_one_line_a_measurement() {
        let mut late = run(3, 0.9);
        late.measurements[1].value = None;
        late.outcome = Outcome::Error;
        late.reason = Some("base: no such port".to_owned());
        let runs = [run(1, 0.2), run(2, 0.3), late];
        insta::assert_snapshot!(repeated_table(&runs, Style::PLAIN));
    }
}
