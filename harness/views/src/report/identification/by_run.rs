//! The error of each run when left out of the fit, before and after.

use super::super::download::{Table, number};
use super::super::frame::{Axis, Frame, SCALE};
use super::super::palette::{BAND, OUTSIDE};
use super::super::thin::extremes;
use super::draw::{AFTER, BEFORE, draw_dots, draw_zero};
use super::ruler::Ruler;
use super::whiteness::legend;
use identification::outcome::{BlockDiagnostics, RunError};
use maud::{Markup, html};
use plotters::element::Rectangle;
use plotters::style::Color;
use record::figures;

/// Maximum number of runs drawn as bars; more are points.
const BARS_MAX: usize = 60;

/// Columns for the best and worst of still more runs.
const COLUMNS: usize = 200;

/// Maximum number of runs labelled by name.
const NAMED_MAX: usize = 12;

/// Half the width of two bars, as a share of a run's space.
const HALF_WIDTH: f64 = 0.38;

/// Plots the errors and their change; empty for a single run.
pub(super) fn figure(block: &BlockDiagnostics, labels: &[String]) -> Markup {
    let finite = |run: &&RunError| run.before.is_finite() && run.after.is_finite();
    let runs: Vec<&RunError> = block.by_run.iter().filter(finite).collect();
    if runs.len() < 2 {
        return html! {};
    }
    let better = runs.iter().filter(|run| run.after < run.before).count();
    html! {
        figure {
            h3 { "Error of each run left out of the fit" }
            (errors(&runs, &block.unit))
            (changes(&runs))
            figcaption {
                (legend())
                p {
                    "Each run was predicted by a model fitted to others. It got better in " (better) " of "
                    (runs.len()) " runs (below: green is better, red is worse). A term that helps only "
                    "one run describes that run, not the device."
                }
                @if runs.len() <= NAMED_MAX {
                    p.small {
                        @for run in &runs {
                            (run.run + 1) ": " (labels.get(run.run).map_or("", |label| label)) " "
                        }
                    }
                }
                p.small { "Data: " (table(&runs, labels, &block.unit).link(&format!("{}-by-run", block.label))) }
            }
        }
    }
}

fn place(run: &RunError) -> f64 {
    run.run as f64 + 1.0
}

fn along(runs: &[&RunError]) -> Axis {
    let ends = runs.iter().flat_map(|run| [place(run) - 0.5, place(run) + 0.5]);
    Axis::around("run", ends)
}

fn errors(runs: &[&RunError], unit: &str) -> Markup {
    let y = Ruler::around("error", unit, runs.iter().flat_map(|run| [run.before, run.after]));
    let values = runs.iter().flat_map(|run| [run.before, run.after]);
    let mut axis = y.axis(values.chain([0.0]));
    axis.range.start = 0.0;
    let frame = Frame::wide(along(runs), axis);
    frame.plot("error of each run", |chart| {
        for (is_after, colour) in [(false, BEFORE), (true, AFTER)] {
            let value = |run: &RunError| y.place(if is_after { run.after } else { run.before });
            if runs.len() <= BARS_MAX {
                let bars = runs.iter().map(|run| {
                    let from = if is_after { 0.0 } else { -HALF_WIDTH };
                    let corners =
                        [(place(run) + from, 0.0), (place(run) + from + HALF_WIDTH, value(run))];
                    Rectangle::new(corners, colour.filled())
                });
                chart.draw_series(bars)?;
            } else {
                let points: Vec<_> = runs.iter().map(|run| (place(run), value(run))).collect();
                draw_dots(chart, &extremes(&points, COLUMNS), colour, false)?;
            }
        }
        Ok(())
    })
}

/// Plots the change of each run in percent of the error before.
fn changes(runs: &[&RunError]) -> Markup {
    let points: Vec<_> = runs
        .iter()
        .filter(|run| run.before > 0.0)
        .map(|run| (place(run), 100.0 * (run.after / run.before - 1.0)))
        .collect();
    let frame = Frame::wide(
        along(runs),
        Axis::around("change in %", points.iter().map(|point| point.1).chain([0.0])),
    );
    frame.plot("change of each run", |chart| {
        draw_zero(chart, &frame)?;
        let bars = extremes(&points, COLUMNS).into_iter().map(|(x, y)| {
            let colour = if y > 0.0 { OUTSIDE } else { BAND };
            let half = if runs.len() <= BARS_MAX { HALF_WIDTH } else { 0.5 };
            Rectangle::new([(x - half, 0.0), (x + half, y)], colour.stroke_width(SCALE).filled())
        });
        chart.draw_series(bars)?;
        Ok(())
    })
}

fn table(runs: &[&RunError], labels: &[String], unit: &str) -> Table {
    let mut table = Table::new([
        "run".to_owned(),
        "label".to_owned(),
        figures::axis_label("before", unit),
        figures::axis_label("after", unit),
    ]);
    for run in runs {
        let label = labels.get(run.run).cloned().unwrap_or_default();
        table.row([(run.run + 1).to_string(), label, number(run.before), number(run.after)]);
    }
    table
}
