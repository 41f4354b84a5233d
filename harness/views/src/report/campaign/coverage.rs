//! Which kinds of faults acted in cases, by the phase of the plan that they were tied to, and how often a property broke then.

use super::super::download::{Table, text};
use super::super::heading::grouped;
use super::Gathered;
use super::gather::{Column, Drawn, Tried};
use campaign::{Account, Struck};
use maud::{Markup, html};
use record::figures;
use std::collections::BTreeSet;

/// Shades of a cell, by the share of cases in which a property breaks at least.
const SHADES: u64 = 5;

/// Renders the table, with the combinations that were never tried.
pub(super) fn table(account: &Account, gathered: &Gathered) -> Markup {
    let seen = gathered.tried.keys();
    let kinds: BTreeSet<&Struck> =
        account.kinds.iter().chain(seen.clone().map(|key| &key.0)).collect();
    // In the order of the plan.
    let is_by_label =
        |phase: &&String| account.labels.get(*phase).is_some_and(|labels| !labels.contains(phase));
    let phases = account.phases.iter().filter(|phase| !is_by_label(phase));
    let phases = phases.map(|phase| Column::Phase(phase.clone()));
    let mut columns: Vec<Column> = Vec::new();
    for column in [Column::At].into_iter().chain(phases).chain(seen.map(|key| key.1.clone())) {
        if !columns.contains(&column) {
            columns.push(column);
        }
    }
    let untried = kinds.iter().filter(|kind| whole(gathered, kind).cases == 0).count();
    let mut data = Table::new(["fault", "target", "phase", "cases", "broke"]);
    for ((struck, column), tried) in &gathered.tried {
        data.row([
            text(&struck.kind),
            text(&struck.target),
            text(column.name()),
            tried.cases.to_string(),
            tried.broke.to_string(),
        ]);
    }
    html! {
        figure {
            div.scroll.plain {
                table.heat {
                    thead {
                        tr {
                            th { "fault" } th.number { "all" }
                            @for column in &columns { th.number { (column.name()) } }
                        }
                    }
                    tbody {
                        @for kind in &kinds {
                            tr {
                                td { (kind.kind) span.small { " of " (kind.target) } }
                                (cell(whole(gathered, kind)))
                                @for column in &columns {
                                    @let key = ((*kind).clone(), column.clone());
                                    (cell(gathered.tried.get(&key).copied().unwrap_or_default()))
                                }
                            }
                        }
                    }
                }
            }
            figcaption {
                p {
                    "The share of cases in which this fault acted and a property broke: below it, how many of how many, and the 95 % "
                    "interval (Wilson). The colour shows the lower end of the interval: few cases stay pale. A case holds several faults: "
                    "only the smallest case shows which of them broke it."
                }
                p {
                    (counted(kinds.len(), untried)) ". " (idle(gathered.drawn)) (data.link("faults-by-phase"))
                }
            }
        }
    }
}

/// Totals of one kind over all phases. A case that contains it twice counts twice.
fn whole(gathered: &Gathered, kind: &Struck) -> Tried {
    let of_kind = gathered.tried.iter().filter(|((struck, _), _)| struck == kind);
    of_kind.fold(Tried::default(), |sum, (_, tried)| Tried {
        cases: sum.cases + tried.cases,
        broke: sum.broke + tried.broke,
    })
}

/// How many kinds of faults there are, and how many of them acted in no case.
fn counted(kinds: usize, untried: usize) -> String {
    match (kinds, untried) {
        (1, 0) => "1 kind of fault".to_owned(),
        (1, _) => "1 kind of fault, which never acted".to_owned(),
        (_, 0) => format!("{kinds} kinds of faults, each of which acted in some case"),
        _ => format!("{kinds} kinds of faults, {untried} of which never acted"),
    }
}

/// How many faults were drawn for nothing.
fn idle(drawn: Drawn) -> String {
    let Drawn { faults, idle } = drawn;
    match (faults, idle) {
        (_, 0) => String::new(),
        _ => format!(
            "Of {} drawn, {} did nothing and {} not counted: never begun, or without effect. ",
            figures::counted(faults, "fault", "faults"),
            grouped(idle),
            if idle == 1 { "is" } else { "are" },
        ),
    }
}

fn cell(tried: Tried) -> Markup {
    let shade = match tried {
        Tried { cases: 0, .. } => "untried".to_owned(),
        Tried { broke: 0, .. } => "held".to_owned(),
        Tried { .. } => {
            let lower = tried.interval().map_or(0.0, |interval| interval.lower);
            format!("shade{}", ((SHADES as f64 * lower).ceil() as u64).clamp(1, SHADES))
        }
    };
    html! {
        td.number.(shade) {
            @match tried.interval() {
                None => "·",
                Some(interval) => {
                    (format!("{:.0} %", 100.0 * tried.broke as f64 / tried.cases as f64))
                    div.small {
                        (tried.broke) " of " (tried.cases) "; "
                        (interval.percent())
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SHADES, Tried, cell, counted};

    #[test]
    fn one_kind_is_one() {
        assert_eq!(counted(1, 0), "1 kind of fault");
        assert_eq!(counted(1, 1), "1 kind of fault, which never acted");
        assert_eq!(counted(3, 1), "3 kinds of faults, 1 of which never acted");
    }

    #[test]
    fn every_shade_is_in_the_sheet_and_says_its_numbers() {
        let sheet = include_str!("../style.css");
        for shade in 1..=SHADES {
            assert!(sheet.contains(&format!(".shade{shade}")), "{shade}");
        }
        let text = |cases, broke| cell(Tried { cases, broke }).into_string();
        assert_eq!(text(0, 0), "<td class=\"number untried\">·</td>");
        let told = |class: &str, rate: &str, small: &str| {
            format!("<td class=\"number {class}\">{rate}<div class=\"small\">{small}</div></td>")
        };
        assert_eq!(text(9, 0), told("held", "0 %", "0 of 9; 0 to 30 %"));
        assert_eq!(text(100, 1), told("shade1", "1 %", "1 of 100; 0 to 5 %"));
        // One case of one is no proof of a rate.
        assert_eq!(text(1, 1), told("shade2", "100 %", "1 of 1; 21 to 100 %"));
        assert_eq!(text(300, 300), told("shade5", "100 %", "300 of 300; 99 to 100 %"));
    }
}
