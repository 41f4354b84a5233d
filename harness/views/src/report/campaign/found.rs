//! The smallest case of each property that broke: violation, schedule, and how to reproduce it.

use campaign::{Account, FoundCase};
use maud::{Markup, html};
use record::figures;

/// Renders one card per case; `None` if no case was shrunk.
pub(super) fn cards(account: &Account) -> Option<Markup> {
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
