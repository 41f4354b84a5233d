//! What the model does not explain, and the most informative next experiment.

use super::meaning::{cause, title};
use super::whiteness::Whiteness;
use identification::finding::{Finding, Verdict};
use identification::outcome::{BlockDiagnostics, Diagnostics};
use maud::{Markup, html};

/// Renders what remains, and why no effect was added for it.
pub(super) fn left(finding: &Finding, diagnostics: &Diagnostics) -> Markup {
    html! {
        (causes(finding))
        @for block in &diagnostics.blocks { (memory(block)) }
    }
}

/// States whether the residual of an observed quantity is correlated in time.
fn memory(block: &BlockDiagnostics) -> Markup {
    let white = Whiteness::of(block);
    html! {
        @if !white.is_white() {
            p {
                "What remains of " code { (block.label) } " is not new in every observation: "
                (white.outside) " of " (white.lags) " autocorrelations are larger than noise makes them, "
                "where about " (format!("{:.0}", white.expected)) " would be by chance. Standard errors "
                "of its numbers may be too small."
            }
        }
    }
}

fn causes(finding: &Finding) -> Markup {
    let (memories, tried): (Vec<_>, Vec<_>) =
        finding.left.iter().partition(|left| left.is_memory());
    html! {
        @if finding.left.is_empty() {
            @if finding.verdict == Verdict::StructureLeft {
                p {
                    "What remains is not noise alone, but no cause was found among the channels of these "
                    "data. The figures below show it."
                }
            } @else {
                p { "No cause that was tried shows in what remains." }
            }
        } @else if !tried.is_empty() {
            p {
                "There are signs of the following, too strong for noise. But a term added for any of them "
                "made the error on data left out of the fit no smaller, so that none was added: the signs "
                "may be of something that these data do not show, or that does not repeat."
            }
            ul {
                @for left in tried {
                    li {
                        strong { (title(&left.shape)) }
                        @if !left.drivers.is_empty() {
                            " over " (left.drivers.iter().map(|d| cause(d)).collect::<Vec<_>>().join(" and "))
                        }
                        ": " (format!("{:.1}", 100.0 * left.share_of_residual_variance))
                        " % of the variance of what remains"
                    }
                }
            }
        }
        @for left in memories {
            p {
                "What remains is " (left.shape) ": about "
                (format!("{:.1}", 100.0 * left.share_of_residual_variance))
                " % of its variance is remembered for so long, which is more than the noise model knows of. "
                "Something acts that no channel of these data shows, or the noise is of another kind."
            }
        }
    }
}

/// Renders the plan that would decide between causes, if there is a doubt.
pub(super) fn next(finding: &Finding) -> Option<Markup> {
    if let Some(next) = &finding.next_experiment {
        let between: Vec<String> = next.separates.iter().map(|name| title(name)).collect();
        return Some(html! {
            p {
                "Run the plan " code { (next.plan) } ". It tells apart: "
                strong { (between.join(", ")) } "."
            }
            p { "What it would bring: " (next.expected_gain) "." }
        });
    }
    let is_open = finding.effects.iter().any(|effect| !effect.rivals.is_empty());
    is_open.then(|| {
        html! {
            p {
                "An effect could also be another (see its card). More data in which these causes do not "
                "go together would decide; no plan for that was found."
            }
        }
    })
}
