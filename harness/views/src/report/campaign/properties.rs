//! How often each property broke, its smallest margin, and how often each state was reached.

use super::super::heading::grouped;
use super::super::listed;
use super::Gathered;
use campaign::Account;
use maud::{Markup, html};
use plan::confidence::{Z_95, wilson};
use record::figures;
use std::collections::BTreeSet;

/// Properties that must hold at every moment; `None` if none was judged.
pub(super) fn always(account: &Account, gathered: &Gathered) -> Option<Markup> {
    let tally = &gathered.tally;
    let not_judged = account.end.as_ref().map(|end| &end.not_judged);
    let names: BTreeSet<&String> = tally.nearest.keys().chain(tally.broken.keys()).collect();
    if names.is_empty() && not_judged.is_none_or(|none| none.is_empty()) {
        return None;
    }
    let rows = html! {
        @for name in names { (row(name, gathered)) }
        @for (name, why) in not_judged.into_iter().flatten() {
            tr.unset {
                td { strong { (name) } div.small { "not judged: " (why) } }
                td { span.verdict { "not judged" } }
                td.number { "-" } td {} td.number { "-" } td.number { "-" }
            }
        }
    };
    let heads = ["property", "verdict", "#broken by", "", "#least margin", "#in case"];
    Some(html! {
        (listed::table(Some("held"), &heads, &rows))
        p.small { "The interval is that of the share of cases that break the property (95 %, Wilson). A margin is the smallest distance to a violation, as a share of the limit; below zero, the property broke." }
    })
}

fn row(name: &str, gathered: &Gathered) -> Markup {
    let tally = &gathered.tally;
    let (times, first) = tally.broken.get(name).copied().unwrap_or_default();
    let nearest = tally.nearest.get(name).filter(|(margin, _)| margin.is_finite());
    let margin = nearest.and_then(|(margin, _)| figures::least_margin(*margin));
    let unconfirmed = tally.unconfirmed.get(name);
    let judged = tally.judged(name);
    html! {
        tr.(if times > 0 { "fail" } else { "pass" }) {
            td {
                strong { (name) }
                @if let Some(times) = unconfirmed {
                    div.small { "broke once in " (times) " more cases, but not often enough in the repetitions" }
                }
                @if let Some((times, why)) = tally.unjudged.get(name) {
                    div.small { "nothing to judge in " (figures::counted(*times, "more case", "more cases")) ": " (why) }
                }
            }
            td { span.verdict { (if times > 0 { "broken" } else { "held" }) } }
            td.number {
                (grouped(times)) " of " (grouped(judged))
                @if let Some(interval) = wilson(times, judged, Z_95) {
                    div.small { (interval.percent()) }
                }
            }
            td { (bar(times, judged, "fault")) }
            td.number { (margin.unwrap_or_else(|| "-".to_owned())) }
            td.number { (nearest.map_or(first, |(_, number)| *number)) }
        }
    }
}

/// States that should be reached in some case; `None` if the plan names none.
pub(super) fn sometimes(account: &Account, gathered: &Gathered) -> Option<Markup> {
    let tally = &gathered.tally;
    let names: BTreeSet<&String> = account.states.iter().chain(tally.reached.keys()).collect();
    let rows = html! {
        @for &name in &names {
            @let times = tally.reached.get(name).copied().unwrap_or_default();
            tr.(if times == 0 { "marginal" } else { "pass" }) {
                td { strong { (name) } }
                td.number {
                    @if times == 0 { span.reason { "no case" } } @else { (grouped(times)) " of " (grouped(tally.cases)) }
                }
                td { (bar(times, tally.cases, "state")) }
            }
        }
    };
    (!names.is_empty()).then(|| listed::table(None, &["state", "#reached by", ""], &rows))
}

fn bar(times: u64, of: u64, class: &str) -> Markup {
    let share = 100.0 * times as f64 / of.max(1) as f64;
    html! { span.bar.(class) { i style=(format!("width:{share:.1}%")) {} } }
}
