//! Observations over an axis, with the plan's bands, the paper's values, and their median.

use super::against::Against;
use super::download;
use super::frame::{Axis, Chart, DrawError, Drawn, Frame, SCALE};
use super::group::{Group, Look};
use super::listed::{LOWEST_AND_HIGHEST, counted};
use super::marks::{band_texts, draw_bands, draw_bars, draw_marks, is_outside};
use super::median::{median, running};
use super::observed::{Direction, Sample};
use super::palette::{OUTSIDE, PAPER};
use super::phases::Phases;
use super::thin::{Point, extremes};
use maud::{Markup, html};
use plotters::series::DashedLineSeries;
use plotters::style::{Color, RGBColor};
use record::figures;
use record::header::Band;

/// Columns of a plot; two marks per column are drawn.
const MARK_COLUMNS: usize = 280;

/// More samples are drawn without bars.
const BARS_MAX: usize = 120;

/// Lengths of dashes and dots, in pixels of the drawing.
pub(super) const DASH: (u32, u32) = (7 * SCALE, 4 * SCALE);
const DOTS: (u32, u32) = (2 * SCALE, 3 * SCALE);

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Given {
    Level(f64),
    /// A straight line: its slope, and its value at zero on the axis.
    Line(f64, f64),
    Place(f64),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Medians {
    /// One per group.
    Whole,
    /// One per column of the plot.
    Running,
}

#[derive(Debug)]
pub(super) struct Panel<'a> {
    pub title: &'a str,
    /// What the values are; label of their axis.
    pub value: &'a str,
    pub unit: &'a str,
    pub against: Against,
    pub groups: Vec<Group>,
    pub bands: &'a [Band],
    /// Values of the paper with their texts; equal texts appear once.
    pub paper: &'a [(Given, &'a str)],
    pub medians: Medians,
    pub file: &'a str,
}

impl Panel<'_> {
    /// Renders the figure; `None` without observations.
    pub(super) fn figure(&self) -> Option<Markup> {
        let samples: Vec<Sample> =
            self.groups.iter().flat_map(|group| &group.samples).copied().collect();
        if samples.is_empty() {
            return None;
        }
        let frame = self.frame(&samples);
        let has_bars = samples.len() <= BARS_MAX;
        let mut drawn = 0;
        let plot = frame.plot(self.title, |chart| {
            draw_bands(chart, &frame, self.bands, &|_| None)?;
            self.draw_paper(chart, &frame)?;
            if has_bars {
                draw_bars(chart, &samples, self.against)?;
            }
            for group in &self.groups {
                drawn += self.draw_group(chart, &frame, group)?;
            }
            Ok(())
        });
        let outside = samples.iter().filter(|sample| self.is_outside(sample)).count();
        let data = download::samples(&self.groups, self.unit);
        Some(html! {
            figure {
                h3 { (self.title) }
                (plot)
                figcaption {
                    p.legend {
                        @for group in &self.groups { (self.legend(group)) }
                        @if outside > 0 { span { i.mark.outside { "■" } (outside) " outside" } }
                        @for band in band_texts(self.bands, self.unit) { span { i.swatch {} (band) } }
                        @for text in self.paper_texts() { span { i.line.paper {} (text) } }
                    }
                    p {
                        (counted(samples.len(), "observation", drawn, LOWEST_AND_HIGHEST))
                        @if has_bars && samples.iter().any(|sample| sample.uncertainty > 0.0) {
                            "; bars are standard uncertainties"
                        }
                        ". " (data.link(self.file))
                    }
                }
            }
        })
    }

    fn frame(&self, samples: &[Sample]) -> Frame {
        let ends = self.bands.iter().flat_map(|band| [band.lower, band.upper]).flatten();
        let levels = self.paper.iter().filter_map(|(given, _)| match given {
            Given::Level(at) => Some(*at),
            _ => None,
        });
        let places = self.paper.iter().filter_map(|(given, _)| match given {
            Given::Place(at) => Some(*at),
            _ => None,
        });
        let bar = |sample: &Sample| match samples.len() <= BARS_MAX {
            true => [sample.value - sample.uncertainty, sample.value + sample.uncertainty],
            false => [sample.value; 2],
        };
        Frame::wide(
            Axis::around(
                self.against.label(),
                samples.iter().map(|sample| self.against.x(sample)).chain(places),
            ),
            Axis::around(
                figures::axis_label(self.value, self.unit),
                samples.iter().flat_map(bar).chain(ends).chain(levels),
            ),
        )
    }

    /// Bands of the paper's figures belong to a direction, never to a phase.
    fn is_outside(&self, sample: &Sample) -> bool {
        is_outside(sample, self.bands, &Phases::default())
    }

    fn points(&self, samples: &[Sample]) -> Vec<Point> {
        samples.iter().map(|sample| (self.against.x(sample), sample.value)).collect()
    }

    fn draw_paper(&self, chart: &mut Chart<'_>, frame: &Frame) -> Drawn {
        let (x, y) = (&frame.x.range, &frame.y.range);
        for (given, _) in self.paper {
            let ends = match *given {
                Given::Level(at) => [(x.start, at), (x.end, at)],
                Given::Place(at) => [(at, y.start), (at, y.end)],
                Given::Line(slope, at_zero) => [x.start, x.end].map(|x| (x, at_zero + slope * x)),
            };
            dashed(chart, &ends, DASH, PAPER)?;
        }
        Ok(())
    }

    fn draw_group(
        &self,
        chart: &mut Chart<'_>,
        frame: &Frame,
        group: &Group,
    ) -> Result<usize, DrawError> {
        let direction = (group.look == Look::Triangle).then_some(Direction::Cw);
        let style = group.look.colour();
        let (outside, inside): (Vec<Sample>, Vec<Sample>) =
            group.samples.iter().partition(|sample| self.is_outside(sample));
        let inside = extremes(&self.points(&inside), MARK_COLUMNS);
        let outside = extremes(&self.points(&outside), MARK_COLUMNS);
        let drawn = inside.len() + outside.len();
        draw_marks(chart, inside, direction, style.filled())?;
        draw_marks(chart, outside, direction, OUTSIDE.filled())?;
        let line = match self.medians {
            Medians::Running => running(&self.points(&group.samples)),
            Medians::Whole => median(&group.samples).map_or_else(Vec::new, |median| {
                vec![(frame.x.range.start, median), (frame.x.range.end, median)]
            }),
        };
        dashed(chart, &line, DOTS, style)?;
        Ok(drawn)
    }

    fn legend(&self, group: &Group) -> Markup {
        let class = group.look.class();
        let median = match self.medians {
            Medians::Whole => median(&group.samples).map(|median| {
                format!("median {}", figures::quantity(rounded(median), 0.0, self.unit))
            }),
            Medians::Running => Some("running median".to_owned()),
        };
        html! {
            (group.look.labelled(group.label))
            @if let Some(median) = median {
                span { i.line.{ (class) "-median" } {} (group.label) ": " (median) }
            }
        }
    }

    fn paper_texts(&self) -> Vec<&str> {
        let mut texts: Vec<&str> = Vec::new();
        for (_, text) in self.paper {
            if !texts.contains(text) {
                texts.push(text);
            }
        }
        texts
    }
}

/// Rounds to the digits that a plot can show.
fn rounded(value: f64) -> f64 {
    figures::exact(value, 3).parse().unwrap_or(value)
}

/// Draws a dashed line, if it has at least two points.
pub(super) fn dashed(
    chart: &mut Chart<'_>,
    line: &[Point],
    (on, off): (u32, u32),
    colour: RGBColor,
) -> Drawn {
    if line.len() > 1 {
        let style = colour.stroke_width(SCALE + SCALE / 2);
        chart.draw_series(DashedLineSeries::new(line.to_vec(), on, off, style))?;
    }
    Ok(())
}
