//! What failed, before everything else: each failed measurement with a sentence, and its figure around the moment; each
//! property that broke with a sentence.

use super::against::Against;
use super::collect::Collected;
use super::frame::{Axis, Frame, SCALE};
use super::marks::{draw_bands, is_outside};
use super::observed::Sample;
use super::palette::{CCW, OUTSIDE};
use super::properties;
use super::stimuli;
use super::thin::Point;
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use record::figures;
use record::header::{Band, Header, Quantity};
use record::outcome::{Measurement, PropertySummary, Summary, Verdict};
use std::slice;

const FIGURES_MAX: usize = 6;

/// Number of observations that are drawn before and after the first one outside.
const AROUND: usize = 40;

/// Renders a card for each failed measurement with a band for single observations, and for each property that broke;
/// `None` without any.
pub(super) fn figures(summary: &Summary, header: &Header, collected: &Collected) -> Option<Markup> {
    let failed = summary.measurements.iter().filter(|one| one.verdict == Verdict::Fail);
    let broken = summary.properties.iter().filter(|one| one.is_broken());
    let cards: Vec<Markup> = failed
        .filter_map(|measurement| figure(measurement, header, collected))
        .chain(broken.map(|property| card(property, collected)))
        .take(FIGURES_MAX)
        .collect();
    (!cards.is_empty()).then(|| html! { div.plots { @for card in cards { (card) } } })
}

fn figure(measurement: &Measurement, header: &Header, collected: &Collected) -> Option<Markup> {
    let is_it = |band: &&Band| band.measurement == measurement.name;
    let (quantity, band) = header
        .quantities
        .iter()
        .find_map(|quantity| Some((quantity, quantity.bands.iter().find(is_it)?)))?;
    let samples = collected.samples(&quantity.name);
    let outside = |sample: &Sample| is_outside(sample, slice::from_ref(band), &collected.phases);
    let first = samples.iter().position(outside)?;
    let near = &samples[first.saturating_sub(AROUND)..(first + AROUND + 1).min(samples.len())];
    let shown_s = near.first()?.at_s..=near.last()?.at_s;
    let plot = plot(measurement, quantity, band, near, collected, &outside);
    Some(html! {
        figure.broken {
            h3 { (measurement.name) }
            p { (sentence(&samples[first], measurement, quantity, collected)) }
            (plot)
            figcaption {
                p.legend {
                    span { i.mark.outside { "■" } (samples.iter().filter(|one| outside(one)).count()) " outside" }
                    span {
                        i.swatch {} (figures::band(band.lower, band.upper, &quantity.unit))
                    }
                    (stimuli::legend(Against::time(near), collected, shown_s))
                }
            }
        }
    })
}

/// A property that broke, or never came about.
fn card(broken: &PropertySummary, collected: &Collected) -> Markup {
    let told = match (broken.broken_s, &broken.what) {
        (Some(at_s), Some(what)) => format!("{}: {what}", moment(at_s, collected)),
        _ => properties::result(broken),
    };
    html! { figure.broken { h3 { (broken.name) } p { (told) "." } } }
}

/// When, and in which step.
fn moment(at_s: f64, collected: &Collected) -> String {
    let step = collected.steps.at(at_s);
    let step = step.map_or_else(String::new, |step| format!(", in the step {}", step.name()));
    format!("At {at_s:.3} s{step}")
}

/// Says when, in which step, and how far it was outside first.
fn sentence(
    sample: &Sample,
    measurement: &Measurement,
    quantity: &Quantity,
    collected: &Collected,
) -> String {
    let Measurement { lower, upper, .. } = measurement;
    let unit = &quantity.unit;
    let value = |limit| figures::quantity_beside(sample.value, sample.uncertainty, unit, [limit]);
    let (value, limit) = match (lower, upper) {
        (Some(lower), _) if sample.value < *lower => {
            (value(*lower), format!("below {}", figures::limit(*lower, unit)))
        }
        (_, Some(upper)) if sample.value > *upper => {
            (value(*upper), format!("above {}", figures::limit(*upper, unit)))
        }
        _ => {
            let value = figures::quantity(sample.value, sample.uncertainty, unit);
            (value, "outside its band".to_owned())
        }
    };
    format!("{}, {} was {value}, {limit}.", moment(sample.at_s, collected), quantity.name)
}

fn plot(
    measurement: &Measurement,
    quantity: &Quantity,
    band: &Band,
    near: &[Sample],
    collected: &Collected,
    outside: &dyn Fn(&Sample) -> bool,
) -> Markup {
    let against = Against::time(near);
    let point = |sample: &Sample| -> Point { (against.x(sample), sample.value) };
    let ends = [band.lower, band.upper].into_iter().flatten();
    let frame = Frame::wide(
        Axis::around(against.label(), near.iter().map(|sample| against.x(sample))),
        Axis::around(
            figures::axis_label(&quantity.name, &quantity.unit),
            near.iter().map(|sample| sample.value).chain(ends),
        ),
    );
    frame.plot(&measurement.name, |chart| {
        let bands = slice::from_ref(band);
        draw_bands(chart, &frame, bands, &|band| collected.phases.spans(band, against))?;
        stimuli::draw(chart, &frame, against, collected)?;
        let line: Vec<Point> = near.iter().map(point).collect();
        chart.draw_series([PathElement::new(line, CCW.stroke_width(SCALE))])?;
        let radius = 3 * SCALE as i32;
        let marks = near.iter().map(|sample| {
            let colour = if outside(sample) { OUTSIDE } else { CCW };
            Circle::new(point(sample), radius, colour.filled())
        });
        chart.draw_series(marks)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::figures;
    use crate::report::collect::Collected;
    use record::header::{Band, Header, Quantity, StepNote};
    use record::outcome::samples::{measurement, properties, summary};
    use record::outcome::{Summary, Verdict};
    use record::samples::{observation, record};
    use record::{Device, Record, RecordKind};
    use std::collections::BTreeMap;

    /// A value that rises through the band's end at 6 s, while it is to be held from 3 s on.
    fn records() -> Vec<Record> {
        let step = |at_s: f64, path: &str, title: Option<&str>| {
            let path = path.to_owned();
            let kind = match title {
                Some(title) => RecordKind::StepBegan { path, title: title.to_owned() },
                None => RecordKind::StepEnded { path },
            };
            record(at_s, Device::Plan, kind)
        };
        let mut all = vec![
            step(0.0, "steps[0]", Some("send Command with Setpoint = 60")),
            step(0.0, "steps[0]", None),
            step(0.0, "steps[1]", Some("wait 3 s")),
        ];
        for tenth in 1..100 {
            let at_s = f64::from(tenth) / 10.0;
            if tenth == 30 {
                all.extend([step(3.0, "steps[1]", None), step(3.0, "steps[2]", Some("wait 7 s"))]);
            }
            let tag = if tenth < 30 { "during.heating" } else { "during.holding" };
            let value = if tenth < 30 { 90.0 } else { at_s * 10.0 };
            all.push(record(at_s, Device::Device, observation("signal.T", value, &[(tag, 1.0)])));
        }
        all
    }

    fn header() -> Header {
        let note = |label: Option<&str>, acts| StepNote { label: label.map(str::to_owned), acts };
        let band = Band {
            measurement: "held".to_owned(),
            upper: Some(60.0),
            tags: BTreeMap::from([("during.holding".to_owned(), 1.0)]),
            ..Band::default()
        };
        let quantity = Quantity {
            name: "signal.T".to_owned(),
            unit: "degC".to_owned(),
            bands: vec![band],
            ..Quantity::default()
        };
        let steps = [("steps[0]", note(None, true)), ("steps[2]", note(Some("holding"), false))];
        let steps = steps.map(|(place, note)| (place.to_owned(), note)).into();
        Header { quantities: vec![quantity], steps, ..Header::default() }
    }

    #[test]
    fn a_failure_is_shown_where_it_begins() {
        let mut held = measurement("held", 99.0, Verdict::Fail);
        (held.lower, held.upper) = (None, Some(60.0));
        let passed = measurement("held", 50.0, Verdict::Pass);
        let of = |measurement| Summary { measurements: vec![measurement], ..summary() };
        let collected = Collected::of(&header(), records().into_iter().map(Ok));
        assert!(figures(&of(passed), &header(), &collected).is_none());
        let page = figures(&of(held), &header(), &collected).unwrap().into_string();
        assert!(
            page.contains(
                "At 6.100 s, in the step holding, signal.T was 61.00 ± 0.20 degC, above 60 degC."
            ),
            "{page}"
        );
        assert!(page.contains("39 outside") && page.contains("at most 60 degC"), "{page}");
        assert!(!page.contains("send Command"), "what acted earlier is not in this figure: {page}");
    }

    #[test]
    fn a_property_that_broke_has_a_sentence() {
        let mut broken = properties();
        broken[2].broken_s = Some(6.1);
        let of = Summary { measurements: Vec::new(), properties: broken, ..summary() };
        let collected = Collected::of(&header(), records().into_iter().map(Ok));
        let page = figures(&of, &header(), &collected).unwrap().into_string();
        for told in [
            "<h3>stops_on_loss</h3><p>At 6.100 s, in the step holding: moves 1.20 s after",
            "<h3>bus_off</h3><p>did not come about.</p>",
        ] {
            assert!(page.contains(told), "{page}");
        }
        assert_eq!(page.matches("<figure").count(), 2, "{page}");
    }
}
