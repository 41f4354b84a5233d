//! What acts on the devices: messages, parameters and commands of the plan, and faults. Marked in plots over time.

use super::against::Against;
use super::collect::Collected;
use super::fault_spans::Span;
use super::frame::{Chart, Drawn, Frame, SCALE};
use super::palette::{OUTSIDE, PAPER};
use super::panel::{DASH, dashed};
use super::steps::Step;
use maud::{Markup, html};
use plotters::element::Rectangle;
use plotters::style::Color;
use std::ops::RangeInclusive;

/// Maximum number of marks in a plot, and of texts below it.
const MARKS_MAX: usize = 40;
const TEXTS_MAX: usize = 3;

/// The steps of the plan that act on a device, in order of time.
pub(super) fn steps(collected: &Collected) -> impl Iterator<Item = &Step> {
    collected.steps.all.iter().filter(|step| step.acts)
}

/// Marks what lies in the frame, if its axis is time.
pub(super) fn draw(
    chart: &mut Chart<'_>,
    frame: &Frame,
    against: Against,
    collected: &Collected,
) -> Drawn {
    let Against::Time { .. } = against else { return Ok(()) };
    let (x, y) = (&frame.x.range, &frame.y.range);
    for span in collected.faults.all().iter().take(MARKS_MAX) {
        let begin = against.place(span.begin_s).max(x.start);
        let end = against.place(span.end_s.unwrap_or(collected.end_s)).min(x.end);
        if begin <= end {
            let corners = [(begin, y.start), (end, y.end)];
            chart.draw_series([Rectangle::new(corners, OUTSIDE.mix(0.06).filled())])?;
            let edge = [(begin, y.start), (begin, y.end)];
            dashed(chart, &edge, (2 * SCALE, 2 * SCALE), OUTSIDE)?;
        }
    }
    let places = steps(collected).map(|step| against.place(step.begin_s));
    for at in places.filter(|at| x.contains(at)).take(MARKS_MAX) {
        dashed(chart, &[(at, y.start), (at, y.end)], DASH, PAPER)?;
    }
    Ok(())
}

/// The entries of a legend for what is drawn of this time.
pub(super) fn legend(
    against: Against,
    collected: &Collected,
    shown_s: RangeInclusive<f64>,
) -> Markup {
    let Against::Time { .. } = against else { return html! {} };
    let steps = || steps(collected).filter(|step| shown_s.contains(&step.begin_s));
    let faults: Vec<&Span> = collected
        .faults
        .all()
        .iter()
        .filter(|span| {
            span.begin_s <= *shown_s.end()
                && span.end_s.is_none_or(|end_s| end_s >= *shown_s.start())
        })
        .collect();
    let (acts, struck) = (steps().count(), faults.len());
    let rest = |count: usize| count.saturating_sub(TEXTS_MAX);
    html! {
        @if acts > 0 {
            span {
                i.line.paper {}
                @for (index, step) in steps().take(TEXTS_MAX).enumerate() {
                    @if index > 0 { "; " }
                    (step.title)
                }
                @if rest(acts) > 0 { "; and " (rest(acts)) " more" }
            }
        }
        @if struck > 0 {
            span {
                i.box.fault {}
                @for (index, span) in faults.iter().take(TEXTS_MAX).enumerate() {
                    @if index > 0 { "; " }
                    (span.name)
                }
                @if rest(struck) > 0 { "; and " (rest(struck)) " more" }
            }
        }
    }
}
