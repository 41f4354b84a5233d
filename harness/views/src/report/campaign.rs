//! `report.html` of a campaign: broken properties, margins of the others, and the faults tried.
//!
//! Drawn from the [`Account`] of the campaign and the cases of its journal, as far as they exist.

mod coverage;
mod gather;
mod margins;
mod properties;
#[cfg(test)]
mod tests;

pub use gather::Gathered;

use super::heading::{fact, grouped};
use super::page::{document, section};
use crate::console::ended;
use campaign::{Account, FoundCase};
use maud::{Markup, html};
use record::figures;

/// Renders the page. The same arguments give the same bytes.
pub fn page(account: &Account, gathered: &Gathered) -> String {
    let body = html! {
        (heading(account, gathered))
        (section("What broke", cards(account)))
        (section("Properties that must hold", properties::always(account, gathered)))
        (section("States that should come about", properties::sometimes(account, gathered)))
        (section("What was tried", Some(coverage::table(account, gathered))))
        (section("Margins", margins::plots(gathered)))
    };
    let title = format!("{}: campaign, {}", account.plan, word(account, gathered));
    document(&title, &body).into_string()
}

fn word(account: &Account, gathered: &Gathered) -> &'static str {
    match (gathered.tally.broken.is_empty(), goes_to_its_end(account)) {
        (false, _) => "broken",
        (true, true) => "held",
        (true, false) => "interrupted",
    }
}

fn goes_to_its_end(account: &Account) -> bool {
    account.end.as_ref().is_some_and(|end| !end.stopped)
}

/// Identity, progress and result.
fn heading(account: &Account, gathered: &Gathered) -> Markup {
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

/// The smallest case of each property that broke: violation, schedule, and how to reproduce it; `None` if no case was
/// shrunk.
fn cards(account: &Account) -> Option<Markup> {
    let found = &account.end.as_ref()?.found;
    (!found.is_empty()).then(|| html! { div.cards { @for one in found { (card(account, one)) } } })
}

fn card(account: &Account, found: &FoundCase) -> Markup {
    let schedule = &found.case.schedule;
    let count = schedule.faults.len();
    let faults = figures::counted(count as u64, "fault", "faults");
    html! {
        div.effect.broken {
            h3 { (found.property) }
            p { (found.what) }
            p.small {
                "At " (format!("{:.3}", found.at_s)) " s. First broken by case " (found.number) ", by "
                (found.times) " case" @if found.times != 1 { "s" } " in all; "
                @match found.executions {
                    0 => { (faults) ", not shrunk." }
                    runs => { "shrunk to " (faults) " in " (figures::counted(runs, "run", "runs")) "." }
                }
                @if let Some(repeated) = found.repeated {
                    " Broke in " (repeated.broke) " of " (repeated.of) " repetitions."
                }
            }
            @if count > 0 { pre { (schedule.to_toml().trim()) } }
            p {
                "Again: "
                code {
                    "hil run " (found.plan) " " span.whole { "--seed " (found.case.seed) }
                    @if !account.replay.is_empty() { " " (account.replay) }
                }
            }
            p.small {
                "Plan: "
                @match found.file.as_deref().filter(|name| is_plain(name)) {
                    Some(name) => a href=(name) { (name) },
                    None => code { (found.plan) },
                }
            }
        }
    }
}

/// Whether it is the plain name of a file beside the page: a link must not lead outside.
fn is_plain(name: &str) -> bool {
    !name.starts_with('.') && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c))
}
