//! The margin of each property, case by case.

use super::super::download::Table;
use super::super::frame::{Axis, Frame, SCALE};
use super::super::listed::{LOWEST_AND_HIGHEST, counted};
use super::super::marks::draw_marks;
use super::super::palette::{CCW, OUTSIDE, REFERENCE};
use super::super::thin::{Point, extremes};
use super::Gathered;
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
            @for (property, points) in gathered.margins.iter().take(PLOTS_MAX) { (plot(property, points)) }
        }
        @if gathered.margins_not_kept > 0 {
            p.missing { "Those of " (gathered.margins_not_kept) " later cases were not kept." }
        }
    })
}

fn plot(property: &str, points: &[Point]) -> Markup {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let broken = points.iter().filter(|(_, margin)| *margin < 0.0).count();
    let drawn = extremes(&points, COLUMNS);
    let frame = Frame::wide(
        Axis::around("case", points.iter().map(|point| point.0)),
        Axis::around("least margin", points.iter().map(|point| point.1).chain([0.0, 1.0])),
    );
    let name = format!("least margin of {property} over cases");
    let svg = frame.plot(&name, |chart| {
        let (x, y) = (&frame.x.range, 0.0);
        let style = REFERENCE.stroke_width(SCALE);
        chart.draw_series([PathElement::new([(x.start, y), (x.end, y)], style)])?;
        let (broke, held): (Vec<Point>, Vec<Point>) =
            drawn.iter().partition(|(_, margin)| *margin < 0.0);
        draw_marks(chart, held, None, CCW.filled())?;
        draw_marks(chart, broke, None, OUTSIDE.filled())
    });
    html! {
        figure {
            h3 { (property) }
            (svg)
            figcaption {
                p.legend {
                    span { i.mark.ccw { "●" } "held" }
                    @if broken > 0 { span { i.mark.outside { "●" } (broken) " broken" } }
                }
                p {
                    (counted(points.len(), "case", drawn.len(), LOWEST_AND_HIGHEST))
                    ". " (Table::thinned("case", "margin", &points).link(&format!("margin-{property}")))
                }
            }
        }
    }
}
