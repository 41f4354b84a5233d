//! Each effect over its driver, with the observations in which it was found.

use super::super::download::Table;
use super::super::frame::{Frame, SCALE};
use super::super::palette::REFERENCE;
use super::cloud::{Cloud, is_thinned, medians};
use super::draw::{AFTER, draw_cloud, draw_dots, draw_line, draw_medians, draw_zero, shown_range};
use super::meaning::{axis_name, title};
use super::ruler::{Ruler, ends, placed};
use identification::outcome::{BlockDiagnostics, EffectCurve};
use maud::{Markup, html};

/// Height of the plot relative to curve and medians if the noise is much larger.
const ZOOM: f64 = 2.5;

/// A curve with more reversals than this between its points is no function of its driver alone.
const TURNS_MAX: usize = 20;

/// Draws the effects of a block, at most `most`.
pub(super) fn figures(block: &BlockDiagnostics, most: usize) -> Markup {
    let left_out = block.effects.len().saturating_sub(most);
    html! {
        div.plots {
            @for (index, curve) in block.effects.iter().take(most).enumerate() {
                (figure(curve, block, &format!("{}-effect-{}-{}", block.label, index + 1, curve.name)))
            }
        }
        @if left_out > 0 { p.missing { (left_out) " weaker effects are not drawn." } }
    }
}

fn figure(curve: &EffectCurve, block: &BlockDiagnostics, name: &str) -> Markup {
    let unit = driver_unit(curve, block);
    let over = axis_name(&curve.driver);
    let x = Ruler::around(&over, unit, curve.points.iter().map(|p| p.0));
    let raw_medians = medians(&curve.observed);
    let seen = curve.points.iter().chain(&raw_medians).map(|p| p.1);
    let range = zoomed(
        ends(seen),
        shown_range(curve.observed.iter().map(|p| p.1)),
        !curve.observed.is_empty(),
    );
    let y = Ruler::new("effect", &curve.unit, range);
    let points = placed(&curve.points, &x, &y);
    let observed = placed(&curve.observed, &x, &y);
    if points.is_empty() {
        return html! {};
    }
    let raw_cloud = Cloud::of(&curve.observed);
    let cloud = raw_cloud.placed(&x, &y);
    let is_line = is_line(&points);
    let frame = Frame::wide(
        x.axis(curve.points.iter().chain(&curve.observed).map(|p| p.0)),
        y.axis([range.0, range.1]),
    );
    let mut beyond = 0;
    let plot = frame.plot(&curve.name, |chart| {
        draw_cloud(chart, &cloud, REFERENCE, &frame.y)?;
        draw_zero(chart, &frame)?;
        beyond = beyond_of(&observed, &frame);
        draw_medians(chart, &placed(&raw_medians, &x, &y), &frame.y)?;
        if is_line {
            draw_line(chart, points.clone(), AFTER, 3 * SCALE)
        } else {
            draw_dots(chart, &points, AFTER, false)
        }
    });
    html! {
        figure {
            h3 { (title(&curve.name)) }
            (plot)
            figcaption {
                p.legend {
                    span { i.line {} "the effect as fitted" }
                    @if !curve.observed.is_empty() {
                        span { i.mark.faint { "●" } "observed, less all else in the model" }
                        span { i.mark.median { "●" } "medians" }
                    }
                }
                p { (explanation(curve, is_line)) }
                (thinned(observed.len(), beyond))
                p.small {
                    "Data: "
                    (Table::of_points(&curve.driver, &format!("effect in {}", curve.unit), &curve.points)
                        .link(name))
                    @if !curve.observed.is_empty() {
                        " of the line, "
                        (raw_cloud.table(&curve.driver, &format!("observed in {}", curve.unit))
                            .link(&format!("{name}-observed")))
                        " of the observations"
                    }
                }
            }
        }
    }
}

fn explanation(curve: &EffectCurve, is_line: bool) -> &'static str {
    match (curve.observed.is_empty(), is_line) {
        (true, _) => {
            "What the effect adds. Its observations build up from row to row, so that none can be drawn \
             beside it; the residuals below show what it changed."
        }
        (false, true) => {
            "Where the joined dots follow the line, the effect is in the data and not only in the model."
        }
        (false, false) => {
            "The effect depends on a second cause too, so that it is no line over the first alone."
        }
    }
}

/// States in a sentence what is not drawn individually.
pub(super) fn thinned(count: usize, beyond: usize) -> Markup {
    let is_thinned = is_thinned(count);
    html! {
        @if is_thinned || beyond > 0 {
            p.small {
                @if is_thinned {
                    (count) " points, drawn as columns: pale from the lowest to the highest, bold without "
                    "the outer 5 % at either end. "
                }
                @if beyond > 0 { (beyond) " lie beyond the plot." }
            }
        }
    }
}

/// Unit of the driver: that of the channel if it is one, which distinguishes Celsius from kelvin.
fn driver_unit<'a>(curve: &'a EffectCurve, block: &'a BlockDiagnostics) -> &'a str {
    let channel = block.channels.iter().find(|channel| channel.name == curve.driver);
    channel.map_or(&curve.driver_unit, |channel| &channel.unit)
}

fn beyond_of(points: &[(f64, f64)], frame: &Frame) -> usize {
    points.iter().filter(|point| !frame.y.range.contains(&point.1)).count()
}

/// Range of all observations if the effect is visible among them, else a range that makes it visible.
fn zoomed(effect: (f64, f64), observed: (f64, f64), is_observed: bool) -> (f64, f64) {
    let height = effect.1 - effect.0;
    if !is_observed || height <= 0.0 || !height.is_finite() {
        return effect;
    }
    let room = (ZOOM - 1.0) / 2.0 * height;
    (observed.0.max(effect.0 - room).min(effect.0), observed.1.min(effect.1 + room).max(effect.1))
}

fn is_line(points: &[(f64, f64)]) -> bool {
    let steps = points.windows(2).map(|pair| pair[1].1 - pair[0].1);
    let signs: Vec<bool> = steps.filter(|step| *step != 0.0).map(|step| step > 0.0).collect();
    signs.windows(2).filter(|pair| pair[0] != pair[1]).count() <= TURNS_MAX
}

#[cfg(test)]
mod tests {
    use super::{is_line, zoomed};

    #[test]
    fn a_small_effect_in_large_noise_is_seen() {
        assert_eq!(zoomed((-1.0, 1.0), (-100.0, 100.0), true), (-2.5, 2.5));
        assert_eq!(zoomed((-1.0, 1.0), (-1.5, 1.2), true), (-1.5, 1.2));
        assert_eq!(zoomed((-1.0, 1.0), (-0.5, 0.5), true), (-1.0, 1.0), "nothing of it is cut");
        assert_eq!(zoomed((0.0, 2.0), (-1.0, 1.0), false), (0.0, 2.0));
    }

    #[test]
    fn what_hops_about_is_no_line() {
        let hop = |i: i32| (f64::from(i), f64::from(i % 2));
        assert!(!is_line(&(0..80).map(hop).collect::<Vec<_>>()));
        assert!(is_line(
            &(0..80).map(|i| (f64::from(i), f64::from(i).sin())).collect::<Vec<_>>()[..40]
        ));
    }
}
