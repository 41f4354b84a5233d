//! Marks and lines shared by the figures of an identification.

use super::super::frame::{Axis, Chart, Drawn, Frame, SCALE};
use super::super::palette::{CCW, CW, INK, OUTSIDE, REFERENCE};
use super::super::thin::{Point, extremes};
use super::cloud::{Cloud, Column, quantile};
use plotters::element::{Circle, PathElement, Polygon, TriangleMarker};
use plotters::style::{Color, RGBColor};

/// The given model.
pub(super) const BEFORE: RGBColor = CW;
/// The model with the effects found.
pub(super) const AFTER: RGBColor = CCW;

/// Radius of a point, in pixels of the drawing.
const POINT_RADIUS: i32 = 2 * SCALE as i32;
/// Radius of an emphasized mark.
const MARK_RADIUS: i32 = 3 * SCALE as i32;

const POINT_OPACITY: f64 = 0.55;
const SPREAD_OPACITY: f64 = 0.18;
const BULK_OPACITY: f64 = 0.42;

/// Maximum number of marks of one kind at an edge of a plot.
const MARK_COLUMNS: usize = 60;

/// Share of the range of the middle 98 % of values that is shown beyond it at either end.
const ROOM_SHARE: f64 = 1.5;

/// Range in which `values` are drawn: all of them, unless a few distant ones would hide the others.
pub(super) fn shown_range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (quantile(&sorted, 0.01), quantile(&sorted, 0.99)) else {
        return (-1.0, 1.0);
    };
    let room = ROOM_SHARE * (high - low);
    let (lowest, highest) = (sorted[0], sorted[sorted.len() - 1]);
    // If most values are equal, the others are of interest.
    if room > 0.0 { (lowest.max(low - room), highest.min(high + room)) } else { (lowest, highest) }
}

/// Draws points, or the spread of columns: the whole column pale, without its outer twentieths bold.
pub(super) fn draw_cloud(
    chart: &mut Chart<'_>,
    cloud: &Cloud,
    colour: RGBColor,
    y: &Axis,
) -> Drawn {
    let range = (y.range.start, y.range.end);
    match cloud {
        Cloud::Marks(points) => {
            let style = colour.mix(POINT_OPACITY).filled();
            let inside = points.iter().filter(|point| y.range.contains(&point.1));
            chart.draw_series(inside.map(|at| Circle::new(*at, POINT_RADIUS, style)))?;
        }
        Cloud::Columns(columns) => {
            let all = outlines(columns, |column| (column.lowest, column.highest), range);
            let bulk = outlines(columns, |column| (column.low, column.high), range);
            for (outlines, opacity) in [(all, SPREAD_OPACITY), (bulk, BULK_OPACITY)] {
                let style = colour.mix(opacity).filled();
                chart.draw_series(outlines.into_iter().map(|line| Polygon::new(line, style)))?;
            }
        }
    }
    Ok(())
}

/// Step outlines of adjacent columns; an empty column begins a new outline.
fn outlines(
    columns: &[Column],
    extent: impl Fn(&Column) -> (f64, f64),
    (from, to): (f64, f64),
) -> Vec<Vec<Point>> {
    let neighbours = |a: &Column, b: &Column| a.index + 1 == b.index;
    let outline = |piece: &[Column]| {
        let lower = piece.iter().flat_map(|column| {
            let y = extent(column).0.clamp(from, to);
            [(column.x.0, y), (column.x.1, y)]
        });
        let upper = piece.iter().rev().flat_map(|column| {
            let y = extent(column).1.clamp(from, to);
            [(column.x.1, y), (column.x.0, y)]
        });
        lower.chain(upper).collect()
    };
    columns.chunk_by(neighbours).map(outline).collect()
}

/// Draws a triangle at the edge for points beyond it; returns their number.
pub(super) fn draw_beyond(
    chart: &mut Chart<'_>,
    points: &[Point],
    frame: &Frame,
) -> Result<usize, plotters::drawing::DrawingAreaErrorKind<std::io::Error>> {
    let (from, to) = (frame.y.range.start, frame.y.range.end);
    let edge = 0.02 * (to - from);
    let above: Vec<Point> =
        points.iter().filter(|point| point.1 > to).map(|point| (point.0, to - edge)).collect();
    let below: Vec<Point> =
        points.iter().filter(|point| point.1 < from).map(|point| (point.0, from + edge)).collect();
    for points in [&above, &below] {
        let marks = extremes(points, MARK_COLUMNS);
        let style = OUTSIDE.filled();
        chart
            .draw_series(marks.into_iter().map(|at| TriangleMarker::new(at, MARK_RADIUS, style)))?;
    }
    Ok(above.len() + below.len())
}

pub(super) fn draw_rings(chart: &mut Chart<'_>, points: &[Point], y: &Axis) -> Drawn {
    let inside: Vec<Point> =
        points.iter().filter(|point| y.range.contains(&point.1)).copied().collect();
    let style = OUTSIDE.stroke_width(SCALE);
    let marks = extremes(&inside, MARK_COLUMNS);
    chart.draw_series(marks.into_iter().map(|at| Circle::new(at, MARK_RADIUS, style)))?;
    Ok(())
}

/// Draws dots, connected if `joined`.
pub(super) fn draw_dots(
    chart: &mut Chart<'_>,
    points: &[Point],
    colour: RGBColor,
    joined: bool,
) -> Drawn {
    if joined {
        draw_line(chart, points.to_vec(), colour, SCALE)?;
    }
    let style = colour.filled();
    chart.draw_series(points.iter().map(|at| Circle::new(*at, POINT_RADIUS + 1, style)))?;
    Ok(())
}

pub(super) fn draw_line(
    chart: &mut Chart<'_>,
    points: Vec<Point>,
    colour: RGBColor,
    width: u32,
) -> Drawn {
    if points.len() > 1 {
        chart.draw_series([PathElement::new(points, colour.stroke_width(width))])?;
    }
    Ok(())
}

/// Draws zero, if it is in range.
pub(super) fn draw_zero(chart: &mut Chart<'_>, frame: &Frame) -> Drawn {
    if frame.y.range.contains(&0.0) {
        let line = vec![(frame.x.range.start, 0.0), (frame.x.range.end, 0.0)];
        draw_line(chart, line, REFERENCE, SCALE)?;
    }
    Ok(())
}

pub(super) fn draw_medians(chart: &mut Chart<'_>, medians: &[Point], y: &Axis) -> Drawn {
    let inside: Vec<Point> =
        medians.iter().filter(|point| y.range.contains(&point.1)).copied().collect();
    draw_dots(chart, &inside, INK, true)
}

#[cfg(test)]
mod tests {
    use super::{outlines, shown_range};
    use crate::report::identification::cloud::columns;

    #[test]
    fn one_wild_value_does_not_flatten_the_plot() {
        let calm = || (0..1_000).map(|i| f64::from(i % 100));
        assert_eq!(shown_range(calm()), (0.0, 99.0), "calm values are all in it");
        let (low, high) = shown_range(calm().chain([1e6, f64::NAN]));
        assert!(low >= 0.0 && high < 500.0, "{low} {high}");
        assert_eq!(shown_range([]), (-1.0, 1.0));
        let mostly_zero = (0..1_000).map(|i| if i == 7 { 5.0 } else { 0.0 });
        assert_eq!(shown_range(mostly_zero), (0.0, 5.0));
    }

    #[test]
    fn an_empty_column_parts_the_outline() {
        let points = [(0.0, 1.0), (1.0, 2.0), (9.0, 3.0), (10.0, 3.0)];
        let columns = columns(&points, 5);
        let found = outlines(&columns, |column| (column.lowest, column.highest), (0.0, 2.5));
        assert_eq!(found.len(), 2);
        assert!(found.iter().flatten().all(|point| point.1 <= 2.5), "cut at the edge");
    }
}
