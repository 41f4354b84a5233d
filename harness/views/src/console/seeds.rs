//! How many seeds pass, which a single run cannot show.

use super::{Style, in_cell, lines};
use campaign::seeds::{Judged, SeedShare};
use comfy_table::Cell;

const HEADER: [&str; 6] =
    ["procedure", "measurement", "seeds that pass", "95 % interval", "intervals hold", "paper"];

fn cells(one: &SeedShare) -> [String; HEADER.len()] {
    let share = match one.seeds {
        0 => "no seed ran".to_owned(),
        seeds => {
            let percent = 100.0 * one.passed as f64 / seeds as f64;
            format!("{percent:.1} % ({} of {seeds})", one.passed)
        }
    };
    let share = match one.never_asked {
        None => share,
        Some(all) if all.get() == one.seeds => format!("{share}, never tested"),
        Some(some) => format!("{share}, never tested in {some}"),
    };
    let (lower, upper) = one.interval;
    [
        in_cell(&one.plan),
        match &one.judged {
            Judged::Measurement(name) => in_cell(name),
            Judged::Property(name) => format!("{} (property)", in_cell(name)),
        },
        share,
        format!("{:.1} % to {:.1} %", 100.0 * lower, 100.0 * upper),
        one.coverage.map_or_else(
            || "-".to_owned(),
            |one| format!("{:.1} %", 100.0 * one.held as f64 / one.of as f64),
        ),
        in_cell(one.paper.as_deref().unwrap_or("-")),
    ]
}

/// Number of columns: the paper's is left out where the paper says nothing.
fn columns(shares: &[SeedShare]) -> usize {
    let has_paper = shares.iter().any(|share| share.paper.is_some());
    HEADER.len() - usize::from(!has_paper)
}

pub fn seeds_table(shares: &[SeedShare], style: Style) -> String {
    let columns = columns(shares);
    let mut table = style.table(&HEADER[..columns]);
    for share in shares {
        table.add_row(cells(share).into_iter().take(columns).map(Cell::new));
    }
    lines(&table)
}

pub fn seeds_markdown(shares: &[SeedShare]) -> String {
    let columns = columns(shares);
    let mut text = markdown_row(HEADER[..columns].iter().map(|head| (*head).to_owned()));
    text += &markdown_row(HEADER[..columns].iter().map(|_| "---".to_owned()));
    for share in shares {
        text += &markdown_row(cells(share).into_iter().take(columns));
    }
    text
}

fn markdown_row(cells: impl Iterator<Item = String>) -> String {
    let cells = cells.map(|cell| cell.replace('\\', r"\\").replace('|', r"\|"));
    format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
}

#[cfg(test)]
mod tests {
    use super::{Judged, SeedShare, seeds_markdown, seeds_table};
    use crate::console::Style;
    use campaign::seeds::Coverage;
    use std::num::NonZeroU64;

    fn shares() -> Vec<SeedShare> {
        let share = SeedShare {
            plan: "laps-observed".into(),
            judged: Judged::Measurement("return_orientation".into()),
            passed: 187,
            never_asked: None,
            seeds: 200,
            interval: (0.892_2, 0.961_6),
            coverage: Some(Coverage { held: 190, of: 200 }),
            paper: Some("±1.0 deg in 40 runs | Fig. 5".into()),
        };
        let none = SeedShare {
            passed: 0,
            seeds: 0,
            interval: (0.0, 1.0),
            coverage: None,
            paper: None,
            ..share.clone()
        };
        let property =
            SeedShare { judged: Judged::Property("it did charge".into()), ..none.clone() };
        let unasked = |never_asked| {
            let judged = Judged::Property("it stops".into());
            let never_asked = NonZeroU64::new(never_asked);
            SeedShare { judged, passed: 3, seeds: 3, never_asked, ..none.clone() }
        };
        let [some, all] = [2, 3].map(unasked);
        vec![share, none, property, some, all]
    }

    #[test]
    fn shares_come_with_their_interval() {
        insta::assert_snapshot!(seeds_table(&shares(), Style::PLAIN));
    }

    #[test]
    fn shares_as_markdown() {
        insta::assert_snapshot!(seeds_markdown(&shares()));
    }
}
