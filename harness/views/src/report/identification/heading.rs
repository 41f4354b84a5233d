//! The result, at the top of the page.

use super::super::heading::fact;
use identification::finding::{Finding, HeldOut, Verdict};
use maud::{Markup, html};
use record::figures;

pub(super) fn heading(finding: &Finding) -> Markup {
    let class = if finding.verdict == Verdict::StructureLeft { "open" } else { "passed" };
    html! {
        header.(class) {
            p.outcome { (finding.verdict_in_words()) }
            h1 { (finding.dataset) }
            @for sentence in finding.in_words() { p.lead { (sentence) } }
            @if let Some(verdict) = verdict(finding) { p.lead { (verdict) } }
            @for held_out in std::iter::once(&finding.held_out).chain(&finding.held_out_also) {
                (errors(held_out))
            }
            @for notice in &finding.notices { p.lead.cut { "Note: " (notice) } }
            dl {
                (fact("kind", finding.kind.name()))
                (fact("rows", &finding.rows.to_string()))
                (fact("runs", &finding.runs.to_string()))
                (fact("seed", &finding.seed.to_string()))
                (fact(
                    "noise floor",
                    &figures::quantity(finding.noise_floor.value, 0.0, &finding.noise_floor.unit),
                ))
            }
        }
    }
}

/// The verdict in a sentence, where the finding's own words do not say it.
fn verdict(finding: &Finding) -> Option<String> {
    let count = finding.effects.len();
    let effects = match count {
        1 => "one effect".to_owned(),
        _ => format!("{count} effects"),
    };
    let said = match finding.verdict {
        Verdict::NothingMissing => return None,
        Verdict::Explained => format!(
            "The model given lacked {effects}. What was found lowers the error on data that took no part in \
             the fit, and no further cause shows in what remains."
        ),
        Verdict::StructureLeft if count == 0 => {
            "Something remains that is not noise, and no effect that was tried describes it."
                .to_owned()
        }
        Verdict::StructureLeft => format!(
            "The model given lacked {effects}, but what remains is still not noise alone: the model is \
             better, not complete."
        ),
    };
    Some(said)
}

/// Renders the errors before and after, with their uncertainty.
fn errors(held_out: &HeldOut) -> Markup {
    let HeldOut { quantity, unit, before, after, ci95: [low, high], folds, .. } = held_out;
    let change = 100.0 * (after - before) / before;
    // A quarter of a 95 % interval is about a standard error, which determines the significant digits.
    let figure = |value: f64| figures::value(value, (high - low) / 4.0);
    html! {
        p.change {
            @if let Some(quantity) = quantity { code { (quantity) } " " }
            "error " span.before { (figure(*before)) } " → " strong.after { (figure(*after)) } " "
            (if unit == "1" { "" } else { unit.as_str() })
            @if change.is_finite() { " (" (format!("{change:+.0}")) " %)" }
            span.small {
                " root mean square on data left out of the fit, in " (folds) " parts; "
                @if low < high {
                    "95 % interval from resampled runs " (figure(*low)) " to " (figure(*high))
                } @else {
                    "one run alone gives no interval"
                }
            }
        }
    }
}
