//! Return positions: pairs of quantities, as a plan of the floor.

use super::download::{ROWS_MAX, Table, number, place};
use super::frame::{Axis, Frame, SCALE};
use super::group::Look;
use super::listed::counted;
use super::marks::draw_marks;
use super::median::median_of;
use super::observed::{Direction, Sample};
use super::palette::{INK, OUTSIDE, PAPER, REFERENCE};
use super::panel::{DASH, dashed};
use super::thin::Point;
use maud::{Markup, html};
use plotters::element::{Circle, Cross, PathElement};
use plotters::style::Color;
use std::collections::BTreeMap;

const POSITIONS_MAX: usize = 2_000;

/// Radius of the ring around a position outside the square, in pixels of the drawing.
const RING_RADIUS: i32 = 6 * SCALE as i32;

/// Half the size of the cross of a median, in pixels of the drawing.
const MEDIAN_RADIUS: i32 = 7 * SCALE as i32;

/// Side of the paper's square, which contains all return positions of corrected laps but one (Fig. 8).
const PAPER_SQUARE_SIDE_CM: f64 = 10.0;

const CM_PER_M: f64 = 100.0;

#[derive(Debug, PartialEq, Eq)]
pub(super) enum Partner {
    /// An x coordinate; its y has this name.
    X(String),
    /// A y coordinate; its x has this name.
    Y(String),
    None,
}

/// Pairs `lap.return_x` with `lap.return_y`.
pub(super) fn partner(name: &str) -> Partner {
    match (name.strip_suffix("return_x"), name.strip_suffix("return_y")) {
        (Some(stem), _) => Partner::X(format!("{stem}return_y")),
        (_, Some(stem)) => Partner::Y(format!("{stem}return_x")),
        _ => Partner::None,
    }
}

struct Position {
    x_cm: f64,
    y_cm: f64,
    direction: Option<Direction>,
    run: Option<f64>,
}

impl Position {
    fn is_outside(&self) -> bool {
        self.x_cm.abs().max(self.y_cm.abs()) > PAPER_SQUARE_SIDE_CM / 2.0
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Positions<'a> {
    pub x: &'a [Sample],
    pub y: &'a [Sample],
}

impl Positions<'_> {
    /// Pairs x and y of the same run and direction; without a run, of the same instant.
    fn paired(self) -> Vec<Position> {
        let key = |sample: &Sample| {
            let number = sample.run.unwrap_or(sample.at_s);
            (number.to_bits(), sample.run.is_some(), sample.direction)
        };
        let ys: BTreeMap<_, _> = self.y.iter().map(|sample| (key(sample), sample.value)).collect();
        let pairs = self.x.iter().filter_map(|sample| Some((sample, ys.get(&key(sample))?)));
        pairs
            .map(|(x, y)| Position {
                x_cm: x.value * CM_PER_M,
                y_cm: y * CM_PER_M,
                direction: x.direction,
                run: x.run,
            })
            .collect()
    }

    /// Draws the positions, in metres by definition of their quantities, and the paper's square, which `square`
    /// explains; `None` if there are no positions.
    pub(super) fn figure(self, title: &str, square: &str, file: &str) -> Option<Markup> {
        if self.x.is_empty() {
            return None;
        }
        let mut all = self.paired();
        let medians = medians(&all);
        let outside = all.iter().filter(|position| position.is_outside()).count();
        let paired = all.len();
        // If not all can be drawn, those outside matter most.
        all.sort_by_key(|position| !position.is_outside());
        all.truncate(POSITIONS_MAX);
        let plot = plot(&all, &medians, title);
        let unpaired = self.x.len().max(self.y.len()) - paired.min(self.x.len());
        Some(html! {
            figure {
                h3 { (title) }
                (plot)
                figcaption {
                    p.legend {
                        @for (direction, look) in DIRECTIONS {
                            @if all.iter().any(|position| position.direction == direction) { (look.mark()) }
                        }
                        @if outside > 0 { span { i.mark.outside { "◯" } (outside) " outside" } }
                        @for (direction, (x, y)) in &medians {
                            span {
                                i.mark.plain { "✕" }
                                "median " (direction.map_or("", Direction::name)) " "
                                (format!("{x:.1}, {y:.1} cm"))
                            }
                        }
                        span { i.line.paper {} (square) }
                    }
                    p {
                        (counted(paired, "position", all.len(), "those outside first")) "."
                        @if unpaired > 0 { " " (unpaired) " observations have no partner." }
                        " " (table(&all).without(paired - all.len()).link(file))
                    }
                }
            }
        })
    }
}

const DIRECTIONS: [(Option<Direction>, Look); 3] = [
    (None, Look::Plain),
    (Some(Direction::Ccw), Look::Disc),
    (Some(Direction::Cw), Look::Triangle),
];

fn medians(all: &[Position]) -> Vec<(Option<Direction>, Point)> {
    let of = |direction, read: fn(&Position) -> f64| {
        median_of(all.iter().filter(|one| one.direction == direction).map(read))
    };
    let both = |(direction, _)| {
        Some((direction, (of(direction, |one| one.x_cm)?, of(direction, |one| one.y_cm)?)))
    };
    DIRECTIONS.into_iter().filter_map(both).collect()
}

fn plot(all: &[Position], medians: &[(Option<Direction>, Point)], title: &str) -> Markup {
    let half = PAPER_SQUARE_SIDE_CM / 2.0;
    let frame = Frame::square(
        Axis::around("x in cm", all.iter().map(|p| p.x_cm).chain([-half, half])),
        Axis::around("y in cm", all.iter().map(|p| p.y_cm).chain([-half, half])),
    );
    frame.plot(title, |chart| {
        let (xs, ys) = (&frame.x.range, &frame.y.range);
        let cross = [[(xs.start, 0.0), (xs.end, 0.0)], [(0.0, ys.start), (0.0, ys.end)]];
        let style = REFERENCE.stroke_width(SCALE / 2);
        chart.draw_series(cross.map(|line| PathElement::new(line, style)))?;
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half), (-half, -half)];
        for side in corners.windows(2) {
            dashed(chart, side, DASH, PAPER)?;
        }
        for (direction, look) in DIRECTIONS {
            let marks = all.iter().filter(|p| p.direction == direction);
            let marks = marks.map(|p| (p.x_cm, p.y_cm)).collect();
            draw_marks(chart, marks, direction, look.colour().filled())?;
        }
        let ring = OUTSIDE.stroke_width(SCALE);
        let outside = all.iter().filter(|position| position.is_outside());
        chart.draw_series(outside.map(|p| Circle::new((p.x_cm, p.y_cm), RING_RADIUS, ring)))?;
        let style = INK.stroke_width(2 * SCALE);
        chart.draw_series(medians.iter().map(|(_, at)| Cross::new(*at, MEDIAN_RADIUS, style)))?;
        Ok(())
    })
}

fn table(all: &[Position]) -> Table {
    let mut table = Table::new(["run", "direction", "x_cm", "y_cm"]);
    for one in all.iter().take(ROWS_MAX) {
        table.row([
            one.run.map_or_else(String::new, place),
            one.direction.map_or("", Direction::name).to_owned(),
            number(one.x_cm),
            number(one.y_cm),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{Partner, Positions, medians, partner};
    use crate::report::observed::{Direction, Sample};

    fn series(samples: &[(f64, f64, Direction)]) -> Vec<Sample> {
        let sample = |&(run, value, direction): &(f64, f64, Direction)| Sample {
            value,
            direction: Some(direction),
            run: Some(run),
            ..Sample::default()
        };
        samples.iter().map(sample).collect()
    }

    #[test]
    fn x_finds_the_y_of_its_run_and_direction() {
        use Direction::{Ccw, Cw};
        let x = series(&[(1.0, 0.01, Cw), (1.0, 0.02, Ccw), (2.0, 0.03, Cw)]);
        let y = series(&[(1.0, -0.02, Ccw), (1.0, -0.01, Cw), (3.0, -0.04, Cw)]);
        let all = Positions { x: &x, y: &y }.paired();
        let found: Vec<_> = all.iter().map(|p| (p.x_cm, p.y_cm)).collect();
        assert_eq!(found, [(1.0, -1.0), (2.0, -2.0)]);
        assert_eq!(medians(&all), [(Some(Ccw), (2.0, -2.0)), (Some(Cw), (1.0, -1.0))]);
    }

    #[test]
    fn names_tell_who_belongs_together() {
        assert_eq!(partner("lap.return_x"), Partner::X("lap.return_y".into()));
        assert_eq!(partner("lap.return_y"), Partner::Y("lap.return_x".into()));
        assert_eq!(partner("lap.return_heading"), Partner::None);
    }
}
