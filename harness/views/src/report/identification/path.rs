//! The models from simple to complex, and the chosen one.

use super::super::download::{Table, number};
use super::super::frame::{Axis, Frame, SCALE};
use super::super::palette::{BAND, CCW, CW, INK, OUTSIDE, PAPER};
use identification::finding::{Finding, PathModel};
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::{Color, RGBColor};
use record::figures;

/// Colours of the metrics.
const COLOURS: [RGBColor; 6] = [CCW, CW, BAND, PAPER, OUTSIDE, INK];
/// Radius of a point, and of the chosen model's point, in pixels of the drawing.
const POINT: i32 = 2 * SCALE as i32;
const CHOSEN: i32 = 5 * SCALE as i32;

/// Plots the errors of every model; `None` without models.
pub(super) fn figure(finding: &Finding) -> Option<Markup> {
    let path = &finding.path;
    let metrics: Vec<&String> = path.first()?.held_out.keys().collect();
    let chosen = path.iter().position(|model| model.chosen).unwrap_or(0);
    Some(html! {
        figure {
            h3 { "Error of each model on runs that took no part" }
            (draw(path, &metrics, chosen))
            figcaption {
                p {
                    "Each model has one term more than the one to its left, all of them fitted anew. Chosen is the "
                    "simplest that is as good as the best within its standard error: the large mark. In percent of "
                    "the model given."
                }
                (rows(path, &metrics))
                p.small { "Data: " (table(path, &metrics).link("path")) }
            }
        }
    })
}

fn draw(path: &[PathModel], metrics: &[&String], chosen: usize) -> Markup {
    let curves: Vec<Vec<(f64, f64, f64)>> = metrics
        .iter()
        .map(|metric| {
            let plain = path[0].held_out.get(*metric).map_or(f64::NAN, |error| error.value);
            let share = |(at, model): (usize, &PathModel)| {
                let error = model.held_out.get(*metric)?;
                let (value, spread) =
                    (100.0 * error.value / plain, 100.0 * error.standard_error / plain);
                (value.is_finite() && spread.is_finite()).then_some((at as f64, value, spread))
            };
            path.iter().enumerate().filter_map(share).collect()
        })
        .collect();
    let all = || curves.iter().flatten();
    let frame = Frame::wide(
        Axis::around("model", all().flat_map(|point| [point.0 - 0.3, point.0 + 0.3])),
        Axis::around(
            "error in % of the model given",
            all().flat_map(|point| [point.1 - point.2, point.1 + point.2]).chain([0.0]),
        ),
    );
    frame.plot("error of each model", |chart| {
        for (curve, colour) in curves.iter().zip(COLOURS.iter().cycle()) {
            let line: Vec<(f64, f64)> = curve.iter().map(|point| (point.0, point.1)).collect();
            chart.draw_series([PathElement::new(line, colour.stroke_width(SCALE))])?;
            let bars = curve.iter().map(|&(x, y, error)| {
                PathElement::new(vec![(x, y - error), (x, y + error)], colour.stroke_width(SCALE))
            });
            chart.draw_series(bars)?;
            let marks = curve.iter().map(|&(x, y, _)| {
                let size = if x == chosen as f64 { CHOSEN } else { POINT };
                Circle::new((x, y), size, colour.filled())
            });
            chart.draw_series(marks)?;
        }
        Ok(())
    })
}

fn rows(path: &[PathModel], metrics: &[&String]) -> Markup {
    html! {
        div.scroll.plain { table {
            thead { tr { th { "model" } th { "effects" } @for metric in metrics { th { (metric) } } } }
            tbody {
                @for (at, model) in path.iter().enumerate() {
                    tr {
                        td { (at) @if model.chosen { " (chosen)" } }
                        td { (if model.effects.is_empty() { "none".to_owned() } else { model.effects.join(", ") }) }
                        @for metric in metrics {
                            td {
                                @if let Some(error) = model.held_out.get(*metric) {
                                    (figures::quantity(error.value, error.standard_error, &error.unit))
                                }
                            }
                        }
                    }
                }
            }
        } }
    }
}

fn table(path: &[PathModel], metrics: &[&String]) -> Table {
    let unit = |metric: &str| path[0].held_out.get(metric).map_or("", |error| error.unit.as_str());
    let header = metrics.iter().flat_map(|metric| {
        let label = figures::axis_label(metric, unit(metric));
        [label.clone(), format!("{label} standard error")]
    });
    let mut table = Table::new(
        ["model".to_owned(), "effects".to_owned(), "chosen".to_owned()].into_iter().chain(header),
    );
    for (at, model) in path.iter().enumerate() {
        let errors = metrics.iter().flat_map(|metric| {
            let error = model.held_out.get(*metric);
            [error.map(|error| error.value), error.map(|error| error.standard_error)]
                .map(|value| value.map_or(String::new(), number))
        });
        let first = [at.to_string(), model.effects.join(" "), model.chosen.to_string()];
        table.row(first.into_iter().chain(errors));
    }
    table
}
