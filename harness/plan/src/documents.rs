//! Tables of the vocabulary in documents.

use std::fmt::Write as _;

/// Checks that each of the tables in `docs/NAME` has these rows below its header. If one differs, the new text is written to
/// `docs/NAME.new`.
pub fn assert_tables(name: &str, tables: &[(&[&str], Vec<Vec<String>>)]) {
    let path = format!("{}/../../docs/{name}", env!("CARGO_MANIFEST_DIR"));
    let written = std::fs::read_to_string(&path).unwrap();
    let mut text = written.clone();
    for (columns, rows) in tables {
        let header = format!("| {} |\n|{}\n", columns.join(" | "), "---|".repeat(columns.len()));
        let (before, table) = text.split_once(&header).expect("a table");
        let after =
            table.split_once("\n\n").map_or(String::new(), |(_, after)| format!("\n{after}"));
        let mut renewed = format!("{before}{header}");
        for row in rows {
            let _ = writeln!(renewed, "| {} |", row.join(" | "));
        }
        text = renewed + &after;
    }
    if written != text {
        std::fs::write(format!("{path}.new"), text).unwrap();
        panic!("docs/{name} is not the vocabulary: mv docs/{name}.new docs/{name}");
    }
}
