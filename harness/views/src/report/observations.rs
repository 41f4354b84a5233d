//! A plot for each quantity: its observations over their natural axis, and its bands.

use super::against::Against;
use super::collect::Collected;
use super::download;
use super::frame::{Axis, Frame, SCALE};
use super::group::by_direction;
use super::listed::{LOWEST_AND_HIGHEST, counted};
use super::marks::{band_texts, draw_bands, draw_bars, draw_marks, is_outside};
use super::observed::{Direction, Sample, Series};
use super::palette::{CCW, CW, OUTSIDE};
use super::paper::Figures;
use super::scatter::{self, Partner, Positions};
use super::stimuli;
use super::thin::{Point, extremes};
use maud::{Markup, html};
use plan::quantities;
use plotters::element::PathElement;
use plotters::style::Color;
use record::figures;
use record::header::{Band, Header, Quantity};

/// Maximum number of plots on a page: with the marks of each bounded, so is the page.
const PLOTS_MAX: usize = 40;

/// Columns of a plot of marks, and of a line; two points per column are drawn.
const MARK_COLUMNS: usize = 280;
const LINE_COLUMNS: usize = 600;

/// More samples over time are a log, drawn as a line.
const MARKS_OVER_TIME_MAX: usize = 150;

/// More samples are drawn without bars.
const BARS_MAX: usize = 120;

/// Explains the square in a plot that is not one of the paper's.
const SQUARE_TEXT: &str = "the paper's square of 10 x 10 cm (Fig. 8)";

/// Plots all observations that no figure of the paper shows.
pub(super) fn plots(header: &Header, collected: &Collected, paper: &Figures) -> Option<Markup> {
    let all = &collected.series;
    let mut figures: Vec<Markup> = Vec::new();
    let mut left_out = 0_usize;
    for (name, series) in all.iter().filter(|(name, _)| !paper.show(name)) {
        let pair = match scatter::partner(name) {
            Partner::X(y) => all.get(&y),
            Partner::Y(x) if all.contains_key(&x) => continue,
            Partner::Y(_) | Partner::None => None,
        };
        if figures.len() >= PLOTS_MAX {
            left_out += 1;
            continue;
        }
        figures.push(match pair {
            Some(y) => {
                let both = Positions { x: &series.samples, y: &y.samples };
                let title = format!("{name}, with y: return positions");
                match both.figure(&title, SQUARE_TEXT, name) {
                    Some(figure) => figure,
                    None => continue,
                }
            }
            None => figure(name, series, declared(header, name).as_ref(), collected),
        });
    }
    if figures.is_empty() && !paper.is_empty() {
        return None;
    }
    Some(html! {
        @if figures.is_empty() {
            p.missing { "Nothing was observed." }
        }
        div.plots { @for figure in figures { (figure) } }
        @if left_out > 0 {
            p.missing { "At most " (PLOTS_MAX) " plots are drawn; " (left_out) " more quantities are in the record." }
        }
        @if collected.series_overflowed > 0 {
            p.missing { (collected.series_overflowed) " observations of yet more quantities were not kept." }
        }
    })
}

/// A quantity as the plan declares it, or as it is known where the plan does not judge it.
pub(super) fn declared(header: &Header, name: &str) -> Option<Quantity> {
    let declared = header.quantities.iter().find(|quantity| quantity.name == name).cloned();
    declared.or_else(|| {
        let found = quantities::find(name)?;
        let (unit, title) = (found.unit.to_owned(), found.doc.to_owned());
        Some(Quantity { name: name.to_owned(), unit, title, ..Quantity::default() })
    })
}

fn figure(
    name: &str,
    series: &Series,
    declared: Option<&Quantity>,
    collected: &Collected,
) -> Markup {
    let samples = &series.samples;
    let phases = &collected.phases;
    let unit = declared.map_or("", |quantity| &quantity.unit);
    let bands = declared.map_or(&[][..], |quantity| &quantity.bands);
    let against = Against::of(samples);
    let is_log = matches!(against, Against::Time { .. }) && samples.len() > MARKS_OVER_TIME_MAX;
    let has_bars = samples.len() <= BARS_MAX;
    let reach = |sample: &Sample| {
        let bar = if has_bars { sample.uncertainty } else { 0.0 };
        [sample.value - bar, sample.value + bar]
    };
    let ends = bands.iter().flat_map(|band| [band.lower, band.upper]).flatten();
    let frame = Frame::wide(
        Axis::around(against.label(), samples.iter().map(|sample| against.x(sample))),
        Axis::around(figures::axis_label(name, unit), samples.iter().flat_map(reach).chain(ends)),
    );
    let mut drawn = 0;
    let plot = frame.plot(name, |chart| {
        draw_bands(chart, &frame, bands, &|band| phases.spans(band, against))?;
        stimuli::draw(chart, &frame, against, collected)?;
        if has_bars {
            draw_bars(chart, samples, against)?;
        }
        for (direction, style) in
            [(None, CCW), (Some(Direction::Ccw), CCW), (Some(Direction::Cw), CW)]
        {
            let points = |keep: &dyn Fn(&Sample) -> bool| -> Vec<Point> {
                let kept = samples.iter().filter(|s| s.direction == direction && keep(s));
                kept.map(|sample| (against.x(sample), sample.value)).collect()
            };
            if is_log {
                let line = extremes(&points(&|_| true), LINE_COLUMNS);
                drawn += line.len();
                chart.draw_series([PathElement::new(line, style.stroke_width(SCALE))])?;
                continue;
            }
            let inside = extremes(&points(&|s| !is_outside(s, bands, phases)), MARK_COLUMNS);
            let outside = extremes(&points(&|s| is_outside(s, bands, phases)), MARK_COLUMNS);
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
            (caption((name, series), (bands, unit), drawn, (against, is_log), collected))
        }
    }
}

pub(super) fn title(name: &str, declared: Option<&Quantity>) -> Markup {
    let title = declared.map_or("", |quantity| quantity.title.as_str());
    html! { code { (name) } @if !title.is_empty() { " " (title) } }
}

fn caption(
    (name, series): (&str, &Series),
    (bands, unit): (&[Band], &str),
    drawn: usize,
    (against, is_log): (Against, bool),
    collected: &Collected,
) -> Markup {
    let samples = &series.samples;
    let has = |direction| samples.iter().any(|sample| sample.direction == Some(direction));
    let has_bars =
        samples.len() <= BARS_MAX && samples.iter().any(|sample| sample.uncertainty > 0.0);
    let outside =
        samples.iter().filter(|sample| is_outside(sample, bands, &collected.phases)).count();
    html! {
        figcaption {
            p.legend {
                @if has(Direction::Ccw) { span { i.mark.ccw { "●" } "ccw" } }
                @if has(Direction::Cw) { span { i.mark.cw { "▲" } "cw" } }
                @if outside > 0 && !is_log { span { i.mark.outside { "■" } (outside) " outside" } }
                @for band in band_texts(bands, unit) { span { i.swatch {} (band) } }
                (stimuli::legend(against, collected, 0.0..=collected.end_s))
            }
            p {
                (counted(samples.len(), "observation", drawn, LOWEST_AND_HIGHEST))
                @if has_bars { "; bars are standard uncertainties" }
                "."
                @if !samples.is_empty() { " " (download::samples(&by_direction(samples), unit).link(name)) }
                @if series.not_numbers > 0 { " " (series.not_numbers) " were no numbers." }
                @if series.overflowed > 0 { " " (series.overflowed) " later ones were not kept." }
            }
        }
    }
}
