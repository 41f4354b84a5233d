//! The robot on its square, seen from above.

use super::{Look, Panel, frame};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::symbols::Marker;
use ratatui::text::Line as TextLine;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Context, Line, Points};
use views::watch::Model;

/// Height of a terminal cell, relative to its width. Assumption: most fonts.
const CELL_ASPECT: f64 = 2.0;
/// Space around the path, as a share of its extent.
const MARGIN: f64 = 0.12;
/// Minimum extent, m: a robot at rest is a point.
const EXTENT_MIN_M: f64 = 0.5;
/// Arrows for the eight directions, counter-clockwise from the x axis.
const ARROWS: [&str; 8] = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];

pub(super) fn draw(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let robot = &model.robot;
    let block = frame(Panel::Square, title(model), look);
    let inner = block.inner(area);
    let believed = robot.state.map(|state| state.pose);
    let here = believed.map(|pose| (pose.x.m(), pose.y.m()));
    let all = [&robot.path, &robot.truth, &robot.commanded];
    let points = all.into_iter().flatten().copied().chain(here);
    let Some([x_bounds, y_bounds]) = bounds(points, inner) else {
        return block.render(area, picture);
    };
    let palette = look.palette;
    let paint = |context: &mut Context<'_>| {
        context.marker(Marker::Custom('·'));
        for corners in robot.commanded.windows(2) {
            let ((x1, y1), (x2, y2)) = (corners[0], corners[1]);
            context.draw(&Line { x1, y1, x2, y2, color: palette.ordered() });
        }
        context.layer();
        context.marker(Marker::Custom('*'));
        context.draw(&Points { coords: &robot.truth, color: palette.truth() });
        context.layer();
        context.marker(Marker::Braille);
        context.draw(&Points { coords: &robot.path, color: palette.believed() });
        if let (Some(pose), Some((x, y))) = (believed, here) {
            let eighths = (pose.heading.rad() / std::f64::consts::FRAC_PI_4).round();
            // The remainder is one of the eight for any heading.
            let arrow = ARROWS[eighths.rem_euclid(8.0) as usize % ARROWS.len()];
            context.print(x, y, TextLine::from(arrow).style(palette.title()));
        }
    };
    Canvas::default()
        .block(block)
        .x_bounds(x_bounds)
        .y_bounds(y_bounds)
        .paint(paint)
        .render(area, picture);
    if let Some(pose) = believed
        && inner.height > 3
    {
        let (x, y, heading) = (pose.x.m(), pose.y.m(), pose.heading.wrapped().deg());
        let text = format!("{x:.2} m, {y:.2} m, {heading:.1} deg");
        picture.set_stringn(
            inner.x,
            inner.bottom() - 1,
            text,
            usize::from(inner.width),
            palette.title(),
        );
    }
}

fn title(model: &Model) -> &'static str {
    if model.robot.truth.is_empty() {
        "robot: · ordered ⠿ driven"
    } else {
        "robot: · ordered ⠿ believed * true"
    }
}

/// The part of the floor to draw: all points, at the same scale in both directions, given the shape of a cell.
fn bounds(points: impl Iterator<Item = (f64, f64)>, inner: Rect) -> Option<[[f64; 2]; 2]> {
    let mut extent: Option<[[f64; 2]; 2]> = None;
    for (x, y) in points.filter(|(x, y)| x.is_finite() && y.is_finite()) {
        let [xs, ys] = extent.get_or_insert([[x, x], [y, y]]);
        *xs = [xs[0].min(x), xs[1].max(x)];
        *ys = [ys[0].min(y), ys[1].max(y)];
    }
    let [xs, ys] = extent?;
    if inner.is_empty() {
        return None;
    }
    let (columns, rows) = (f64::from(inner.width), f64::from(inner.height) * CELL_ASPECT);
    let padded = |ends: [f64; 2]| (ends[1] - ends[0]).max(EXTENT_MIN_M) * (1.0 + 2.0 * MARGIN);
    let m_per_column = (padded(xs) / columns).max(padded(ys) / rows);
    let around = |ends: [f64; 2], cells: f64| {
        let (middle, half) = (f64::midpoint(ends[0], ends[1]), m_per_column * cells / 2.0);
        [middle - half, middle + half]
    };
    Some([around(xs, columns), around(ys, rows)])
}
