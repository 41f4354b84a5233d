//! Comparison of two runs: differing verdicts, and differences of values.

use super::{Style, in_cell, judged, keep_whole, lines, measured, seen};
use comfy_table::{Cell, Row};
use plan::RUN_ITSELF;
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

    /// Whether it is the same one in another run.
    fn is_as(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.name() == other.name()
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

    /// The band, if the value is to lie in one.
    fn band(&self) -> Option<String> {
        let Self::Measurement(one) = self else { return None };
        let is_any = one.lower.is_some() || one.upper.is_some();
        is_any.then(|| figures::band(one.lower, one.upper, &one.unit))
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
        // A run also fails or breaks without a verdict that says so.
        let outcomes = (one.outcome != other.outcome).then(|| Self {
            name: RUN_ITSELF.to_owned(),
            figures: [one, other].map(|run| run.reason.clone().unwrap_or_else(|| "-".to_owned())),
            verdicts: [one, other].map(|run| run.outcome.name()),
            moved: None,
        });
        let (one, other): (Vec<_>, Vec<_>) =
            (Judged::all(one).collect(), Judged::all(other).collect());
        let of = |all: &[Judged<'_>], of: &Judged<'_>| all.iter().position(|one| one.is_as(of));
        let firsts = one.iter().map(|first| (Some(first), of(&other, first).map(|at| &other[at])));
        let seconds = other.iter().filter(|second| of(&one, second).is_none());
        let seconds = seconds.map(|second| (None, Some(second)));
        let judged = firsts.chain(seconds).filter_map(|(first, second)| Self::of(first, second));
        outcomes.into_iter().chain(judged).collect()
    }

    fn of(first: Option<&Judged<'_>>, second: Option<&Judged<'_>>) -> Option<Self> {
        let both = [first, second];
        let bands = both.map(|judged| judged.and_then(Judged::band));
        let has_moved = first.is_some() && second.is_some() && bands[0] != bands[1];
        let figure = |at: usize| {
            let figure = both[at].map_or_else(|| "-".to_owned(), Judged::figure);
            match bands[at].as_ref().filter(|_| has_moved) {
                Some(band) => format!("{figure}, band {band}"),
                None => figure,
            }
        };
        Some(Self {
            name: first.or(second)?.name().to_owned(),
            figures: [figure(0), figure(1)],
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
    use record::outcome::samples::{properties, summary};
    use record::outcome::{Outcome, Summary, Verdict};

    #[test]
    fn what_differs_is_beside_what_it_was() {
        let mut one = summary();
        one.properties = properties();
        let mut other = one.clone();
        assert_eq!(comparison(&one, &other, Style::PLAIN).1, 0);
        other.measurements[0].value = other.measurements[0].value.map(|value| value * 1.5);
        other.measurements[0].verdict = Verdict::Fail;
        other.measurements[0].upper = other.measurements[0].upper.map(|upper| upper * 2.0);
        other.measurements[1].name = "renamed".to_owned();
        other.properties[0].held = Some(false);
        let (table, differing) = comparison(&one, &other, Style::PLAIN);
        assert_eq!(differing, 4, "{table}");
        insta::assert_snapshot!(table);
    }

    #[test]
    fn a_run_that_failed_without_a_verdict_that_says_so_differs() {
        let one = Summary { outcome: Outcome::Passed, reason: None, ..summary() };
        let reason = Some("`manager`, which is under test, exited during the run".to_owned());
        let other = Summary { outcome: Outcome::Failed, reason, ..summary() };
        let (table, differing) = comparison(&one, &other, Style::PLAIN);
        assert_eq!(differing, 1, "{table}");
        assert!(table.contains("the run itself") && table.contains("under test"), "{table}");
    }
}
