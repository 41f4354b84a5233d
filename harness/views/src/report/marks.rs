//! Bands, bars and marks of a plot, and which marks are outside.

use super::against::Against;
use super::frame::{Chart, Drawn, Frame, SCALE};
use super::observed::{Direction, Sample};
use super::palette::{BAND, REFERENCE};
use super::phases::Phases;
use super::thin::Point;
use plan::quantities::DURING_PREFIX;
use plotters::element::{Circle, PathElement, Rectangle, TriangleMarker};
use plotters::style::{Color, ShapeStyle};
use record::figures;
use record::header::Band;

/// Radius of a mark, in CSS pixels times [`SCALE`].
const MARK_RADIUS: i32 = 3 * SCALE as i32;

pub(super) fn band_texts(bands: &[Band], unit: &str) -> Vec<String> {
    let mut texts = Vec::new();
    for band in bands {
        let ends = figures::band(band.lower, band.upper, unit);
        let mut text = format!("{}: {ends}", band.measurement);
        if let Some(paper) = &band.paper {
            text += &format!(" (paper: {paper})");
        }
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
    texts
}

/// Whether the sample is outside a band that applies to it. Bands with tags that the page does not keep never apply.
pub(super) fn is_outside(sample: &Sample, bands: &[Band], phases: &Phases) -> bool {
    bands.iter().any(|band| {
        let meant = band.tags.iter().all(|(tag, value)| match (tag.as_str(), sample.direction) {
            ("direction", Some(Direction::Cw)) => *value < 0.0,
            ("direction", Some(Direction::Ccw)) => *value > 0.0,
            (tag, _) => match tag.strip_prefix(DURING_PREFIX) {
                Some(phase) => *value == 1.0 && phases.has(sample.phases, phase),
                None => false,
            },
        });
        let inside = band.lower.is_none_or(|lower| sample.value >= lower)
            && band.upper.is_none_or(|upper| sample.value <= upper);
        meant && !inside
    })
}

/// Where a band holds on the x axis; `None`: everywhere.
pub(super) type Spans<'a> = &'a dyn Fn(&Band) -> Option<Vec<(f64, f64)>>;

/// Draws each band once where it holds, and zero if it is in range.
pub(super) fn draw_bands(
    chart: &mut Chart<'_>,
    frame: &Frame,
    bands: &[Band],
    spans: Spans<'_>,
) -> Drawn {
    let (x, y) = (&frame.x.range, &frame.y.range);
    let across = |(begin, end): (f64, f64), at: f64, style: ShapeStyle| {
        PathElement::new([(begin, at), (end, at)], style)
    };
    let mut seen = Vec::new();
    for band in bands {
        let ends = (band.lower, band.upper);
        let spans = spans(band).unwrap_or_else(|| vec![(x.start, x.end)]);
        if seen.contains(&(ends, spans.clone())) || ends == (None, None) {
            continue;
        }
        let (low, high) =
            (ends.0.unwrap_or(y.start).max(y.start), ends.1.unwrap_or(y.end).min(y.end));
        for (begin, end) in spans.iter().map(|(begin, end)| (begin.max(x.start), end.min(x.end))) {
            if begin > end {
                continue;
            }
            let corners = [(begin, low), (end, high)];
            chart.draw_series([Rectangle::new(corners, BAND.mix(0.12).filled())])?;
            // Band limits of a 64-bit signal may be far outside.
            let is_in_sight = |at: &f64| (y.start..=y.end).contains(at);
            let edges = [ends.0, ends.1].into_iter().flatten().filter(is_in_sight);
            chart
                .draw_series(edges.map(|at| across((begin, end), at, BAND.stroke_width(SCALE))))?;
        }
        seen.push((ends, spans));
    }
    if y.contains(&0.0) {
        chart.draw_series([across((x.start, x.end), 0.0, REFERENCE.stroke_width(SCALE))])?;
    }
    Ok(())
}

pub(super) fn draw_bars(chart: &mut Chart<'_>, samples: &[Sample], against: Against) -> Drawn {
    let bars = samples.iter().filter(|sample| sample.uncertainty > 0.0).map(|sample| {
        let ends = [sample.value - sample.uncertainty, sample.value + sample.uncertainty];
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
        chart.draw_series(points.into_iter().map(|at| TriangleMarker::new(at, size, style)))?;
    } else {
        chart.draw_series(points.into_iter().map(|at| Circle::new(at, MARK_RADIUS, style)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::is_outside;
    use crate::report::observed::{Direction, Sample};
    use crate::report::phases::Phases;
    use record::header::Band;
    use std::collections::BTreeMap;

    fn sample() -> Sample {
        let direction = Some(Direction::Cw);
        Sample { value: 0.3, direction, ..Sample::default() }
    }

    #[test]
    fn a_band_marks_only_what_it_means() {
        let band = |direction: Option<f64>| Band {
            lower: Some(-0.25),
            upper: Some(0.25),
            tags: direction.map(|sign| ("direction".to_owned(), sign)).into_iter().collect(),
            ..Band::default()
        };
        let cw = sample();
        let is_outside =
            |sample: &Sample, bands: &[Band]| is_outside(sample, bands, &Phases::default());
        assert!(is_outside(&cw, &[band(None)]));
        assert!(is_outside(&cw, &[band(Some(1.0)), band(Some(-1.0))]));
        assert!(!is_outside(&cw, &[band(Some(1.0))]));
        let other = Band { tags: BTreeMap::from([("speed".to_owned(), 1.0)]), ..band(None) };
        assert!(!is_outside(&cw, &[other]));
        assert!(!is_outside(&Sample { value: 0.25, ..cw }, &[band(None)]), "ends are inside");
    }

    #[test]
    fn a_band_of_a_phase_marks_only_what_was_observed_in_it() {
        let during = BTreeMap::from([("during.holding".to_owned(), 1.0)]);
        let mut phases = Phases::default();
        let holding = phases.add(1.0, &during);
        let heating = phases.add(2.0, &BTreeMap::from([("during.heating".to_owned(), 1.0)]));
        let band = Band { upper: Some(0.2), tags: during, ..Band::default() };
        let outside = |phases_of| {
            let sample = Sample { phases: phases_of, ..sample() };
            is_outside(&sample, std::slice::from_ref(&band), &phases)
        };
        assert!(outside(holding) && !outside(heating));
    }
}
