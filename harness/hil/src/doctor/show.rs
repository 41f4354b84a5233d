//! Output of findings for a terminal and for a program.

use super::{Facts, Finding, Status, outcome};
use comfy_table::{Cell, Color};
use record::text::name_of;
use serde::Serialize;
use std::fmt::Write as _;
use views::console::{Style, in_cell, keep_whole, lines, printable};

/// Columns that must not wrap: subject and status, which are short.
const WHOLE_COLUMNS: [usize; 2] = [0, 1];

/// Formats all findings as a table, then the fix for each gap, needed ones first.
pub fn text(findings: &[Finding], style: Style) -> String {
    let mut text = findings_table(findings, style);
    for (status, title) in [
        (Status::Missing, "What is missing, and how to fix it:"),
        (Status::Optional, "Not needed here, and how to get it:"),
    ] {
        let of_status = findings.iter().filter(|finding| finding.status == status);
        for (index, finding) in of_status.enumerate() {
            if index == 0 {
                let _ = writeln!(text, "\n{title}");
            }
            let Finding { subject, what, mend, needed_by, .. } = finding;
            let _ = write!(text, "\n  {}", printable(subject));
            if let Some(by) = needed_by {
                let _ = write!(text, ", for {}", printable(by));
            }
            let _ = writeln!(text, ": {}", printable(what));
            for line in mend.iter().flat_map(|mend| mend.lines()) {
                let _ = writeln!(text, "      {}", printable(line));
            }
        }
    }
    let count = |status| findings.iter().filter(|finding| finding.status == status).count();
    let closing = match (count(Status::Missing), count(Status::Optional)) {
        (0, 0) => "nothing is missing".to_owned(),
        (0, gaps) => format!("nothing that is needed is missing; {gaps} optional"),
        (1, _) => "1 thing that is needed is missing".to_owned(),
        (lacking, _) => format!("{lacking} things that are needed are missing"),
    };
    let _ = writeln!(text, "\n{closing}; exit status {}", outcome(findings).exit_status());
    text
}

/// Formats the table, one line per finding.
fn findings_table(findings: &[Finding], style: Style) -> String {
    let mut table = style.table(&["subject", "status", "found"]);
    for Finding { subject, status, what, .. } in findings {
        let colour = match status {
            Status::Good => Color::Green,
            Status::Optional => Color::Yellow,
            Status::Missing => Color::Red,
        };
        let word = Cell::new(name_of(status));
        let word = if style.colour { word.fg(colour) } else { word };
        table.add_row([Cell::new(in_cell(subject)), word, Cell::new(in_cell(what))]);
    }
    keep_whole(&mut table, &WHOLE_COLUMNS, style);
    lines(&table)
}

/// Formats everything for a program: `outcome`, `findings` and the `facts` behind them.
///
/// # Errors
///
/// When it cannot be written as JSON, which is not expected.
pub fn json(facts: &Facts, findings: &[Finding]) -> serde_json::Result<String> {
    #[derive(Serialize)]
    struct Report<'a> {
        outcome: &'static str,
        findings: &'a [Finding],
        facts: &'a Facts,
    }
    let report = Report { outcome: outcome(findings).name(), findings, facts };
    Ok(serde_json::to_string_pretty(&report)? + "\n")
}
