//! Comparison of two runs: differing verdicts, and differences of values.

use super::{Style, in_cell, judged, keep_whole, lines, measured, seen};
use comfy_table::{Cell, Row};
use record::figures;
use record::outcome::{Measurement, PropertySummary, Summary, Verdict};

/// Columns that should not wrap.
const WHOLE_COLUMNS: [usize; 3] = [0, 3, 4];

/// A measurement or a property of one of the runs.
enum Judged<'a> {
    Measurement(&'a Measurement),
    Property(&'a PropertySummary),
}

impl Judged<'_> {
    fn all(of: &Summary) -> impl Iterator<Item = Judged<'_>> {
        let measurements = of.measurements.iter().map(Judged::Measurement);
        measurements.chain(of.properties.iter().map(Judged::Property))
    }

    fn name(&self) -> &str {
        match self {
            Self::Measurement(one) => &one.name,
            Self::Property(one) => &one.name,
        }
    }

    fn figure(&self) -> String {
        match self {
            Self::Measurement(one) => measured(one),
            Self::Property(one) => seen(one),
        }
    }

    fn verdict(&self) -> &'static str {
        match self {
            Self::Measurement(one) => one.verdict.name(),
            Self::Property(one) => judged(one).map_or_else(|word| word, Verdict::name),
        }
    }

    /// Difference of the value to that of `other`, if both have one in the same unit.
    fn moved(&self, other: &Self) -> Option<String> {
        let (Self::Measurement(one), Self::Measurement(other)) = (self, other) else { return None };
        let by = other.value? - one.value?;
        (one.unit == other.unit && by != 0.0).then(|| {
            let sign = if by > 0.0 { "+" } else { "" };
            format!(
                "{sign}{}",
                figures::quantity(by, one.uncertainty.hypot(other.uncertainty), &one.unit)
            )
        })
    }
}

/// Compares two runs; also returns how many verdicts differ, including those that one run lacks.
pub fn comparison(one: &Summary, other: &Summary, style: Style) -> (String, usize) {
    let mut table = style.table(&["what", "first", "second", "verdict", "then", "moved by"]);
    let mut differing = 0;
    let mut row = |name: &str, judged: [Option<&Judged<'_>>; 2]| {
        let [first, second] = judged;
        let verdict = |judged: Option<&Judged<'_>>| judged.map_or("-", Judged::verdict);
        let figure = |judged: Option<&Judged<'_>>| {
            Cell::new(in_cell(&judged.map_or_else(|| "-".to_owned(), Judged::figure)))
        };
        let moved = first.zip(second).and_then(|(first, second)| first.moved(second));
        let differs = verdict(first) != verdict(second);
        differing += usize::from(differs);
        table.add_row(Row::from([
            Cell::new(in_cell(name)),
            figure(first),
            figure(second),
            Cell::new(verdict(first)),
            Cell::new(if differs { verdict(second) } else { "same" }),
            Cell::new(in_cell(&moved.unwrap_or_default())),
        ]));
    };
    let of_other: Vec<Judged<'_>> = Judged::all(other).collect();
    for first in Judged::all(one) {
        let second = of_other.iter().find(|second| second.name() == first.name());
        row(first.name(), [Some(&first), second]);
    }
    for second in &of_other {
        if !Judged::all(one).any(|first| first.name() == second.name()) {
            row(second.name(), [None, Some(second)]);
        }
    }
    keep_whole(&mut table, &WHOLE_COLUMNS, style);
    (lines(&table), differing)
}

#[cfg(test)]
mod tests {
    use super::{Style, comparison};
    use record::outcome::Verdict;
    use record::outcome::samples::{properties, summary};

    #[test]
    fn what_differs_is_beside_what_it_was() {
        let mut one = summary();
        one.properties = properties();
        let mut other = one.clone();
        assert_eq!(comparison(&one, &other, Style::PLAIN).1, 0);
        other.measurements[0].value = other.measurements[0].value.map(|value| value * 1.5);
        other.measurements[0].verdict = Verdict::Fail;
        other.measurements[1].name = "renamed".to_owned();
        other.properties[0].held = Some(false);
        let (table, differing) = comparison(&one, &other, Style::PLAIN);
        assert_eq!(differing, 4, "{table}");
        insta::assert_snapshot!(table);
    }
}
