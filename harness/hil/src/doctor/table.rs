//! What a machine has and lacks.

use super::{Finding, Status};
use comfy_table::{Cell, Color};
use views::console::{Style, in_cell, keep_whole, lines};

/// Subject and status: short, and ugly when broken.
const WHOLE_COLUMNS: [usize; 2] = [0, 1];

/// One line a finding.
pub fn findings_table(findings: &[Finding], style: Style) -> String {
    let mut table = style.table(&["subject", "status", "found"]);
    for Finding { subject, status, what, .. } in findings {
        let colour = match status {
            Status::Good => Color::Green,
            Status::Gap => Color::Yellow,
            Status::Lacking => Color::Red,
        };
        let word = Cell::new(status.name());
        let word = if style.colour { word.fg(colour) } else { word };
        table.add_row([Cell::new(in_cell(subject)), word, Cell::new(in_cell(what))]);
    }
    keep_whole(&mut table, &WHOLE_COLUMNS, style);
    lines(&table)
}
