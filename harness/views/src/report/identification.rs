//! `report.html` of an identification: findings, what remains, and all figures that support them.
//!
//! It addresses readers who know the robot but not the statistics: each figure has a sentence that says what to look
//! for. The page contains the drawn data of each figure. It judges nothing: the verdict is that of the finding.

mod by_run;
mod cloud;
mod compensation;
mod curves;
mod draw;
mod effects;
mod heading;
mod meaning;
mod path;
mod remains;
mod residuals;
mod ruler;
#[cfg(test)]
mod samples;
mod tables;
#[cfg(test)]
mod tests;
mod whiteness;

use super::page::{document, section};
use identification::finding::Finding;
use identification::model::Model;
use identification::outcome::{BlockDiagnostics, Diagnostics};
use maud::{Markup, html};

/// Maximum observed quantities with figures, figures of effects, and figures of residuals on a page: with the points of
/// each bounded, so is the page.
const BLOCKS_MAX: usize = 12;
const CURVES_MAX: usize = 20;
const RESIDUALS_MAX: usize = 30;

/// Renders the page of a data set's findings. The same arguments give the same bytes.
pub fn page(finding: &Finding, model: &Model, diagnostics: &Diagnostics) -> String {
    let body = html! {
        (heading::heading(finding))
        (section("From plain to rich", path::figure(finding)))
        (section("What was found", Some(effects::cards(finding, diagnostics))))
        (section("What a firmware can take over", compensation::steps(finding)))
        (section("What is left", Some(remains::left(finding, diagnostics))))
        (section("What to do next", remains::next(finding)))
        (figures(diagnostics))
        (section("The model", Some(tables::parameters(model))))
        (section("The noise that remains", tables::noise(diagnostics)))
    };
    document(&format!("{}: identification", finding.dataset), &body).into_string()
}

/// Draws the figures of each observed quantity, as many as fit.
fn figures(diagnostics: &Diagnostics) -> Markup {
    let blocks = &diagnostics.blocks;
    let share = |most: usize| most / blocks.len().clamp(1, BLOCKS_MAX);
    html! {
        @for block in blocks.iter().take(BLOCKS_MAX) {
            (of_block(block, &diagnostics.run_labels, share(CURVES_MAX), share(RESIDUALS_MAX)))
        }
        @if blocks.len() > BLOCKS_MAX {
            p.missing {
                "Figures are drawn of " (BLOCKS_MAX) " observed quantities; "
                (blocks.len() - BLOCKS_MAX) " more are in finding.json."
            }
        }
    }
}

fn of_block(
    block: &BlockDiagnostics,
    run_labels: &[String],
    curves_max: usize,
    residuals_max: usize,
) -> Markup {
    html! {
        section {
            h2 { "Figures of " code { (block.label) } }
            p {
                "The residual is what was measured minus what a model says. Orange is the model given, "
                "blue the model with what was found."
            }
            (curves::figures(block, curves_max))
            (residuals::figures(block, residuals_max))
            div.plots {
                (whiteness::autocorrelation(block))
                (whiteness::allan(block))
                (by_run::figure(block, run_labels))
            }
        }
    }
}
