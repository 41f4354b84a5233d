//! The margin of each property, case by case.

use super::super::download::{ROWS_MAX, Table, number, place};
use super::super::frame::{Axis, Frame, SCALE};
use super::super::listed::{LOWEST_AND_HIGHEST, counted};
use super::super::marks::draw_marks;
use super::super::palette::{CCW, OUTSIDE, REFERENCE};
use super::super::thin::{Point, extremes};
use super::Gathered;
use super::gather::Margins;
use maud::{Markup, html};
use plotters::element::PathElement;
use plotters::style::Color;

/// Columns of a plot; two marks per column are drawn.
const COLUMNS: usize = 280;

const PLOTS_MAX: usize = 40;

/// Renders one plot per property; `None` if no property had a margin.
pub(super) fn plots(gathered: &Gathered) -> Option<Markup> {
    if gathered.margins.is_empty() {
        return None;
    }
    Some(html! {
        div.plots {
            @for (property, margins) in gathered.margins.iter().take(PLOTS_MAX) { (plot(property, margins)) }
        }
        @if gathered.margins_not_kept > 0 {
            p.missing { "Those of " (gathered.margins_not_kept) " later cases were not kept." }
        }
    })
}

fn plot(property: &str, margins: &Margins) -> Markup {
    let sorted = |points: &[Point]| {
        let mut points = points.to_vec();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let (held, broke) = (sorted(&margins.held), sorted(&margins.broke));
    let all = || held.iter().chain(&broke);
    let frame = Frame::wide(
        Axis::around("case", all().map(|point| point.0)),
        Axis::around("least margin", all().map(|point| point.1).chain([0.0, 1.0])),
    );
    let (held_drawn, broke_drawn) = (extremes(&held, COLUMNS), extremes(&broke, COLUMNS));
    let drawn = held_drawn.len() + broke_drawn.len();
    let name = format!("least margin of {property} over cases");
    let svg = frame.plot(&name, |chart| {
        let (x, y) = (&frame.x.range, 0.0);
        let style = REFERENCE.stroke_width(SCALE);
        chart.draw_series([PathElement::new([(x.start, y), (x.end, y)], style)])?;
        draw_marks(chart, held_drawn, None, CCW.filled())?;
        draw_marks(chart, broke_drawn, None, OUTSIDE.filled())
    });
    html! {
        figure {
            h3 { (property) }
            (svg)
            figcaption {
                p.legend {
                    @if !held.is_empty() { span { i.mark.ccw { "●" } (held.len()) " held" } }
                    @if !broke.is_empty() { span { i.mark.outside { "●" } (broke.len()) " broken" } }
                }
                p {
                    (counted(held.len() + broke.len(), "case", drawn, LOWEST_AND_HIGHEST))
                    ". " (table(&held, &broke).link(&format!("margin-{property}")))
                }
            }
        }
    }
}

/// Broken cases, and as many of the others as there is room for: their extremes.
fn table(held: &[Point], broke: &[Point]) -> Table {
    let broke_kept = extremes(broke, ROWS_MAX / 4);
    let held_kept = extremes(held, (ROWS_MAX - broke_kept.len()) / 2);
    let left_out = held.len() + broke.len() - held_kept.len() - broke_kept.len();
    let of = |points: Vec<Point>, word| points.into_iter().map(move |point| (point, word));
    let mut rows: Vec<(Point, &str)> =
        of(held_kept, "held").chain(of(broke_kept, "broken")).collect();
    rows.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
    let mut table = Table::new(["case", "margin", "verdict"]);
    for ((case, margin), verdict) in rows {
        table.row([place(case), number(margin), verdict.to_owned()]);
    }
    table.without(left_out)
}
