//! Whether the residual is noise: its autocorrelation and its Allan deviation.

use super::super::download::{Table, number, place};
use super::super::frame::{Axis, Frame, SCALE};
use super::super::palette::{BAND, REFERENCE};
use super::super::thin::Point;
use super::draw::{AFTER, BEFORE, draw_dots, draw_line, draw_zero};
use identification::outcome::BlockDiagnostics;
use maud::{Markup, html};
use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;
use record::figures;

/// 95 % of a normal distribution lie within this many standard deviations.
const COVERAGE_95: f64 = 1.96;

/// This share of pure noise lies outside.
const OUTSIDE_SHARE: f64 = 0.05;

/// An excess over the expected number by more than this many of its standard deviations is not random. Assumption.
const CHANCE_DEVIATIONS: f64 = 4.0;

/// How many correlations of the residual leave the band.
pub(super) struct Whiteness {
    pub outside: usize,
    pub lags: usize,
    /// Expected number for pure noise.
    pub expected: f64,
}

impl Whiteness {
    pub(super) fn of(block: &BlockDiagnostics) -> Self {
        let band = band(block);
        let finite = || block.autocorrelation.1.iter().filter(|value| value.is_finite());
        let lags = finite().count();
        let outside = finite().filter(|value| value.abs() > band).count();
        Self { outside, lags, expected: OUTSIDE_SHARE * lags as f64 }
    }

    /// Whether that many can be random.
    pub(super) fn is_white(&self) -> bool {
        self.outside as f64 <= self.expected + CHANCE_DEVIATIONS * self.expected.sqrt()
    }
}

/// Half the height of the band that contains 95 % of the correlations of pure noise.
fn band(block: &BlockDiagnostics) -> f64 {
    COVERAGE_95 / (block.after.len().max(1) as f64).sqrt()
}

pub(super) fn autocorrelation(block: &BlockDiagnostics) -> Markup {
    let lagged = |values: &[f64]| -> Vec<Point> {
        let finite = values.iter().enumerate().filter(|(_, value)| value.is_finite());
        finite.map(|(index, value)| (index as f64 + 1.0, *value)).collect()
    };
    let (before, after) = (lagged(&block.autocorrelation.0), lagged(&block.autocorrelation.1));
    if before.is_empty() && after.is_empty() {
        return html! {};
    }
    let band = band(block);
    let all = || before.iter().chain(&after);
    let frame = Frame::wide(
        Axis::around("observations later", all().map(|p| p.0)),
        Axis::around("correlation", all().map(|p| p.1).chain([-2.0 * band, 2.0 * band])),
    );
    let plot = frame.plot("autocorrelation", |chart| {
        let (from, to) = (frame.x.range.start, frame.x.range.end);
        chart
            .draw_series([Rectangle::new([(from, -band), (to, band)], BAND.mix(0.16).filled())])?;
        let edges = [-band, band].map(|at| [(from, at), (to, at)]);
        chart.draw_series(edges.map(|line| PathElement::new(line, BAND.stroke_width(SCALE))))?;
        draw_zero(chart, &frame)?;
        draw_dots(chart, &before, BEFORE, true)?;
        draw_dots(chart, &after, AFTER, true)
    });
    let Whiteness { outside, lags, expected } = Whiteness::of(block);
    let mut table = Table::new(["observations later", "before", "after"]);
    for index in 0..block.autocorrelation.0.len().max(block.autocorrelation.1.len()) {
        let cell = |values: &[f64]| values.get(index).map_or_else(String::new, |v| number(*v));
        let (b, a) = (cell(&block.autocorrelation.0), cell(&block.autocorrelation.1));
        table.row([(index + 1).to_string(), b, a]);
    }
    html! {
        figure {
            h3 { "Does the residual remember?" }
            (plot)
            figcaption {
                (legend())
                p.legend { span { i.swatch {} "±1.96/√n: 95 % of pure noise lie within" } }
                p {
                    "Autocorrelation of the residual, the known memory of the noise taken out. Noise that "
                    "is new each time stays in the band: after, " (outside) " of " (lags)
                    " are outside, where about " (format!("{expected:.0}")) " would be by chance."
                }
                p.small { "Data: " (table.link(&format!("{}-autocorrelation", block.label))) }
            }
        }
    }
}

/// Plots the Allan deviation of the residual.
pub(super) fn allan(block: &BlockDiagnostics) -> Markup {
    let is_drawn = |(time, before, after): &&(f64, f64, f64)| {
        [time, before, after].iter().all(|value| **value > 0.0 && value.is_finite())
    };
    let shown: Vec<_> = block.allan.iter().filter(is_drawn).collect();
    let (Some(first), Some(last)) = (shown.first(), shown.last()) else {
        return html! {};
    };
    let line = |pick: fn(&(f64, f64, f64)) -> f64| -> Vec<Point> {
        shown.iter().map(|one| (one.0.log10(), pick(one).log10())).collect()
    };
    let (before, after) = (line(|one| one.1), line(|one| one.2));
    // The deviation of white noise falls with the root of the time.
    let fall = [first.0, last.0]
        .map(|time| (time.log10(), first.2.log10() - 0.5 * (time / first.0).log10()));
    let all = || before.iter().chain(&after);
    let frame = Frame::wide(
        Axis::decades(figures::axis_label("averaging time", &block.time_unit), all().map(|p| p.0)),
        Axis::decades(
            figures::axis_label("Allan deviation", &block.unit),
            all().chain(&fall).map(|p| p.1),
        ),
    );
    let plot = frame.plot("Allan deviation", |chart| {
        draw_line(chart, fall.to_vec(), REFERENCE, SCALE)?;
        draw_dots(chart, &before, BEFORE, true)?;
        draw_dots(chart, &after, AFTER, true)
    });
    let mut table = Table::new([
        figures::axis_label("averaging time", &block.time_unit),
        figures::axis_label("before", &block.unit),
        figures::axis_label("after", &block.unit),
    ]);
    for (time, before, after) in &block.allan {
        table.row([place(*time), number(*before), number(*after)]);
    }
    html! {
        figure {
            h3 { "How far does averaging help?" }
            (plot)
            figcaption {
                (legend())
                p {
                    "Allan deviation of the residual: how much averages over that time differ from one "
                    "to the next. Along the grey line (white noise) longer averages are better; where a "
                    "curve leaves it upwards, something drifts."
                }
                p.small { "Data: " (table.link(&format!("{}-allan-deviation", block.label))) }
            }
        }
    }
}

/// Explains the colours.
pub(super) fn legend() -> Markup {
    html! {
        p.legend {
            span { i.mark.before { "●" } "before" }
            span { i.mark.after { "●" } "after" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Whiteness;
    use crate::report::identification::samples::block;

    #[test]
    fn memory_is_told_from_chance() {
        let mut block = block(400);
        block.autocorrelation.1 = (0..60).map(|i| if i < 5 { 0.2 } else { 0.05 }).collect();
        let few = Whiteness::of(&block);
        assert_eq!((few.outside, few.lags, few.is_white()), (5, 60, true));
        block.autocorrelation.1 = vec![0.2; 60];
        assert!(!Whiteness::of(&block).is_white());
        block.autocorrelation.1 = Vec::new();
        assert!(Whiteness::of(&block).is_white(), "nothing says otherwise");
    }
}
