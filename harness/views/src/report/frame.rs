//! Axes, shared by all plots of the page.
//!
//! plotters was chosen over kuva because each mark can have its own form and colour, and its SVG consists of plain
//! elements with the colour as an attribute, so that one style sheet can make it light or dark.

use super::palette::{GRID, INK};
use maud::{Markup, PreEscaped, html};
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::IntoDrawingArea;
use plotters::prelude::{Cartesian2d, DrawingAreaErrorKind, SVGBackend};
use plotters::style::{IntoFont, TextStyle};
use record::figures;
use std::io;
use std::ops::Range;

/// The drawing is this factor larger than displayed, since the library draws at whole pixels only.
pub(super) const SCALE: u32 = 2;

/// Displayed size of a plot over an axis, in CSS pixels.
const WIDTH: u32 = 620;
const HEIGHT: u32 = 290;

/// Displayed size of one of several plots side by side, in CSS pixels.
const SMALL_WIDTH: u32 = 300;
const SMALL_HEIGHT: u32 = 220;

/// Displayed side of the data area of a square plot.
const SQUARE_SIDE: u32 = 440;

/// Space for the labels, in CSS pixels.
const LEFT: u32 = 88;
const BOTTOM: u32 = 46;
const MARGIN: u32 = 12;

const FONT_SIZE: u32 = 13;

/// Approximate number of labelled ticks on an axis.
const TICKS: usize = 8;
const SMALL_TICKS: usize = 5;

/// Free share of the range at either end.
const FREE_SHARE: f64 = 0.06;

/// Share of a single value that is shown on either side of it.
const ALONE_SHARE: f64 = 0.1;

/// The chart of a frame, in the units of its axes.
pub(super) type Chart<'a> =
    ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Errors of drawing into memory; none are known.
pub(super) type DrawError = DrawingAreaErrorKind<io::Error>;

pub(super) type Drawn = Result<(), DrawError>;

/// Larger values lie outside the drawing: near the greatest doubles, where the range of a 64-bit float ends, the
/// library searches for ticks without end.
const DRAWN_MAX: f64 = 1e30;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Quantity and unit.
    pub label: String,
    pub range: Range<f64>,
    /// Whether values on the axis are powers of ten.
    is_decades: bool,
}

impl Axis {
    /// Creates an axis that contains all `values`, with some space at the ends.
    pub(super) fn around(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.abs() <= DRAWN_MAX)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let range = if low > high {
            -1.0..1.0
        } else {
            // A range of zero width cannot be drawn, nor one below the resolution of its ends.
            let floor = (low.abs().max(high.abs()) * 1e-6).max(1e-9);
            let free = match high - low {
                // A single value: its neighbourhood, with readable ticks.
                0.0 if low == 0.0 => 1.0,
                0.0 => low.abs() * ALONE_SHARE,
                span => (span * FREE_SHARE).max(floor),
            };
            low - free..high + free
        };
        Self { label: label.into(), range, is_decades: false }
    }

    /// Creates an axis of powers of ten that contains all `exponents`.
    pub(super) fn decades(
        label: impl Into<String>,
        exponents: impl IntoIterator<Item = f64>,
    ) -> Self {
        Self { is_decades: true, ..Self::around(label, exponents) }
    }

    /// Number of labelled ticks that fit; decades have whole ones if there are enough.
    fn ticks(&self, most: usize) -> usize {
        let span = (self.range.end - self.range.start).clamp(0.0, most as f64);
        if self.is_decades { (span as usize + 1).clamp(3, most) } else { most }
    }

    /// Formats a tick with the decimals that neighbouring ticks need to differ.
    fn tick(&self, value: f64) -> String {
        const DECIMALS_MAX: f64 = 9.0;
        if self.is_decades {
            return figures::value(10_f64.powf(value), 0.0);
        }
        let step = (self.range.end - self.range.start) / TICKS as f64;
        let decimals = (-step.log10().floor()).clamp(0.0, DECIMALS_MAX) as usize;
        let text = format!("{value:.decimals$}");
        match text.strip_prefix('-') {
            Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
            _ => text,
        }
    }
}

/// Two axes and the size of the plot.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub x: Axis,
    pub y: Axis,
    size: (u32, u32),
    ticks: usize,
}

impl Frame {
    pub(super) const fn wide(x: Axis, y: Axis) -> Self {
        Self { x, y, size: (WIDTH, HEIGHT), ticks: TICKS }
    }

    pub(super) const fn small(x: Axis, y: Axis) -> Self {
        Self { x, y, size: (SMALL_WIDTH, SMALL_HEIGHT), ticks: SMALL_TICKS }
    }

    /// Creates a plot with the same scale on both axes: the shorter range is widened.
    pub(super) fn square(mut x: Axis, mut y: Axis) -> Self {
        let side = (x.range.end - x.range.start).max(y.range.end - y.range.start);
        for axis in [&mut x, &mut y] {
            let middle = f64::midpoint(axis.range.start, axis.range.end);
            axis.range = middle - side / 2.0..middle + side / 2.0;
        }
        let size = (SQUARE_SIDE + LEFT + 2 * MARGIN, SQUARE_SIDE + BOTTOM + 2 * MARGIN);
        Self { x, y, size, ticks: TICKS }
    }

    /// Returns the size of one pixel of the drawing in the unit of the x axis.
    pub(super) fn unit_per_pixel(&self) -> f64 {
        let pixels = SCALE * (self.size.0 - LEFT - 2 * MARGIN);
        (self.x.range.end - self.x.range.start) / f64::from(pixels)
    }

    /// Draws the axes and what `draw` adds, as an `svg` element. Screen readers read `name`.
    pub(super) fn plot(&self, name: &str, draw: impl FnOnce(&mut Chart<'_>) -> Drawn) -> Markup {
        let mut svg = String::new();
        if let Err(error) = self.plot_into(&mut svg, draw) {
            return html! { p.missing { "This plot could not be drawn: " (error) } };
        }
        // The library's own opening tag fixes a size and names a schema by its address.
        let body = svg.split_once('>').map_or("", |(_, body)| body);
        let body = body.trim_end().strip_suffix("</svg>").unwrap_or(body);
        // Most marks are opaque: this attribute would take an eighth of the page.
        let body = body.replace(" opacity=\"1\"", "");
        let (width, height) = (self.size.0 * SCALE, self.size.1 * SCALE);
        html! {
            // On a narrow screen, where the labels of the ticks take the place of the title in the drawing.
            p.y-title { (self.y.label) }
            svg.plot role="img" aria-label=(name) viewBox={ "0 0 " (width) " " (height) }
                style={ "max-width:" (self.size.0) "px" } {
                (PreEscaped(body))
            }
        }
    }

    fn plot_into(&self, svg: &mut String, draw: impl FnOnce(&mut Chart<'_>) -> Drawn) -> Drawn {
        let size = (self.size.0 * SCALE, self.size.1 * SCALE);
        let area = SVGBackend::with_string(svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin(MARGIN * SCALE)
            .x_label_area_size(BOTTOM * SCALE)
            .y_label_area_size(LEFT * SCALE)
            .build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
        let text = TextStyle::from(("sans-serif", FONT_SIZE * SCALE).into_font()).color(&INK);
        chart
            .configure_mesh()
            .x_labels(self.x.ticks(self.ticks))
            .y_labels(self.y.ticks(self.ticks))
            .max_light_lines(0)
            .bold_line_style(GRID)
            .axis_style(INK)
            .label_style(text.clone())
            .axis_desc_style(text)
            .x_desc(&*self.x.label)
            .y_desc(&*self.y.label)
            .x_label_formatter(&|value| self.x.tick(*value))
            .y_label_formatter(&|value| self.y.tick(*value))
            .draw()?;
        draw(&mut chart)?;
        drop(chart);
        area.present()
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Frame};
    use proptest::prelude::*;

    fn axis(values: &[f64]) -> Axis {
        Axis::around("x", values.iter().copied())
    }

    #[test]
    fn a_plot_asks_nobody_for_anything() {
        let svg = Frame::wide(axis(&[0.0, 1.0]), axis(&[0.0, 1.0])).plot("a", |_| Ok(()));
        let svg = svg.into_string();
        assert!(svg.contains("</p><svg class=\"plot\"") && svg.ends_with("</svg>"), "{svg}");
        assert!(!svg.contains("http"));
        assert_eq!(svg.matches("<svg").count(), 1);
    }

    #[test]
    fn ticks_have_the_decimals_that_they_need() {
        assert_eq!(axis(&[36.98, 36.99]).tick(36.985), "36.985");
        assert_eq!(axis(&[-1.0, 1.0]).tick(-1e-17), "0.0");
        assert_eq!(axis(&[0.0, 900.0]).tick(100.000_000_1), "100");
        let decades = Axis::decades("x", [-3.0, 4.0]);
        assert_eq!((decades.tick(-2.0), decades.tick(3.0)), ("0.01".into(), "1000".into()));
    }

    proptest! {
        #[test]
        fn any_range_can_be_drawn(
            x in prop::collection::vec(-1e12..1e12f64, 0..3),
            y in prop::collection::vec(-1e-9..1e-9f64, 0..3),
            same in -1e12..1e12f64,
        ) {
            let _ = Frame::wide(axis(&x), axis(&y)).plot("a", |_| Ok(()));
            let _ = Frame::square(axis(&[same]), axis(&y)).plot("a", |_| Ok(()));
            let all = axis(&[f64::MIN, -1e30, same, 1e30, f64::MAX, f64::INFINITY, f64::NAN]);
            let _ = Frame::wide(axis(&x), all).plot("a", |_| Ok(()));
            prop_assert!(axis(&[same, same]).range.contains(&same));
        }
    }
}
