//! Identity, progress and result of the campaign.

use super::super::heading::{fact, grouped};
use super::Gathered;
use crate::console::ended;
use campaign::Account;
use maud::{Markup, html};
use record::figures;

pub(super) fn word(account: &Account, gathered: &Gathered) -> &'static str {
    match (gathered.tally.broken.is_empty(), goes_to_its_end(account)) {
        (false, _) => "broken",
        (true, true) => "held",
        (true, false) => "interrupted",
    }
}

fn goes_to_its_end(account: &Account) -> bool {
    account.end.as_ref().is_some_and(|end| !end.stopped)
}

pub(super) fn heading(account: &Account, gathered: &Gathered) -> Markup {
    let tally = &gathered.tally;
    let word = word(account, gathered);
    let class = match word {
        "broken" => "failed",
        "held" => "passed",
        _ => "open",
    };
    let share = tally.cases as f64 / account.asked.max(1) as f64;
    let outcomes: Vec<String> = tally
        .outcomes
        .iter()
        .map(|(outcome, times)| format!("{} {}", grouped(*times), ended(outcome)))
        .collect();
    html! {
        header.(class) {
            p.outcome { (word) }
            h1 { "Random faults: " (account.title) }
            p.lead {
                (grouped(tally.cases)) " of " (grouped(account.asked)) " cases, "
                (match tally.broken.len() {
                    0 => "no property broken".to_owned(),
                    1 => "1 property broken".to_owned(),
                    many => format!("{many} properties broken"),
                })
                ". Runs ended: " (if outcomes.is_empty() { "none".to_owned() } else { outcomes.join(", ") }) "."
            }
            @for (outcome, (number, reason)) in &tally.reasons {
                p.lead { (ended(outcome)) ", first in case " (number) ": " (reason) "." }
            }
            @if !goes_to_its_end(account) {
                p.lead.cut {
                    @match &account.end {
                        Some(_) => "It was stopped before the end",
                        None => "It did not finish",
                    }
                    "; this page shows the cases so far. The same command resumes it."
                }
                span.bar.wide { i style=(format!("width:{:.1}%", 100.0 * share.min(1.0))) {} }
            }
            dl {
                (fact("plan", &account.plan))
                (fact("seed", &account.seed.to_string()))
                (fact("cases chosen by", &account.search))
                (fact("faults per case", &format!("1 to {}", account.faults_max)))
                (fact("executed by", &account.carried_out_by))
                (fact("a run without faults", &figures::duration(account.horizon_s)))
                @if let Some(end) = &account.end {
                    (fact("took", &figures::duration(end.wall_s)))
                    @if end.resumed > 0 { (fact("done before", &format!("{} cases", end.resumed))) }
                }
                (fact("hil", &account.version))
            }
        }
    }
}
