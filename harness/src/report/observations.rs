//! A plot for each quantity: its observations over their natural axis, and where they should lie.

use super::collect::{Collected, Direction, Sample, Series};
use super::frame::{Axis, Chart, Drawn, Frame, SCALE};
use super::palette::{BAND, CCW, CW, OUTSIDE, REFERENCE};
use super::scatter;
use super::thin::{Point, extremes};
use crate::figures;
use crate::record::header::{Band, Header, Quantity};
use maud::{Markup, html};
use plotters::element::{Circle, PathElement, Rectangle, TriangleMarker};
use plotters::style::{Color, ShapeStyle};

/// The most plots on a page: with the marks of each bounded, so is the page.
const PLOTS_MAX: usize = 40;

/// Columns of a plot of marks, and of a line; two points of each column are drawn.
const MARK_COLUMNS: usize = 280;
const LINE_COLUMNS: usize = 600;

/// More samples than this over time are a log, drawn as a line.
const MARKS_OVER_TIME_MAX: usize = 150;

/// More samples than this are drawn without bars.
const BARS_MAX: usize = 120;

/// Radius of a mark, in CSS pixels times [`SCALE`].
const MARK_RADIUS: i32 = 3 * SCALE as i32;

/// A temperature axis needs this span, in kelvin, to show anything. Assumption: twice the 0.5 K of
/// which the paper's scale error makes 0.26 deg in a turn.
const TEMPERATURE_SPAN_MIN: f64 = 1.0;

const SECONDS_PER_MINUTE: f64 = 60.0;
const SECONDS_PER_HOUR: f64 = 3_600.0;

/// What a quantity is drawn over.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Against {
    Temperature,
    Run,
    Time { unit: &'static str, unit_s: f64 },
}

impl Against {
    fn of(samples: &[Sample]) -> Self {
        let span = |read: fn(&Sample) -> Option<f64>| {
            let axis = samples.iter().map(read).collect::<Option<Vec<_>>>()?;
            let low = axis.iter().copied().reduce(f64::min)?;
            Some(axis.into_iter().reduce(f64::max)? - low)
        };
        if span(|s| s.temperature).is_some_and(|span| span >= TEMPERATURE_SPAN_MIN) {
            return Self::Temperature;
        }
        if span(|s| s.run).is_some_and(|span| span > 0.0) {
            return Self::Run;
        }
        let (unit, unit_s) = match samples.iter().map(|s| s.at_s).fold(0.0, f64::max) {
            end if end > 2.0 * SECONDS_PER_HOUR => ("h", SECONDS_PER_HOUR),
            end if end > 5.0 * SECONDS_PER_MINUTE => ("min", SECONDS_PER_MINUTE),
            _ => ("s", 1.0),
        };
        Self::Time { unit, unit_s }
    }

    fn label(self) -> String {
        match self {
            Self::Temperature => "temperature in degC".to_owned(),
            Self::Run => "run".to_owned(),
            Self::Time { unit, .. } => format!("bench time in {unit}"),
        }
    }

    fn x(self, sample: &Sample) -> f64 {
        match self {
            Self::Temperature => sample.temperature.unwrap_or_default(),
            Self::Run => sample.run.unwrap_or_default(),
            Self::Time { unit_s, .. } => sample.at_s / unit_s,
        }
    }
}

/// All plots of observations.
pub(super) fn plots(header: &Header, collected: &Collected) -> Markup {
    let declared = |name: &str| {
        header
            .quantities
            .iter()
            .find(|quantity| quantity.name == name)
    };
    let figures: Vec<Markup> =
        collected
            .series
            .iter()
            .filter_map(|(name, series)| match scatter::partner(name) {
                scatter::Partner::X(y) if collected.series.contains_key(&y) => Some(
                    scatter::figure(name, series, &collected.series[&y], declared(name)),
                ),
                scatter::Partner::Y(x) if collected.series.contains_key(&x) => None,
                _ => Some(figure(name, series, declared(name))),
            })
            .take(PLOTS_MAX)
            .collect();
    let left_out = collected.series.len().saturating_sub(PLOTS_MAX);
    html! {
        @if figures.is_empty() {
            p.missing { "Nothing was observed." }
        }
        div.plots { @for figure in figures { (figure) } }
        @if left_out > 0 {
            p.missing { "At most " (PLOTS_MAX) " plots are drawn; the record holds more quantities." }
        }
        @if collected.series_overflowed > 0 {
            p.missing { (collected.series_overflowed) " observations of yet more quantities were not kept." }
        }
    }
}

fn figure(name: &str, series: &Series, declared: Option<&Quantity>) -> Markup {
    let samples = &series.samples;
    let unit = declared.map_or("", |quantity| &quantity.unit);
    let bands = declared.map_or(&[][..], |quantity| &quantity.bands);
    let against = Against::of(samples);
    let is_log = matches!(against, Against::Time { .. }) && samples.len() > MARKS_OVER_TIME_MAX;
    let ends = bands
        .iter()
        .flat_map(|band| [band.lower, band.upper])
        .flatten();
    let frame = Frame::wide(
        Axis::around(
            against.label(),
            samples.iter().map(|sample| against.x(sample)),
        ),
        Axis::around(
            figures::axis_label(name, unit),
            samples.iter().map(|s| s.value).chain(ends),
        ),
    );
    let mut drawn = 0;
    let plot = frame.plot(name, |chart| {
        draw_bands(chart, &frame, bands)?;
        if samples.len() <= BARS_MAX {
            draw_bars(chart, samples, against)?;
        }
        for (direction, style) in [
            (None, CCW),
            (Some(Direction::Ccw), CCW),
            (Some(Direction::Cw), CW),
        ] {
            let points = |keep: &dyn Fn(&Sample) -> bool| -> Vec<Point> {
                let kept = samples
                    .iter()
                    .filter(|s| s.direction == direction && keep(s));
                kept.map(|sample| (against.x(sample), sample.value))
                    .collect()
            };
            if is_log {
                let line = extremes(&points(&|_| true), LINE_COLUMNS);
                drawn += line.len();
                chart.draw_series([PathElement::new(line, style.stroke_width(SCALE))])?;
                continue;
            }
            let inside = extremes(&points(&|s| !is_outside(s, bands)), MARK_COLUMNS);
            let outside = extremes(&points(&|s| is_outside(s, bands)), MARK_COLUMNS);
            drawn += inside.len() + outside.len();
            draw_marks(chart, inside, direction, style.filled())?;
            draw_marks(chart, outside, direction, OUTSIDE.filled())?;
        }
        Ok(())
    });
    html! {
        figure {
            h3 { (title(name, declared)) }
            @if samples.is_empty() { p.missing { "No value can be drawn." } } @else { (plot) }
            (caption(series, bands, unit, drawn, is_log))
        }
    }
}

pub(super) fn title(name: &str, declared: Option<&Quantity>) -> Markup {
    let title = declared.map_or("", |quantity| quantity.title.as_str());
    html! { code { (name) } @if !title.is_empty() { " " (title) } }
}

fn caption(series: &Series, bands: &[Band], unit: &str, drawn: usize, is_log: bool) -> Markup {
    let samples = &series.samples;
    let has = |direction| {
        samples
            .iter()
            .any(|sample| sample.direction == Some(direction))
    };
    let has_bars =
        samples.len() <= BARS_MAX && samples.iter().any(|sample| sample.uncertainty > 0.0);
    let outside = samples
        .iter()
        .filter(|sample| is_outside(sample, bands))
        .count();
    html! {
        figcaption {
            p.legend {
                @if has(Direction::Ccw) { span { i.mark.ccw { "●" } "ccw" } }
                @if has(Direction::Cw) { span { i.mark.cw { "▲" } "cw" } }
                @if outside > 0 && !is_log { span { i.mark.outside { "■" } (outside) " outside" } }
                @for band in bands {
                    span {
                        i.swatch {}
                        (band.measurement) ": " (figures::band(band.lower, band.upper, unit))
                        @if let Some(paper) = &band.paper { " (paper: " (paper) ")" }
                    }
                }
            }
            p {
                (samples.len()) " observation" @if samples.len() != 1 { "s" }
                @if drawn < samples.len() {
                    "; " (drawn) " drawn, the lowest and the highest of each column"
                }
                @if has_bars { "; bars are standard uncertainties" }
                "."
                @if series.not_numbers > 0 { " " (series.not_numbers) " were no numbers." }
                @if series.overflowed > 0 { " " (series.overflowed) " later ones were not kept." }
            }
        }
    }
}

/// Outside a band that means it. Bands with tags that are not drawn here mark nothing.
fn is_outside(sample: &Sample, bands: &[Band]) -> bool {
    bands.iter().any(|band| {
        let meant = band
            .tags
            .iter()
            .all(|(tag, value)| match (tag.as_str(), sample.direction) {
                ("direction", Some(Direction::Cw)) => *value < 0.0,
                ("direction", Some(Direction::Ccw)) => *value > 0.0,
                _ => false,
            });
        let inside = band.lower.is_none_or(|lower| sample.value >= lower)
            && band.upper.is_none_or(|upper| sample.value <= upper);
        meant && !inside
    })
}

/// Each band once, and zero where it is in sight.
fn draw_bands(chart: &mut Chart<'_>, frame: &Frame, bands: &[Band]) -> Drawn {
    let (x, y) = (&frame.x.range, &frame.y.range);
    let across = |at: f64, style: ShapeStyle| PathElement::new([(x.start, at), (x.end, at)], style);
    let mut seen: Vec<(Option<f64>, Option<f64>)> = Vec::new();
    for band in bands {
        let ends = (band.lower, band.upper);
        if seen.contains(&ends) || ends == (None, None) {
            continue;
        }
        seen.push(ends);
        let corners = [
            (x.start, ends.0.unwrap_or(y.start).max(y.start)),
            (x.end, ends.1.unwrap_or(y.end).min(y.end)),
        ];
        chart.draw_series([Rectangle::new(corners, BAND.mix(0.12).filled())])?;
        let edges = [ends.0, ends.1].into_iter().flatten();
        chart.draw_series(edges.map(|at| across(at, BAND.stroke_width(SCALE))))?;
    }
    if y.contains(&0.0) {
        chart.draw_series([across(0.0, REFERENCE.stroke_width(SCALE))])?;
    }
    Ok(())
}

fn draw_bars(chart: &mut Chart<'_>, samples: &[Sample], against: Against) -> Drawn {
    let bars = samples
        .iter()
        .filter(|sample| sample.uncertainty > 0.0)
        .map(|sample| {
            let ends = [
                sample.value - sample.uncertainty,
                sample.value + sample.uncertainty,
            ];
            let x = against.x(sample);
            PathElement::new(ends.map(|y| (x, y)), REFERENCE.stroke_width(SCALE))
        });
    chart.draw_series(bars)?;
    Ok(())
}

pub(super) fn draw_marks(
    chart: &mut Chart<'_>,
    points: Vec<Point>,
    direction: Option<Direction>,
    style: ShapeStyle,
) -> Drawn {
    if direction == Some(Direction::Cw) {
        // A triangle of the same height looks smaller than a disc.
        let size = MARK_RADIUS + 2;
        chart.draw_series(
            points
                .into_iter()
                .map(|at| TriangleMarker::new(at, size, style)),
        )?;
    } else {
        chart.draw_series(
            points
                .into_iter()
                .map(|at| Circle::new(at, MARK_RADIUS, style)),
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Against, Direction, Sample, is_outside};
    use crate::record::header::Band;
    use std::collections::BTreeMap;

    fn sample(at_s: f64, temperature: Option<f64>, run: Option<f64>) -> Sample {
        let direction = Some(Direction::Cw);
        Sample {
            at_s,
            value: 0.3,
            uncertainty: 0.0,
            direction,
            run,
            temperature,
        }
    }

    #[test]
    fn the_axis_is_the_one_that_says_most() {
        let of = |tags: [(Option<f64>, Option<f64>); 2]| {
            let samples: Vec<_> = tags
                .into_iter()
                .map(|(t, run)| sample(30_000.0, t, run))
                .collect();
            Against::of(&samples)
        };
        let (one, two) = (Some(1.0), Some(2.0));
        assert_eq!(
            of([(Some(20.0), one), (Some(40.0), two)]),
            Against::Temperature
        );
        assert_eq!(of([(Some(20.0), one), (Some(20.1), two)]), Against::Run);
        assert_eq!(
            of([(None, one), (None, one)]),
            Against::Time {
                unit: "h",
                unit_s: 3_600.0
            }
        );
        assert_eq!(
            of([(Some(20.0), None), (None, None)]).label(),
            "bench time in h"
        );
        assert_eq!(Against::of(&[]).label(), "bench time in s");
    }

    #[test]
    fn a_band_marks_only_what_it_means() {
        let band = |direction: Option<f64>| Band {
            lower: Some(-0.25),
            upper: Some(0.25),
            tags: direction
                .map(|sign| ("direction".to_owned(), sign))
                .into_iter()
                .collect(),
            ..Band::default()
        };
        let cw = sample(0.0, None, None);
        assert!(is_outside(&cw, &[band(None)]));
        assert!(is_outside(&cw, &[band(Some(1.0)), band(Some(-1.0))]));
        assert!(!is_outside(&cw, &[band(Some(1.0))]));
        let other = Band {
            tags: BTreeMap::from([("speed".to_owned(), 1.0)]),
            ..band(None)
        };
        assert!(!is_outside(&cw, &[other]));
        assert!(
            !is_outside(&Sample { value: 0.25, ..cw }, &[band(None)]),
            "ends are inside"
        );
    }
}
