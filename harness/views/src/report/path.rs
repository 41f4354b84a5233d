//! The true path of the base, and the path estimated by the controller.

use super::download::{Table, number};
use super::frame::{Axis, Chart, Drawn, Frame, SCALE};
use super::observed::is_drawable;
use super::palette::{CCW, REFERENCE};
use super::thin::{Point, simplified};
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::{Color, RGBColor};
use wire::units::Pose;

/// Points nearer to the last than this are dropped: half the resolution of the absolute measurement.
const SAME_PLACE_M: f64 = 0.001;

/// A longer step was not driven: a new pose was set, or the base was carried. At the base's limit of 0.78 m/s, two
/// truths recorded at the level of events are 0.39 m apart.
const JUMP_M: f64 = 0.5;

const POINTS_MAX: usize = 1_000_000;

/// Maximum corners drawn; the tolerance is doubled until they suffice.
const CORNERS_MAX: usize = 40_000;

/// Maximum corners in the file of the paths.
const TABLE_CORNERS_MAX: usize = 4_000;

/// A path of smaller extent counts as none: the base only turned.
const EXTENT_MIN_M: f64 = 0.05;

/// Positions in the order in which they were visited.
#[derive(Debug, Default)]
pub(super) struct Path {
    pieces: Vec<Vec<Point>>,
    points: usize,
    overflowed: u64,
    /// Number of positions that are outside any bench.
    nowhere: u64,
}

impl Path {
    /// Adds the next position; begins a new piece if it cannot have been driven to.
    pub(super) fn add(&mut self, pose: Pose) {
        let point = (pose.x.m(), pose.y.m());
        if !(is_drawable(point.0) && is_drawable(point.1)) {
            self.nowhere += 1;
            return;
        }
        let last = self.pieces.last().and_then(|piece| piece.last());
        let step = last.map(|last| (point.0 - last.0).hypot(point.1 - last.1));
        if step.is_some_and(|step| step < SAME_PLACE_M) {
            return;
        }
        if self.points >= POINTS_MAX {
            self.overflowed += 1;
            return;
        }
        self.points += 1;
        match self.pieces.last_mut() {
            Some(piece) if step.is_some_and(|step| step <= JUMP_M) => piece.push(point),
            _ => self.pieces.push(vec![point]),
        }
    }

    /// Whether the base did not travel.
    pub(super) fn is_empty(&self) -> bool {
        let extent = |axis: Axis| axis.range.end - axis.range.start;
        let x = extent(Axis::around("", self.all().map(|point| point.0)));
        let y = extent(Axis::around("", self.all().map(|point| point.1)));
        self.points < 2 || x.max(y) < EXTENT_MIN_M
    }

    fn ends(&self) -> Option<[Point; 2]> {
        Some([*self.pieces.first()?.first()?, *self.pieces.last()?.last()?])
    }

    fn all(&self) -> impl Iterator<Item = Point> + '_ {
        self.pieces.iter().flatten().copied()
    }

    /// Returns the pieces with few enough corners, and their maximum deviation from the true ones.
    fn thinned(&self, finest: f64, corners_max: usize) -> (Vec<Vec<Point>>, f64) {
        let mut tolerance = finest;
        loop {
            let pieces: Vec<_> =
                self.pieces.iter().map(|piece| simplified(piece, tolerance)).collect();
            let corners: usize = pieces.iter().map(Vec::len).sum();
            // Each piece keeps its ends at any tolerance.
            if corners <= corners_max.max(2 * pieces.len()) {
                return (pieces, tolerance);
            }
            tolerance *= 2.0;
        }
    }
}

/// A path, its colour and width, its name, and its class in the style sheet.
type Shown<'a> = (&'a Path, RGBColor, u32, &'static str, &'static str);

/// Draws the two paths in one plot; `None` if the base did not move.
pub(super) fn figure(believed: &Path, truth: &Path) -> Option<Markup> {
    let shown: Vec<Shown<'_>> = [
        (truth, REFERENCE, 5, "true", "truth"),
        (believed, CCW, 2, "as the controller reckoned", "ccw"),
    ]
    .into_iter()
    .filter(|(path, ..)| !path.is_empty())
    .collect();
    if shown.is_empty() {
        return None;
    }
    let all = || shown.iter().flat_map(|(path, ..)| path.all());
    let frame = Frame::square(
        Axis::around("x in m", all().map(|point| point.0)),
        Axis::around("y in m", all().map(|point| point.1)),
    );
    let mut tolerance_m: f64 = 0.0;
    let plot = frame.plot("path of the base", |chart| {
        for (path, colour, width, ..) in &shown {
            let (pieces, tolerance) = path.thinned(frame.unit_per_pixel(), CORNERS_MAX);
            tolerance_m = tolerance_m.max(tolerance);
            draw(chart, pieces, *colour, *width)?;
        }
        for (path, colour, ..) in &shown {
            let radius = 4 * SCALE as i32;
            chart
                .draw_series(path.ends().map(|[start, _]| {
                    Circle::new(start, radius, colour.stroke_width(SCALE + 1))
                }))?;
            chart.draw_series(
                path.ends().map(|[_, end]| Circle::new(end, radius, colour.filled())),
            )?;
        }
        Ok(())
    });
    let points: usize = shown.iter().map(|(path, ..)| path.points).sum();
    let overflowed: u64 = shown.iter().map(|(path, ..)| path.overflowed).sum();
    let nowhere = believed.nowhere + truth.nowhere;
    Some(html! {
        figure {
            h3 { "Path of the base" }
            (plot)
            figcaption {
                p.legend {
                    @for (_, _, _, label, class) in &shown {
                        span { i.line.(class) {} (label) }
                    }
                    span { i.mark.plain { "○" } "start" }
                    span { i.mark.plain { "●" } "end" }
                }
                p {
                    (points) " places; corners nearer than "
                    (format!("{:.1}", tolerance_m * 1e3))
                    " mm to the line are left out; both axes have the same scale."
                    @if overflowed > 0 { " " (overflowed) " later places were not kept." }
                    @if nowhere > 0 { " " (nowhere) " places are infinite or further than any bench, and not drawn." }
                    " " (table(&shown))
                }
            }
        }
    })
}

/// Writes the paths to a file with a limited number of corners, and a note on the deviation.
fn table(shown: &[Shown<'_>]) -> Markup {
    let mut table = Table::new(["path", "piece", "x_m", "y_m"]);
    let mut tolerance_m: f64 = 0.0;
    for (path, _, _, label, _) in shown {
        let (pieces, tolerance) = path.thinned(SAME_PLACE_M, TABLE_CORNERS_MAX / shown.len());
        tolerance_m = tolerance_m.max(tolerance);
        for (index, piece) in pieces.iter().enumerate().take(TABLE_CORNERS_MAX / shown.len()) {
            for (x, y) in piece {
                table.row([(*label).to_owned(), index.to_string(), number(*x), number(*y)]);
            }
        }
    }
    html! {
        (table.link("path")) " of corners to " (format!("{:.0}", 1e3 * tolerance_m)) " mm; every place: "
        code { "hil show RUN" }
    }
}

fn draw(chart: &mut Chart<'_>, pieces: Vec<Vec<Point>>, colour: RGBColor, width: u32) -> Drawn {
    let lines = pieces.into_iter().filter(|piece| piece.len() > 1);
    let style = colour.stroke_width(width);
    chart.draw_series(lines.map(|piece| PathElement::new(piece, style)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{CORNERS_MAX, Path, figure};
    use wire::units::{Angle, Length, Pose};

    fn path(points: impl IntoIterator<Item = (f64, f64)>) -> Path {
        let mut path = Path::default();
        for (x, y) in points {
            path.add(Pose { x: Length::from_m(x), y: Length::from_m(y), heading: Angle::ZERO });
        }
        path
    }

    #[test]
    fn a_new_pose_begins_a_new_piece() {
        let path =
            path([(0.0, 0.0), (0.0, 0.0), (0.2, 0.0), (4.0, 4.0), (4.2, 4.0), (f64::NAN, 0.0)]);
        assert_eq!(path.pieces, [[(0.0, 0.0), (0.2, 0.0)], [(4.0, 4.0), (4.2, 4.0)]]);
    }

    #[test]
    fn a_base_that_only_turned_has_no_path() {
        assert!(figure(&path([(0.0, 0.0), (0.002, 0.001)]), &Path::default()).is_none());
        assert!(figure(&path([(0.0, 0.0), (0.2, 0.1)]), &Path::default()).is_some());
    }

    #[test]
    fn a_wild_path_keeps_few_enough_corners() {
        let wild = path((0..200_000).map(|n| (f64::from(n % 7) * 0.01, f64::from(n % 11) * 0.01)));
        let (pieces, tolerance) = wild.thinned(1e-6, CORNERS_MAX);
        assert!(pieces.iter().map(Vec::len).sum::<usize>() <= CORNERS_MAX);
        assert!(tolerance > 1e-6);
    }
}
