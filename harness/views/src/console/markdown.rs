//! Results of runs and campaigns as Markdown, for the summary of a build.

use campaign::Campaign;
use campaign::Measured;
use record::figures;
use record::outcome::{Counts, Measurement, Summary};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Formats runs as one table, one row per measurement, failed ones first.
pub fn runs_markdown(summaries: &[Summary]) -> String {
    let mut text = String::new();
    for summary in summaries {
        let (plan, outcome) = (escaped(&summary.plan), summary.outcome.name());
        let counts = Counts::of(&summary.measurements);
        let _ = writeln!(text, "### {plan}: {outcome}\n\n{}, seed {}", counts, summary.seed);
        if let Some(reason) = &summary.reason {
            let _ = writeln!(text, "\n**{}**", escaped(reason));
        }
        let has_paper = summary.measurements.iter().any(|one| one.paper.is_some());
        if !summary.measurements.is_empty() {
            text += "\n| verdict | measurement | measured | band | margin |";
            text += if has_paper {
                " paper |\n|---|---|---|---|---|---|\n"
            } else {
                "\n|---|---|---|---|---|\n"
            };
        }
        let mut rows: Vec<&Measurement> = summary.measurements.iter().collect();
        rows.sort_by_key(|measurement| measurement.verdict.is_acceptable());
        for measurement in rows {
            text += &measurement_row(measurement, has_paper);
        }
        for property in summary.properties.iter().filter(|property| property.is_broken()) {
            let what = escaped(property.what.as_deref().unwrap_or("broken"));
            let broke = if property.always { " broke" } else { "" };
            let _ = writeln!(text, "\n* **{}**{broke}: {what}", escaped(&property.name));
        }
        for property in summary.properties.iter().filter(|property| !property.is_broken()) {
            if let Some(untested) = property.untested() {
                let _ = writeln!(text, "\n* {}: {}", escaped(&property.name), escaped(&untested));
            }
        }
        for note in &summary.notes {
            let _ = writeln!(text, "\n* {}", escaped(note));
        }
        text.push('\n');
    }
    text
}

fn measurement_row(measurement: &Measurement, has_paper: bool) -> String {
    let Measurement { unit, lower, upper, uncertainty, .. } = measurement;
    let measured = measurement.figure().unwrap_or_else(|| measurement.statistic.clone());
    let margin = measurement.margin().map_or_else(
        || "-".to_owned(),
        |margin| figures::quantity_alone(margin, *uncertainty, unit),
    );
    let verdict = measurement.verdict.in_words();
    let verdict = match measurement.verdict.is_acceptable() {
        true => verdict.to_owned(),
        false => format!("**{verdict}**"),
    };
    let mut cells = vec![
        verdict,
        escaped(&measurement.name),
        escaped(&measured),
        escaped(&figures::band(*lower, *upper, unit)),
        escaped(&margin),
    ];
    if has_paper {
        cells.push(escaped(measurement.paper.as_deref().unwrap_or("-")));
    }
    format!("| {} |\n", cells.join(" | "))
}

/// Formats a campaign: broken properties with the command that reproduces each, and margins of the others. `saved` are
/// the plans of the smallest cases, one for each property that broke.
pub fn campaign_markdown(plan: &str, done: &Campaign, saved: &[PathBuf], replay: &str) -> String {
    let tally = &done.tally;
    let found = done.found.len();
    let mut text = format!(
        "### Campaign {}: {} {} broken in {} cases{}\n\n| property | broken by | least margin | again |\n|---|---|---|---|\n",
        escaped(plan),
        found,
        if found == 1 { "property" } else { "properties" },
        tally.cases,
        if done.stopped { ", stopped" } else { "" },
    );
    let margin = |property: &str| {
        let nearest = tally.nearest.get(property);
        let margin = nearest.and_then(|(margin, _)| figures::least_margin(*margin));
        margin.unwrap_or_else(|| "-".to_owned())
    };
    for (found, path) in done.found.iter().zip(saved) {
        let (property, times) = (escaped(&found.property), found.times);
        let seed = found.shrunk.case.seed;
        let again = format!("hil run {} --seed {seed} {replay}", path.display());
        let (margin, again) = (margin(&found.property), escaped(again.trim_end()));
        let _ = writeln!(text, "| **{property}** | {times} | {margin} | {again} |");
    }
    let is_held = |property: &str| done.found.iter().all(|found| found.property != property);
    for property in tally.nearest.keys().filter(|property| is_held(property)) {
        let times = tally.broken.get(property).map_or(0, |(times, _)| *times);
        let _ = writeln!(text, "| {} | {times} | {} | - |", escaped(property), margin(property));
    }
    if !done.never.is_empty() {
        let never: Vec<String> = done.never.iter().map(|state| escaped(state)).collect();
        let _ = writeln!(text, "\nNever reached: {}", never.join(", "));
    }
    text.push('\n');
    text
}

pub fn envelopes_markdown(plan: &str, all: &[Measured]) -> String {
    const DIGITS: i32 = 3;
    let mut text = format!("### Envelopes {}\n\n", escaped(plan));
    text += "| verdict | fault | tolerated | wanted | silently wrong |\n|---|---|---|---|---|\n";
    for measured @ Measured { envelope, at_least, .. } in all {
        let figure = |severity: Option<f64>| match severity {
            Some(severity) => {
                escaped(&format!("{} {}", figures::exact(severity, DIGITS), envelope.unit))
            }
            None => "-".to_owned(),
        };
        let verdict = if measured.holds() { "holds" } else { "**does not hold**" };
        let fault = escaped(&format!("{} of {}", envelope.kind, envelope.target));
        let (tolerated, wanted) = (figure(envelope.tolerated), figure(*at_least));
        let silent = envelope.most_silent().map_or("none".to_owned(), |level| {
            let at = figure(Some(level.severity));
            format!("{} of {} at {at}", level.silent, level.runs)
        });
        let _ = writeln!(text, "| {verdict} | {fault} | {tolerated} | {wanted} | {silent} |");
    }
    text.push('\n');
    text
}

/// Escapes text for Markdown, also within a table cell.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            '\\' | '|' | '`' | '*' | '_' | '[' | ']' | '~' | '#' | '@' => {
                out.push('\\');
                out.push(c);
            }
            _ if c.is_control() => out.push(' '),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{campaign_markdown, escaped, runs_markdown};
    use crate::console::example;
    use record::outcome::Summary;
    use record::outcome::samples::{properties, summary};

    #[test]
    fn what_failed_comes_first() {
        let text = runs_markdown(&[Summary { properties: properties(), ..summary() }]);
        let row = |name: &str| text.lines().position(|line| line.contains(name)).unwrap();
        assert!(row(r"stop\_error") < row(r"return\_orientation\_ccw"), "{text}");
        insta::assert_snapshot!(text);
    }

    #[test]
    fn without_values_of_the_paper_it_has_no_column() {
        let mut summary = summary();
        summary.measurements.iter_mut().for_each(|one| one.paper = None);
        summary.notes = vec!["12 times a|b".to_owned()];
        let text = runs_markdown(&[summary]);
        assert!(!text.contains("paper"), "{text}");
        let rows = text.lines().filter(|line| line.starts_with('|'));
        assert!(rows.clone().count() > 2 && rows.clone().all(|row| row.matches('|').count() == 6));
        assert!(text.contains("* 12 times a\\|b\n"), "{text}");
    }

    #[test]
    fn a_campaign_says_how_it_breaks_again() {
        let (done, saved) = example();
        insta::assert_snapshot!(campaign_markdown("live-side", &done, &saved, ""));
    }

    #[test]
    fn no_text_breaks_out_of_its_cell() {
        assert_eq!(escaped("a|b\n<img> `c` *d*"), r"a\|b &lt;img&gt; \`c\` \*d\*");
    }
}
