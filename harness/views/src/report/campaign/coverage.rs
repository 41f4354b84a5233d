//! Which kinds of faults were tried in which phases of the plan, and how often a property broke then.

use super::super::download::{Table, text};
use super::Gathered;
use super::gather::{Column, Tried};
use campaign::{Account, Struck};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Shades of a cell, by the share of cases in which a property broke.
const SHADES: u64 = 5;

/// Renders the table, with the combinations that were never tried.
pub(super) fn table(account: &Account, gathered: &Gathered) -> Markup {
    let seen = gathered.tried.keys();
    let kinds: BTreeSet<&Struck> =
        account.kinds.iter().chain(seen.clone().map(|key| &key.0)).collect();
    let phases = account.phases.iter().map(|phase| Column::Phase(phase.clone()));
    let columns: BTreeSet<Column> =
        phases.chain([Column::At]).chain(seen.map(|key| key.1.clone())).collect();
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
                    "Cases that tried it; in brackets those in which a property broke, the redder the greater their share. "
                    "A case holds several faults: which of them did it, only the smallest case says."
                }
                p {
                    (kinds.len()) " kinds of faults, "
                    @if untried == 0 { "each of them tried" } @else { (untried) " of them never tried" }
                    ". " (data.link("faults-by-phase"))
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

fn cell(tried: Tried) -> Markup {
    let shade = match tried {
        Tried { cases: 0, .. } => "untried".to_owned(),
        Tried { broke: 0, .. } => "held".to_owned(),
        Tried { cases, broke } => {
            format!("shade{}", (SHADES * broke).div_ceil(cases).clamp(1, SHADES))
        }
    };
    html! {
        td.number.(shade) {
            @if tried.cases == 0 { "·" } @else { (tried.cases) }
            @if tried.broke > 0 { " (" (tried.broke) ")" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SHADES, Tried, cell};

    #[test]
    fn every_shade_is_in_the_sheet_and_says_its_numbers() {
        let sheet = include_str!("../style.css");
        for shade in 1..=SHADES {
            assert!(sheet.contains(&format!(".shade{shade}")), "{shade}");
        }
        let text = |cases, broke| cell(Tried { cases, broke }).into_string();
        assert_eq!(text(0, 0), "<td class=\"number untried\">·</td>");
        assert_eq!(text(9, 0), "<td class=\"number held\">9</td>");
        assert_eq!(text(100, 1), "<td class=\"number shade1\">100 (1)</td>");
        assert_eq!(text(3, 3), "<td class=\"number shade5\">3 (3)</td>");
    }
}
