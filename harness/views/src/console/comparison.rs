//! Comparison of two runs: differing verdicts, and differences of values.

use super::{Style, in_cell, judged, keep_whole, lines, measured, seen};
use comfy_table::{Cell, Row};
use record::figures;
use record::outcome::{Measurement, PropertySummary, Summary, Verdict};

/// Columns that should not wrap.
const WHOLE_COLUMNS: [usize; 3] = [0, 3, 4];

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

/// A measurement or a property of two runs, as text; `-` if a run lacks it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Compared {
    pub(crate) name: String,
    pub(crate) figures: [String; 2],
    pub(crate) verdicts: [&'static str; 2],
    /// How far the figure moved from the first to the second.
    pub(crate) moved: Option<String>,
}

impl Compared {
    /// All that two runs judge, in the order of the first.
    pub(crate) fn all(one: &Summary, other: &Summary) -> Vec<Self> {
        let (one, other): (Vec<_>, Vec<_>) =
            (Judged::all(one).collect(), Judged::all(other).collect());
        let of =
            |judged: &[Judged<'_>], name: &str| judged.iter().position(|one| one.name() == name);
        let firsts =
            one.iter().map(|first| (Some(first), of(&other, first.name()).map(|at| &other[at])));
        let seconds = other.iter().filter(|second| of(&one, second.name()).is_none());
        let seconds = seconds.map(|second| (None, Some(second)));
        firsts.chain(seconds).filter_map(|(first, second)| Self::of(first, second)).collect()
    }

    fn of(first: Option<&Judged<'_>>, second: Option<&Judged<'_>>) -> Option<Self> {
        let both = [first, second];
        let figure =
            |judged: Option<&Judged<'_>>| judged.map_or_else(|| "-".to_owned(), Judged::figure);
        Some(Self {
            name: first.or(second)?.name().to_owned(),
            figures: both.map(figure),
            verdicts: both.map(|judged| judged.map_or("-", Judged::verdict)),
            moved: first.zip(second).and_then(|(first, second)| first.moved(second)),
        })
    }

    pub(crate) fn differs(&self) -> bool {
        self.verdicts[0] != self.verdicts[1]
    }

    /// The second verdict, where it is another.
    pub(crate) fn then(&self) -> &'static str {
        if self.differs() { self.verdicts[1] } else { "same" }
    }
}

/// Compares two runs; also returns how many verdicts differ, including those that one run lacks.
pub fn comparison(one: &Summary, other: &Summary, style: Style) -> (String, usize) {
    let mut table =
        style.table(&["what", "first", "second", "verdict", "second verdict", "change"]);
    let all = Compared::all(one, other);
    for compared in &all {
        let Compared { name, figures: [first, second], verdicts: [verdict, _], moved } = compared;
        table.add_row(Row::from([
            Cell::new(in_cell(name)),
            Cell::new(in_cell(first)),
            Cell::new(in_cell(second)),
            Cell::new(verdict),
            Cell::new(compared.then()),
            Cell::new(in_cell(moved.as_deref().unwrap_or_default())),
        ]));
    }
    keep_whole(&mut table, &WHOLE_COLUMNS, style);
    (lines(&table), all.iter().filter(|compared| compared.differs()).count())
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
