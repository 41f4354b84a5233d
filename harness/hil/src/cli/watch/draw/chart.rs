//! Charts of values over bench time.

use super::{Look, PANEL_MIN, Panel, frame};
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Widget};
use record::figures;
use views::watch::{Gauge, Model, Series};

/// Space above and below the values, as a share of their extent.
const MARGIN: f64 = 0.1;
/// Space around a constant value, as a share of it.
const FLAT_SHARE: f64 = 0.1;
/// Minimum space around a constant value, in its unit.
const FLAT_MIN: f64 = 0.01;
/// The chart includes a limit of the band only if it widens the range to at most this multiple of the values' extent.
const BAND_EXTENT_MAX: f64 = 20.0;
/// Below this height a chart has no space for axes.
const CHART_ROWS_MIN: u16 = 4;

struct Curve<'a> {
    name: &'a str,
    series: &'a Series,
    colour: Color,
    marker: Marker,
}

/// Quantities whose band is drawn in the chart of the heading error, in order of preference.
const HEADING_QUANTITIES: [&str; 4] = [
    "straight.heading_error_max",
    "straight.heading_error",
    "lap.gyro_error",
    "lap.return_heading",
];

/// Draws the heading error of a driving robot against the plan's band; else the first measured quantity.
pub(super) fn heading(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let robot = &model.robot;
    let errors = robot.heading_error.count() + robot.true_error.count();
    if !robot.drives() || errors == 0 {
        return measured(model, look, area, picture);
    }
    let palette = look.palette;
    let gauge = HEADING_QUANTITIES
        .iter()
        .find_map(|name| model.gauges.iter().find(|gauge| gauge.quantity.name == *name));
    let band = gauge.and_then(|gauge| Some((gauge.quantity.name.as_str(), gauge.band()?)));
    let ends = band.map_or((None, None), |(_, band)| (band.lower, band.upper));
    let mut title = "heading error, deg".to_owned();
    if let Some((name, _)) = band {
        title += &format!(", band {} ({name})", figures::band(ends.0, ends.1, ""));
    }
    let curves = [
        Curve {
            name: "of the loop",
            series: &robot.heading_error,
            colour: palette.believed(),
            marker: Marker::Dot,
        },
        Curve {
            name: "true",
            series: &robot.true_error,
            colour: palette.truth(),
            marker: Marker::Braille,
        },
    ];
    draw(&curves, ends, model, look, frame(Panel::Heading, &title, look), area, picture);
}

/// Draws measured quantities one below the other, as many as fit: those with the most values, in the order of the plan.
fn measured(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    if model.gauges.is_empty() {
        let block = frame(Panel::Heading, "measured", look);
        return Paragraph::new("the plan measures nothing").block(block).render(area, picture);
    }
    let room = usize::from(area.height / PANEL_MIN).max(1);
    let mut often: Vec<(usize, &Gauge)> = model.gauges.iter().enumerate().collect();
    // The sort is stable.
    often.sort_by_key(|(_, gauge)| std::cmp::Reverse(gauge.series.count()));
    often.retain(|(index, gauge)| *index == 0 || gauge.series.count() > 1);
    often.truncate(room);
    often.sort_by_key(|(index, _)| *index);
    let places = Layout::vertical(vec![Constraint::Fill(1); often.len()]).split(area);
    for ((_, gauge), place) in often.iter().zip(places.iter()) {
        one(gauge, model, look, *place, picture);
    }
}

/// Draws one quantity against its band.
fn one(gauge: &Gauge, model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let quantity = &gauge.quantity;
    let ends = gauge.band().map_or((None, None), |band| (band.lower, band.upper));
    let name = figures::axis_label(&quantity.name, &quantity.unit);
    let title = format!("{name}, band {}", figures::band(ends.0, ends.1, ""));
    let colour = look.palette.believed();
    let curves = [Curve { name: "", series: &gauge.series, colour, marker: Marker::Dot }];
    draw(&curves, ends, model, look, frame(Panel::Heading, &title, look), area, picture);
}

/// Draws rate and temperature of the gyro, one above the other.
pub(super) fn gyro(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let robot = &model.robot;
    let figure = |series: &Series| series.last().map(|(_, value)| value);
    let rate = figure(&robot.rate).map_or_else(|| "-".to_owned(), |rate| format!("{rate:.4}"));
    let title = match figure(&robot.temperature) {
        Some(celsius) => format!("gyro: rate {rate} deg/s, {celsius:.2} degC"),
        None => format!("gyro: rate {rate} deg/s"),
    };
    let block = frame(Panel::Gyro, &title, look);
    let inner = block.inner(area);
    block.render(area, picture);
    let palette = look.palette;
    let rate = [Curve {
        name: "",
        series: &robot.rate,
        colour: palette.believed(),
        marker: Marker::Braille,
    }];
    let celsius = [Curve {
        name: "",
        series: &robot.temperature,
        colour: palette.truth(),
        marker: Marker::Dot,
    }];
    let none = (None, None);
    if robot.temperature.count() == 0 || inner.height < 2 * CHART_ROWS_MIN {
        return draw(&rate, none, model, look, Block::new(), inner, picture);
    }
    let halves = Layout::vertical([Constraint::Fill(1), Constraint::Fill(1)]);
    let [upper, lower] = halves.areas(inner);
    draw(&rate, none, model, look, Block::new(), upper, picture);
    draw(&celsius, none, model, look, Block::new(), lower, picture);
}

fn draw(
    curves: &[Curve<'_>],
    band: (Option<f64>, Option<f64>),
    model: &Model,
    look: &Look,
    block: Block<'_>,
    area: Rect,
    picture: &mut Buffer,
) {
    let until_s = model.now.as_secs_f64();
    let from_s = (until_s - look.window_s()).max(0.0);
    let points: Vec<Vec<(f64, f64)>> =
        curves.iter().map(|curve| curve.series.since(from_s)).collect();
    let Some((least, most)) = extent(points.iter().flatten().map(|(_, value)| *value)) else {
        return Paragraph::new("nothing in this window").block(block).render(area, picture);
    };
    let (bottom, top) = with_band(least, most, band);
    let lines: Vec<[(f64, f64); 2]> = [band.0, band.1]
        .into_iter()
        .flatten()
        .filter(|end| (bottom..=top).contains(end))
        .map(|end| [(from_s, end), (until_s, end)])
        .collect();
    let mut datasets: Vec<Dataset<'_>> = lines
        .iter()
        .map(|line| {
            Dataset::default()
                .data(line)
                .graph_type(GraphType::Line)
                .marker(Marker::Dot)
                .style(Style::new().fg(look.palette.band()))
        })
        .collect();
    let several = curves.iter().filter(|curve| curve.series.count() > 0).count() > 1;
    for (curve, points) in curves.iter().zip(&points) {
        let dataset = Dataset::default()
            .data(points)
            .graph_type(GraphType::Scatter)
            .marker(curve.marker)
            .style(Style::new().fg(curve.colour));
        datasets.push(if several { dataset.name(curve.name) } else { dataset });
    }
    let digits = axis_digits(bottom, top);
    let label = |value: f64| Line::from(figures::exact(value, digits));
    let until_s = until_s.max(from_s + 1.0);
    Chart::new(datasets)
        .block(block)
        .hidden_legend_constraints((Constraint::Ratio(1, 2), Constraint::Ratio(1, 2)))
        .x_axis(
            Axis::default()
                .bounds([from_s, until_s])
                .labels(times(from_s, until_s).map(Line::from)),
        )
        .y_axis(Axis::default().bounds([bottom, top]).labels([label(bottom), label(top)]))
        .render(area, picture);
}

/// Digits that tell the ends of an axis apart: two of the distance between them, and three at least.
fn axis_digits(bottom: f64, top: f64) -> i32 {
    let decade = |value: f64| value.log10().floor() as i32;
    (decade(bottom.abs().max(top.abs())) - decade(top - bottom)).clamp(1, 12) + 2
}

/// The ends of the axis of time. Late in a run both can be the same minute.
fn times(from_s: f64, until_s: f64) -> [String; 2] {
    let (from, until) = (figures::duration(from_s), figures::duration(until_s));
    match from == until {
        true => [format!("{} earlier", figures::duration(until_s - from_s)), until],
        false => [from, until],
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |extent, value| {
        Some(extent.map_or((value, value), |(least, most): (f64, f64)| {
            (least.min(value), most.max(value))
        }))
    })
}

/// The range of the values with some space, and the limits of the band unless they would flatten the curve.
fn with_band(least: f64, most: f64, band: (Option<f64>, Option<f64>)) -> (f64, f64) {
    let flat = (FLAT_SHARE * most.abs()).max(FLAT_MIN);
    let spread = if most > least { most - least } else { flat };
    let near = |end: f64| {
        let widened = most.max(end) - least.min(end);
        widened <= BAND_EXTENT_MAX * spread
    };
    let ends = [band.0, band.1].into_iter().flatten().filter(|end| near(*end));
    let (least, most) =
        ends.fold((least, most), |(least, most), end| (least.min(end), most.max(end)));
    let room = if most > least { MARGIN * (most - least) } else { flat };
    (least - room, most + room)
}

#[cfg(test)]
mod tests {
    use super::{axis_digits, times, with_band};
    use record::figures;

    #[test]
    fn a_band_is_drawn_unless_it_makes_the_values_a_flat_line() {
        let (bottom, top) = with_band(-0.2, 0.2, (Some(-1.0), Some(1.0)));
        assert!(bottom < -1.0 && top > 1.0);
        let (bottom, top) = with_band(-0.01, 0.01, (Some(-50.0), Some(50.0)));
        assert!(bottom > -1.0 && top < 1.0);
        let (bottom, top) = with_band(3.0, 3.0, (None, None));
        assert!(bottom < 3.0 && top > 3.0, "one value has a place, too");
    }

    #[test]
    fn the_ends_of_an_axis_are_told_apart() {
        let ends = |bottom, top| {
            let digits = axis_digits(bottom, top);
            [bottom, top].map(|end| figures::exact(end, digits))
        };
        assert_eq!(ends(-4.368, 1.4912), ["-4.37", "1.49"]);
        assert_eq!(ends(1000.014, 1000.0312), ["1000.014", "1000.031"]);
        assert_eq!(ends(59.98, 60.02), ["59.98", "60.02"]);
        assert_eq!(times(0.0, 42.0), ["0.0 s", "42.0 s"]);
        assert_eq!(times(7_812.0, 7_822.0), ["10.0 s earlier", "2 h 10 min"]);
    }
}
