//! The numbers behind a figure, as a file embedded in the page.

use super::group::Group;
use super::observed::{Direction, Sample};
use super::thin::{Point, extreme_indices, extremes};
use maud::{Markup, html};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};

/// Significant digits of a number: a plot shows four.
const DIGITS: usize = 6;

/// Significant digits of a position on an axis, which may be seconds since 1970.
const PLACE_DIGITS: usize = 12;

/// Maximum rows of a table of observations: the page with all its plots stays small enough to send.
pub(super) const ROWS_MAX: usize = 800;

/// All except unreserved characters (RFC 3986) and commas.
const ENCODED: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b',');

#[derive(Debug)]
pub(super) struct Table {
    writer: csv::Writer<Vec<u8>>,
    left_out: usize,
}

impl Table {
    pub(super) fn new<T: AsRef<str>>(header: impl IntoIterator<Item = T>) -> Self {
        let mut table = Self { writer: csv::Writer::from_writer(Vec::new()), left_out: 0 };
        table.row(header.into_iter().map(|name| name.as_ref().to_owned()));
        table
    }

    pub(super) fn of_points(x: &str, y: &str, points: &[Point]) -> Self {
        let mut table = Self::new([x, y]);
        for (x, y) in points {
            table.row([place(*x), number(*y)]);
        }
        table
    }

    /// The extremes of many points, and how many are left out.
    pub(super) fn thinned(x: &str, y: &str, points: &[Point]) -> Self {
        let kept = extremes(points, ROWS_MAX / 2);
        Self::of_points(x, y, &kept).without(points.len() - kept.len())
    }

    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        // Cannot fail: it writes into memory, and every row is as long as the header.
        let _ = self.writer.write_record(cells);
    }

    /// States how many rows are missing; the record has them.
    #[must_use]
    pub(super) const fn without(mut self, left_out: usize) -> Self {
        self.left_out = left_out;
        self
    }

    /// Returns a link that saves the table as `name`.csv, and a note on missing rows.
    pub(super) fn link(self, name: &str) -> Markup {
        let bytes = self.writer.into_inner().unwrap_or_default();
        html! {
            a.data download={ (file_name(name)) ".csv" }
                href={ "data:text/csv;charset=utf-8," (percent_encode(&bytes, ENCODED)) } { "CSV" }
            @if self.left_out > 0 {
                ", without " (self.left_out) " between these; " code { "hil show" }
                " prints all of them"
            }
        }
    }
}

/// Creates a table of observations, with the group of each if there are several.
pub(super) fn samples(groups: &[Group], unit: &str) -> Table {
    let value =
        if unit.is_empty() || unit == "1" { "value".to_owned() } else { format!("value_{unit}") };
    let header = ["group", "time_s", "run", "temperature_degC", "direction", &value, "uncertainty"];
    let mut table = Table::new(header);
    let of_group = ROWS_MAX / groups.len().max(1);
    let mut left_out = 0;
    for group in groups {
        let points: Vec<Point> = group.samples.iter().map(|one| (one.at_s, one.value)).collect();
        let kept = extreme_indices(&points, of_group / 2);
        left_out += points.len() - kept.len();
        for sample in kept.into_iter().filter_map(|index| group.samples.get(index)) {
            table.row(cells(group.label, sample));
        }
    }
    table.without(left_out)
}

fn cells(group: &str, sample: &Sample) -> [String; 7] {
    let direction = sample.direction.map_or("", Direction::name);
    [
        text(group),
        place(sample.at_s),
        sample.run.map_or_else(String::new, place),
        sample.temperature.map_or_else(String::new, number),
        direction.to_owned(),
        number(sample.value),
        number(sample.uncertainty),
    ]
}

/// Formats text as a cell that no spreadsheet interprets as a formula.
pub(super) fn text(words: &str) -> String {
    match words.starts_with(['=', '+', '-', '@']) {
        true => format!("'{words}"),
        false => words.to_owned(),
    }
}

/// Formats a number as a cell; empty if it is not finite.
pub(super) fn number(value: f64) -> String {
    rounded(value, DIGITS)
}

/// Formats a position on an axis as a cell.
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

#[cfg(test)]
mod tests {
    use super::{ROWS_MAX, Table, number, place, samples, text};
    use crate::report::group::{Group, Look};
    use crate::report::observed::Sample;

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
    fn a_long_table_keeps_what_sticks_out_and_says_what_it_lacks() {
        let mut all: Vec<Sample> =
            (0..10_000).map(|at| Sample { at_s: f64::from(at), ..Sample::default() }).collect();
        all[4_321].value = 7.5;
        let group = Group { label: "all", look: Look::Disc, samples: all };
        let link = samples(&[group], "deg").link("x").into_string();
        assert!(link.contains("all,4321,,,,7.5,0%0A"), "{link}");
        assert!(link.contains("between these; <code>hil show</code> prints all of them"), "{link}");
        assert!(link.matches("%0A").count() <= ROWS_MAX + 1);
        assert_eq!(text("=1+1"), "'=1+1");
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
