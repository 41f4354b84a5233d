//! Return positions: two quantities that belong together, as a plan of the floor.

use super::collect::{Direction, Sample, Series};
use super::frame::{Axis, Frame, SCALE};
use super::marks::draw_marks;
use super::observations::title;
use super::palette::{BAND, CCW, CW, OUTSIDE, REFERENCE};
use crate::record::header::Quantity;
use maud::{Markup, html};
use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;
use std::collections::BTreeMap;

/// The most positions that are drawn.
const POSITIONS_MAX: usize = 2_000;

/// Side of the paper's square: all but one return position of the corrected laps lie in it (Figs 7, 8).
const PAPER_SQUARE_SIDE_CM: f64 = 10.0;

const CM_PER_M: f64 = 100.0;

/// What a quantity is by its name.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Partner {
    /// An x; its y has this name.
    X(String),
    /// A y; its x has this name.
    Y(String),
    /// Neither.
    None,
}

/// `lap.return_x` belongs to `lap.return_y`.
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
}

impl Position {
    fn is_outside(&self) -> bool {
        self.x_cm.abs().max(self.y_cm.abs()) > PAPER_SQUARE_SIDE_CM / 2.0
    }
}

/// Positions from x and y of the same run and direction; without a run, of the same instant.
fn positions(x: &Series, y: &Series) -> Vec<Position> {
    let key = |sample: &Sample| {
        let number = sample.run.unwrap_or(sample.at_s);
        (number.to_bits(), sample.run.is_some(), sample.direction)
    };
    let ys: BTreeMap<_, _> = y.samples.iter().map(|sample| (key(sample), sample.value)).collect();
    let pairs = x.samples.iter().filter_map(|sample| Some((sample, ys.get(&key(sample))?)));
    pairs
        .map(|(x, y)| Position {
            x_cm: x.value * CM_PER_M,
            y_cm: y * CM_PER_M,
            direction: x.direction,
        })
        .collect()
}

/// The positions, in metres by definition of their quantities, and the paper's square.
pub(super) fn figure(name: &str, x: &Series, y: &Series, declared: Option<&Quantity>) -> Markup {
    let mut all = positions(x, y);
    let outside = all.iter().filter(|position| position.is_outside()).count();
    let paired = all.len();
    // Those outside matter most when not all can be drawn.
    all.sort_by_key(|position| !position.is_outside());
    all.truncate(POSITIONS_MAX);
    let half = PAPER_SQUARE_SIDE_CM / 2.0;
    let frame = Frame::square(
        Axis::around("x in cm", all.iter().map(|p| p.x_cm).chain([-half, half])),
        Axis::around("y in cm", all.iter().map(|p| p.y_cm).chain([-half, half])),
    );
    let plot = frame.plot("return positions", |chart| {
        let square = [(-half, -half), (half, half)];
        chart.draw_series([Rectangle::new(square, BAND.mix(0.12).filled())])?;
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half), (-half, -half)];
        chart.draw_series([PathElement::new(corners, BAND.stroke_width(SCALE))])?;
        let (xs, ys) = (&frame.x.range, &frame.y.range);
        let cross = [[(xs.start, 0.0), (xs.end, 0.0)], [(0.0, ys.start), (0.0, ys.end)]];
        let style = REFERENCE.stroke_width(SCALE / 2);
        chart.draw_series(cross.map(|line| PathElement::new(line, style)))?;
        for direction in [None, Some(Direction::Ccw), Some(Direction::Cw)] {
            let colour = if direction == Some(Direction::Cw) { CW } else { CCW };
            for (is_outside, colour) in [(false, colour), (true, OUTSIDE)] {
                let marks = all
                    .iter()
                    .filter(|p| p.direction == direction && p.is_outside() == is_outside)
                    .map(|p| (p.x_cm, p.y_cm))
                    .collect();
                draw_marks(chart, marks, direction, colour.filled())?;
            }
        }
        Ok(())
    });
    let unpaired = x.samples.len().max(y.samples.len()) - paired.min(x.samples.len());
    html! {
        figure {
            h3 { (title(name, declared)) ", with y: return positions" }
            (plot)
            figcaption {
                p.legend {
                    span { i.mark.ccw { "●" } "ccw" }
                    span { i.mark.cw { "▲" } "cw" }
                    @if outside > 0 { span { i.mark.outside { "■" } (outside) " outside" } }
                    span { i.swatch {} "the paper's 10 x 10 cm square (all but one inside, Figs 7, 8)" }
                }
                p {
                    (paired) " positions"
                    @if all.len() < paired { "; " (all.len()) " drawn, those outside first" }
                    "."
                    @if unpaired > 0 { " " (unpaired) " observations have no partner." }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Partner, partner, positions};
    use crate::report::collect::{Direction, Sample, Series};

    fn series(samples: &[(f64, f64, Direction)]) -> Series {
        let sample = |&(run, value, direction): &(f64, f64, Direction)| Sample {
            at_s: 0.0,
            value,
            uncertainty: 0.0,
            direction: Some(direction),
            run: Some(run),
            temperature: None,
        };
        Series { samples: samples.iter().map(sample).collect(), ..Series::default() }
    }

    #[test]
    fn x_finds_the_y_of_its_run_and_direction() {
        use Direction::{Ccw, Cw};
        let x = series(&[(1.0, 0.01, Cw), (1.0, 0.02, Ccw), (2.0, 0.03, Cw)]);
        let y = series(&[(1.0, -0.02, Ccw), (1.0, -0.01, Cw), (3.0, -0.04, Cw)]);
        let found: Vec<_> = positions(&x, &y).iter().map(|p| (p.x_cm, p.y_cm)).collect();
        assert_eq!(found, [(1.0, -1.0), (2.0, -2.0)]);
    }

    #[test]
    fn names_tell_who_belongs_together() {
        assert_eq!(partner("lap.return_x"), Partner::X("lap.return_y".into()));
        assert_eq!(partner("lap.return_y"), Partner::Y("lap.return_x".into()));
        assert_eq!(partner("lap.return_heading"), Partner::None);
    }
}
