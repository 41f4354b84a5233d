//! Results of a campaign, and the tolerated severity of faults.

use super::{Style, in_cell, lines, printable};
use campaign::Measured;
use campaign::{Campaign, Envelope, Level, Repeated, Shrunk, Small};
use comfy_table::Cell;
use judge::properties::Unjudged;
use plan::faults::Fault;
use record::figures;
use record::outcome::Outcome;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Additional results of a campaign on a bench, compared with one in virtual time.
#[derive(Debug, Clone, PartialEq)]
pub struct Again<'a> {
    /// Fresh repetitions of the smallest case of each property that broke; `None` if the bench broke or the user
    /// stopped the campaign.
    pub confirmed: Vec<Option<Repeated>>,
    /// Properties that this bench cannot judge.
    pub unjudged: &'a [Unjudged],
    /// Confidence level of the shares.
    pub confidence: f64,
}

impl Again<'_> {
    /// `broke in 7 of 8 repetitions; the property breaks in at least 53 % of runs at 95 % confidence`.
    fn line(&self, index: usize) -> String {
        let percent = figures::exact(100.0 * self.confidence, 4);
        match self.confirmed.get(index).copied().flatten() {
            Some(Repeated { broke, of, at_least }) => format!(
                "broke in {broke} of {of} repetitions; the property breaks in at least {:.0} % of runs at \
                 {percent} % confidence",
                // A lower bound is rounded down.
                (100.0 * at_least).floor()
            ),
            None => "not repeated once it was small".to_owned(),
        }
    }
}

/// Formats tables for a terminal: broken properties, margins of the others, and reached states. `saved` are the plans
/// of the smallest cases, one for each property that broke.
pub fn campaign_table(
    done: &Campaign,
    saved: &[PathBuf],
    again: Option<&Again<'_>>,
    style: Style,
) -> String {
    let tally = &done.tally;
    let mut text = String::new();
    if !tally.nearest.is_empty() || !tally.broken.is_empty() {
        let mut table = style.table(&["always", "broken by", "least margin", "case"]);
        for (property, (margin, number)) in &tally.nearest {
            let times = tally.broken.get(property).map_or(0, |(times, _)| *times);
            let cells = [
                in_cell(property),
                format!("{times} of {}", tally.judged(property)),
                figures::least_margin(*margin).unwrap_or_else(|| "-".to_owned()),
                number.to_string(),
            ];
            table.add_row(cells.map(Cell::new));
        }
        for (property, (times, number)) in &tally.broken {
            if !tally.nearest.contains_key(property) {
                let of = format!("{times} of {}", tally.judged(property));
                let cells = [in_cell(property), of, "-".to_owned(), number.to_string()];
                table.add_row(cells.map(Cell::new));
            }
        }
        text += &lines(&table);
    }
    let reached = tally.reached.iter().map(|(state, times)| (state, *times));
    let never = done.never.iter().map(|state| (state, 0));
    let mut states = reached.chain(never).peekable();
    if states.peek().is_some() {
        let mut table = style.table(&["sometimes", "reached by"]);
        for (state, times) in states {
            let times = match times {
                0 => "no case".to_owned(),
                _ => figures::counted(times, "case", "cases"),
            };
            table.add_row([in_cell(state), times].map(Cell::new));
        }
        text += "\n";
        text += &lines(&table);
    }
    for (index, (found, path)) in done.found.iter().zip(saved).enumerate() {
        let what = found.shrunk.result.violated.iter().find(|v| v.property == found.property);
        let faults = found.shrunk.case.schedule.faults.len();
        let _ = write!(
            text,
            "\n{}: case {}, {}, seed {}\n  {}\n  {}\n",
            in_cell(&found.property),
            found.number,
            shrunk(
                &figures::counted(faults as u64, "fault", "faults"),
                &figures::counted(found.shrunk.executions, "run", "runs"),
                &found.shrunk,
            ),
            found.shrunk.case.seed,
            what.map_or(String::new(), |v| format!("at {:.3} s: {}", v.at_s, in_cell(&v.what))),
            path.display(),
        );
        if let Some(again) = again {
            let _ = writeln!(text, "  {}", again.line(index));
        }
    }
    for (property, times) in &tally.unconfirmed {
        let (property, s) = (printable(property), if *times == 1 { "" } else { "s" });
        let _ = write!(
            text,
            "\n{property}: broke once in {times} case{s}, but not often enough in the repetitions\n"
        );
    }
    for (property, (times, why)) in &tally.unjudged {
        let (property, cases) = (printable(property), figures::counted(*times, "case", "cases"));
        let _ = write!(text, "\n{property}: nothing to judge in {cases}, as in the first: {why}\n");
    }
    for property in tally.untested() {
        let _ = write!(text, "\n{}: no case put it to the test\n", printable(property));
    }
    for one in again.map_or(&[][..], |again| again.unjudged) {
        let _ = write!(text, "\n{} not judged: {}\n", one.name, one.why);
    }
    for (outcome, (number, reason)) in &tally.reasons {
        let _ = writeln!(text, "\n{}, first in case {number}: {}", ended(outcome), in_cell(reason));
    }
    let outcomes: Vec<String> =
        tally.outcomes.iter().map(|(name, times)| format!("{times} {}", ended(name))).collect();
    let _ = writeln!(
        text,
        "\n{}{} cases ({}{}), {} propert{} broken",
        if done.stopped { "stopped after " } else { "" },
        tally.cases,
        outcomes.join(", "),
        if tally.resumed > 0 { format!("; {} done before", tally.resumed) } else { String::new() },
        tally.broken.len(),
        if tally.broken.len() == 1 { "y" } else { "ies" },
    );
    text
}

/// How far a case was shrunk, to these faults in these runs.
fn shrunk(faults: &str, runs: &str, shrunk: &Shrunk) -> String {
    match shrunk.small() {
        _ if shrunk.executions == 0 => format!("{faults}, not shrunk"),
        Small::InPart => format!("shrunk in part to {faults} in {runs}"),
        _ => format!("shrunk to {faults} in {runs}"),
    }
}

pub fn campaign_json(done: &Campaign, saved: &[PathBuf], again: Option<&Again<'_>>) -> String {
    let tally = &done.tally;
    let found: Vec<Value> = done
        .found
        .iter()
        .zip(saved)
        .enumerate()
        .map(|(index, (found, path))| {
            json!({
                "repeated": again.and_then(|again| again.confirmed.get(index)),
                "property": found.property,
                "case": found.number,
                "times": found.times,
                "shrink_executions": found.shrunk.executions,
                "smallest": found.shrunk.case,
                "result": found.shrunk.result,
                "plan": path.display().to_string(),
            })
        })
        .collect();
    let value = json!({
        "cases": tally.cases,
        "resumed": tally.resumed,
        "passed": tally.passed,
        "outcomes": tally.outcomes,
        "reasons": tally.reasons,
        "nearest": tally.nearest,
        "reached": tally.reached,
        "never": done.never,
        "missed": done.missed,
        "untested": tally.untested().collect::<Vec<_>>(),
        "unjudged": tally.unjudged,
        "found": found,
        "unconfirmed": tally.unconfirmed,
        "not_judged": again.map(|again| {
            let why = |one: &Unjudged| (one.name.to_owned(), Value::from(one.why.clone()));
            again.unjudged.iter().map(why).collect::<serde_json::Map<_, _>>()
        }),
        "confidence": again.map(|again| again.confidence),
        "stopped": done.stopped,
    });
    value.to_string()
}

/// Formats the measurement of one severity. `tells`: whether a controller can announce a failure.
pub fn level_line(level: &Level, fault: &Fault, tells: bool) -> String {
    let unit = fault.what.info().parameters.first().map_or("", |first| first.unit);
    let silent = match tells {
        true => format!(", {} are silently wrong", level.silent),
        false => String::new(),
    };
    format!(
        "{fault}: {}: {} of {} runs pass ({:.1} to {:.1} %){silent}",
        figures::with_unit(figure(level.severity), unit),
        level.passed,
        level.runs,
        100.0 * level.interval.0,
        100.0 * level.interval.1,
    )
}

pub fn envelope_table(found: &Envelope, at_least: Option<f64>, style: Style) -> String {
    let kind = format!("{} of {}", found.kind, found.target);
    let heading = match found.unit.as_str() {
        "" | "1" => kind,
        unit => format!("{kind}, {unit}"),
    };
    // Without a receiver of missions, no run announces a failure.
    let tells = found.tells();
    let columns = [heading.as_str(), "runs that pass", "95 % interval", "", "say so", "silent"];
    let columns = &columns[..if tells { 6 } else { 4 }];
    let mut table = style.table(columns);
    for level in &found.levels {
        let (lower, upper) = level.interval;
        let cells = [
            figure(level.severity),
            format!("{} of {}", level.passed, level.runs),
            format!("{:.1} to {:.1} %", 100.0 * lower, 100.0 * upper),
            "#".repeat((20.0 * level.share()).round() as usize),
            some(level.announced),
            some(level.silent),
        ];
        table.add_row(cells.into_iter().take(columns.len()).map(Cell::new));
    }
    let percent = 100.0 * found.share;
    let severity = |value| figures::with_unit(figure(value), &found.unit);
    let verdict = match found.tolerated {
        Some(most) if found.is_all => {
            format!("tolerated at every severity, up to {}", severity(most))
        }
        Some(most) => format!("tolerated up to {}", severity(most)),
        None => "tolerated at no severity".to_owned(),
    };
    let claim = at_least.map_or(String::new(), |least| {
        let word = if found.tolerates(least) { "holds" } else { "does not hold" };
        format!("; at least {} is required: {word}", severity(least))
    });
    let silent = found.most_silent().map_or(String::new(), |level| {
        let (silent, runs) = (level.silent, level.runs);
        let at = severity(level.severity);
        format!("silently wrong: {silent} of {runs} runs at {at}, and no larger share elsewhere\n")
    });
    let tolerated =
        format!("{verdict}: at least {percent} % of runs pass, at 95 % confidence{claim}");
    format!("{}\n{tolerated}\n{silent}", lines(&table))
}

/// How runs ended, behind their number: `2 timed out`.
pub(crate) fn ended(outcome: &str) -> &str {
    if outcome == Outcome::Timeout.name() { "timed out" } else { outcome }
}

/// Formats a number of runs; empty for zero.
fn some(runs: u64) -> String {
    if runs > 0 { runs.to_string() } else { String::new() }
}

pub fn envelopes_json(all: &[Measured]) -> String {
    serde_json::to_string_pretty(all).unwrap_or_default()
}

/// Formats a measured severity with three digits.
fn figure(severity: f64) -> String {
    figures::exact(severity, 3)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{Again, campaign_table, ended, envelope_table, figure};
    use crate::console::Style;
    use campaign::{
        Campaign, Case, CaseResult, Envelope, Found, Level, Repeated, Shrunk, Tally, Violated,
    };
    use judge::properties::Unjudged;
    use plan::faults::{Fault, FaultKind, Schedule, Target};
    use std::path::PathBuf;

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in [(2.34567, "2.35"), (0.0123, "0.0123"), (1234.5, "1234"), (5.0, "5")] {
            assert_eq!(figure(value), text);
        }
    }

    /// Example: one property broke, one held, and one state was never reached.
    pub(crate) fn example() -> (Campaign, Vec<PathBuf>) {
        let fault = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
        let case = Case { seed: 7, schedule: Schedule { faults: vec![fault] } };
        let violated = Violated {
            property: "fresh_heading".to_owned(),
            at_s: 12.5,
            what: "a velocity on a heading of 0.31 s".to_owned(),
        };
        let result = CaseResult { violated: vec![violated], ..CaseResult::default() };
        let tally = Tally {
            cases: 100,
            outcomes: [("passed".to_owned(), 90), ("failed".to_owned(), 10)].into(),
            reasons: [("failed".to_owned(), (8, "steps[2]: no answer within 2 s".to_owned()))]
                .into(),
            broken: [("fresh_heading".to_owned(), (3, 41))].into(),
            reached: [("gyro_silent".to_owned(), 12)].into(),
            unconfirmed: [("recovers".to_owned(), 2)].into(),
            nearest: [
                ("fresh_heading".to_owned(), (-0.21, 41)),
                ("within_limits".to_owned(), (0.31, 5)),
                // A comparison for equality.
                ("echoed".to_owned(), (0.0, 6)),
            ]
            .into(),
            tested: [("within_limits".to_owned(), 95), ("opens".to_owned(), 0)].into(),
            unjudged: [("within_limits".to_owned(), (5, "no value of Level".to_owned()))].into(),
            ..Tally::default()
        };
        let found = Found {
            property: "fresh_heading".to_owned(),
            number: 41,
            case: case.clone(),
            shrunk: Shrunk { case, result, executions: 37, stopped: false },
            times: 3,
        };
        let done = Campaign {
            tally,
            found: vec![found],
            never: vec!["bus_off".to_owned(), "manager.State == 3".to_owned()],
            missed: vec!["manager.State == 3".to_owned()],
            stopped: false,
        };
        (done, vec!["runs/x/laps-fresh-heading-1a2b3c4d.toml".into()])
    }

    #[test]
    fn a_campaign_in_words() {
        let (done, saved) = example();
        insta::assert_snapshot!(campaign_table(&done, &saved, None, Style::PLAIN));
        let unjudged = [Unjudged {
            name: "done_is_done".to_owned(),
            kind: judge::properties::Kind::Always,
            why: "the base is real".to_owned(),
        }];
        let confirmed = vec![Some(Repeated { broke: 7, of: 8, at_least: 0.529_3 })];
        let again = Again { confirmed, unjudged: &unjudged, confidence: 0.95 };
        insta::assert_snapshot!(
            "a_campaign_on_a_bench",
            campaign_table(&done, &saved, Some(&again), Style::PLAIN)
        );
    }

    #[test]
    fn an_envelope_in_words() {
        let level = |severity, passed, interval| {
            let announced = (100 - passed) / 4;
            let silent = 100 - passed - announced;
            Level { severity, passed, announced, silent, runs: 100, interval }
        };
        let found = Envelope {
            kind: "drop".to_owned(),
            target: "gyro".to_owned(),
            unit: "%".to_owned(),
            share: 0.9,
            levels: vec![
                level(0.01, 100, (0.963, 1.0)),
                level(3.162, 99, (0.946, 0.998)),
                level(31.62, 12, (0.07, 0.198)),
            ],
            tolerated: Some(3.162),
            is_all: false,
        };
        insta::assert_snapshot!(envelope_table(&found, Some(2.0), Style::PLAIN));
        // Found by a user: `tolerated up to 3.16 1`.
        let plain = Envelope { unit: "1".to_owned(), ..found };
        let table = envelope_table(&plain, Some(2.0), Style::PLAIN);
        assert!(table.contains("tolerated up to 3.16: ") && table.contains("drop of gyro  runs"));
        assert!(table.contains("at least 2 is required"), "{table}");
    }

    #[test]
    fn outcomes_are_words_behind_their_number() {
        let words = ["passed", "timeout", "worker_lost"].map(ended);
        assert_eq!(words, ["passed", "timed out", "worker_lost"]);
    }
}
