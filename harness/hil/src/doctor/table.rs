//! The table of findings.

use super::{Finding, Status};
use comfy_table::{Cell, Color};
use record::text::name_of;
use views::console::{Style, in_cell, keep_whole, lines};

/// Columns that must not wrap: subject and status, which are short.
const WHOLE_COLUMNS: [usize; 2] = [0, 1];

/// Formats the table, one line per finding.
pub fn findings_table(findings: &[Finding], style: Style) -> String {
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
