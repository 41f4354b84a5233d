//! The residual over time and over every channel, before and after side by side, all on one scale.

use super::super::frame::Frame;
use super::super::thin::Point;
use super::cloud::{Cloud, medians};
use super::curves::thinned;
use super::draw::{
    AFTER, BEFORE, draw_beyond, draw_cloud, draw_medians, draw_rings, draw_zero, shown_range,
};
use super::ruler::{Ruler, ends, placed};
use identification::outcome::BlockDiagnostics;
use maud::{Markup, html};
use plotters::style::RGBColor;
use record::figures;

/// Axis of a residual plot.
struct Over {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// Plots the residuals of a block over at most `most` channels.
pub(super) fn figures(block: &BlockDiagnostics, most: usize) -> Markup {
    let (drawn, constant): (Vec<Over>, Vec<Over>) =
        axes(block).into_iter().partition(|over| is_spread(&over.values));
    let left_out = drawn.len().saturating_sub(most);
    let range = shown_range(block.before.iter().chain(&block.after).copied());
    let y = Ruler::new("residual", &block.unit, range);
    html! {
        @if block.before.is_empty() { p.missing { "There is no residual." } } @else {
            p {
                "What the model explains leaves an even band around zero; what it misses bends the band "
                "or widens it. The joined dots are medians. Before and after have one scale."
            }
            div.small { (how_drawn(block)) }
            div.plots { @for over in drawn.iter().take(most) { (figure(block, over, &y, range)) } }
        }
        @if left_out > 0 { p.missing { (left_out) " more channels are not drawn." } }
        @if !constant.is_empty() {
            p.missing {
                "Constant, so not drawn: "
                (constant.iter().map(|over| over.name.as_str()).collect::<Vec<_>>().join(", ")) "."
            }
        }
    }
}

/// Returns time, run and each channel, once.
fn axes(block: &BlockDiagnostics) -> Vec<Over> {
    let over = |name: &str, unit: &str, values: Vec<f64>| Over {
        name: name.to_owned(),
        unit: unit.to_owned(),
        values,
    };
    let mut all = vec![
        over("time", &block.time_unit, block.time.clone()),
        over("run", "1", block.run.iter().map(|run| *run as f64 + 1.0).collect()),
    ];
    for channel in &block.channels {
        if all.iter().all(|over| over.name != channel.name) {
            all.push(over(&channel.name, &channel.unit, channel.values.clone()));
        }
    }
    // A single run needs neither an axis nor a note.
    all.retain(|over| over.name != "run" || is_spread(&over.values));
    all
}

fn is_spread(values: &[f64]) -> bool {
    let (low, high) = ends(values.iter().copied());
    low < high
}

fn figure(block: &BlockDiagnostics, over: &Over, y: &Ruler, range: (f64, f64)) -> Markup {
    let x = Ruler::around(&over.name, &over.unit, over.values.iter().copied());
    let points = |residual: &[f64]| -> Vec<Point> {
        over.values.iter().copied().zip(residual.iter().copied()).collect()
    };
    let sides = [("before", &block.before, BEFORE), ("after", &block.after, AFTER)].map(
        |(when, values, colour)| {
            let raw = points(values);
            let flagged = raw.iter().zip(&block.outliers).filter(|(_, is_outlier)| **is_outlier);
            let outliers: Vec<Point> = flagged.map(|(point, _)| *point).collect();
            (when, raw, outliers, colour)
        },
    );
    let panels = sides.map(|(when, raw, outliers, colour)| {
        let frame = Frame::small(x.axis(over.values.iter().copied()), y.axis([range.0, range.1]));
        let name = format!("{}-residual-over-{}-{when}", block.label, over.name);
        let cloud = Cloud::of(&raw);
        let drawn = panel(
            &frame,
            &name,
            &cloud.placed(&x, y),
            &placed(&raw, &x, y),
            &placed(&outliers, &x, y),
            colour,
        );
        let label = |name: &str, unit: &str| figures::axis_label(name, unit);
        let table = cloud.table(&label(&over.name, &over.unit), &label("residual", &block.unit));
        (when, drawn, table.link(&name))
    });
    let beyond = panels.iter().map(|(_, panel, _)| panel.beyond).max().unwrap_or(0);
    html! {
        figure {
            h3 { "Residual over " (over.name) }
            div.pair {
                @for (when, panel, link) in &panels {
                    div {
                        p.panel.(*when) { (*when) " " (link) }
                        (panel.plot)
                    }
                }
            }
            @if beyond > 0 {
                figcaption {
                    p {
                        i.mark.outside { "▲" } " at the edge: where points lie beyond it, in each plot at most "
                        (beyond)
                    }
                }
            }
        }
    }
}

/// Describes what all plots of a block share.
fn how_drawn(block: &BlockDiagnostics) -> Markup {
    let outliers = block.outliers.iter().filter(|is_outlier| **is_outlier).count();
    html! {
        (thinned(block.before.len(), 0))
        @if outliers > 0 {
            p { i.mark.outside { "○" } " " (outliers) " taken for outliers, with no weight in the fit" }
        }
    }
}

struct Panel {
    plot: Markup,
    /// Number of points beyond its edges.
    beyond: usize,
}

fn panel(
    frame: &Frame,
    name: &str,
    cloud: &Cloud,
    points: &[Point],
    outliers: &[Point],
    colour: RGBColor,
) -> Panel {
    let mut beyond = 0;
    let plot = frame.plot(name, |chart| {
        draw_cloud(chart, cloud, colour, &frame.y)?;
        draw_zero(chart, frame)?;
        draw_medians(chart, &medians(points), &frame.y)?;
        draw_rings(chart, outliers, &frame.y)?;
        beyond = draw_beyond(chart, points, frame)?;
        Ok(())
    });
    Panel { plot, beyond }
}
