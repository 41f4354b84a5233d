//! The numbers behind a figure, as a file that the page itself holds.

use super::thin::Point;
use maud::{Markup, html};
use std::fmt::Write;

/// Digits of a number that count: a plot shows four.
const DIGITS: usize = 6;

/// Digits of a place on an axis, which may be seconds since 1970.
const PLACE_DIGITS: usize = 12;

/// A table: what its columns are, and its rows.
#[derive(Debug)]
pub(super) struct Table {
    writer: csv::Writer<Vec<u8>>,
}

impl Table {
    pub(super) fn new<T: AsRef<str>>(header: impl IntoIterator<Item = T>) -> Self {
        let mut table = Self { writer: csv::Writer::from_writer(Vec::new()) };
        table.row(header.into_iter().map(|name| name.as_ref().to_owned()));
        table
    }

    /// Points of a line.
    pub(super) fn of_points(x: &str, y: &str, points: &[Point]) -> Self {
        let mut table = Self::new([x, y]);
        for (x, y) in points {
            table.row([place(*x), number(*y)]);
        }
        table
    }

    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        // Into memory, and every row is as long as the header: nothing can fail.
        let _ = self.writer.write_record(cells);
    }

    /// A link that saves the table as `name`.csv.
    pub(super) fn link(self, name: &str) -> Markup {
        let bytes = self.writer.into_inner().unwrap_or_default();
        html! {
            a.data download={ (file_name(name)) ".csv" }
                href={ "data:text/csv;charset=utf-8," (percent_encoded(&bytes)) } { "CSV" }
        }
    }
}

/// A number as a cell; empty where there is none.
pub(super) fn number(value: f64) -> String {
    rounded(value, DIGITS)
}

/// A place on an axis as a cell.
pub(super) fn place(value: f64) -> String {
    rounded(value, PLACE_DIGITS)
}

fn rounded(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let written = format!("{value:.*e}", digits - 1);
    let value = written.parse().unwrap_or(value);
    if value == 0.0 || (1e-4..1e12).contains(&f64::abs(value)) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "._-".contains(c) { c } else { '-' }).collect()
}

/// As RFC 3986 wants it: what is neither unreserved nor a comma becomes its number.
fn percent_encoded(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 5 / 4);
    for &byte in bytes {
        if byte.is_ascii_alphanumeric() || b"-._~,".contains(&byte) {
            text.push(char::from(byte));
        } else {
            // Writing to a string cannot fail.
            let _ = write!(text, "%{byte:02X}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Table, number, place};

    #[test]
    fn a_table_is_a_link_that_breaks_out_of_nothing() {
        let mut table = Table::new(["a \"b\"", "<c>"]);
        table.row([number(1.5), "x,\n&y".to_owned()]);
        let link = table.link("../a b").into_string();
        assert_eq!(
            link,
            "<a class=\"data\" download=\"..-a-b.csv\" href=\"data:text/csv;charset=utf-8,\
             %22a%20%22%22b%22%22%22,%3Cc%3E%0A1.5,%22x,%0A%26y%22%0A\">CSV</a>"
        );
    }

    #[test]
    fn numbers_are_short_and_are_read_back() {
        for (value, written) in
            [(0.0, "0"), (0.1 + 0.2, "0.3"), (-1.234_567_891_2e-7, "-1.23457e-7"), (f64::NAN, "")]
        {
            assert_eq!(number(value), written);
        }
        assert_eq!(place(1_700_000_000.5), "1700000000.5");
    }
}
