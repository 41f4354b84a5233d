//! Two runs on one page: what was judged side by side, and their figures over one another.

use super::against::Against;
use super::collect::Collected;
use super::frame::{Axis, Frame, SCALE};
use super::listed;
use super::marks::{band_texts, draw_bands, draw_marks};
use super::observations::{declared, title};
use super::observed::{Direction, Sample};
use super::page::{document, section};
use super::palette::{CCW, CW};
use super::phases::Phases;
use super::thin::{Point, extremes};
use crate::console::Compared;
use maud::{Markup, html};
use plotters::element::PathElement;
use plotters::style::Color;
use record::Record;
use record::figures;
use record::header::{Header, Quantity};
use record::outcome::{Outcome, Summary};
use record::reader::RecordError;

const PLOTS_MAX: usize = 40;
/// Columns of a plot; two points of each are drawn.
const COLUMNS: usize = 400;
/// More samples than this over time are a line.
const MARKS_OVER_TIME_MAX: usize = 150;

#[derive(Debug)]
pub struct Run<'a, R> {
    pub name: &'a str,
    pub summary: &'a Summary,
    pub header: &'a Header,
    /// The record, which is read once.
    pub records: R,
}

/// The page. `first_difference` is a line of each record, where they differ first.
pub fn render<R: IntoIterator<Item = Result<Record, RecordError>>>(
    one: Run<'_, R>,
    other: Run<'_, R>,
    first_difference: Option<&[String; 2]>,
) -> String {
    let judged = Compared::all(one.summary, other.summary);
    let differing = judged.iter().filter(|compared| compared.differs()).count();
    let names = [one.name, other.name];
    let outcomes = [one.summary.outcome.name(), other.summary.outcome.name()];
    let has_passed = [one.summary, other.summary].iter().all(|it| it.outcome == Outcome::Passed);
    let look = match (differing, has_passed) {
        (0, true) => "passed",
        // Two that failed alike are no success.
        (0, false) => "open",
        _ => "failed",
    };
    let (mut left_out, mut figures) = (0, Vec::new());
    let both = [Collected::of(one.header, one.records), Collected::of(other.header, other.records)];
    let [first, second] = &both;
    for (name, series) in &first.series {
        let Some(beside) = second.series.get(name) else { continue };
        if series.samples.is_empty() || beside.samples.is_empty() {
            continue;
        }
        if figures.len() >= PLOTS_MAX {
            left_out += 1;
            continue;
        }
        figures.push(figure(
            name,
            [&series.samples, &beside.samples],
            declared(one.header, name).as_ref(),
            &first.phases,
        ));
    }
    let body = html! {
        header.(look) {
            p.outcome { (match differing { 0 => "no verdict differs".to_owned(), 1 => "1 verdict differs".to_owned(), n => format!("{n} verdicts differ") }) }
            h1 { (one.summary.title) }
            @match first_difference {
                Some([first, second]) => {
                    p.lead { "First difference of the records:" }
                    p.lead { code { i.mark.ccw { "●" } " " (first) } }
                    p.lead { code { i.mark.cw { "▲" } " " (second) } }
                }
                None => p.lead { "The records are the same." }
            }
            p.legend {
                span { i.mark.ccw { "●" } (names[0]) ": " (outcomes[0]) }
                span { i.mark.cw { "▲" } (names[1]) ": " (outcomes[1]) }
            }
            @for cut in both.iter().filter_map(|run| run.cut.as_ref()) {
                p.lead.cut { "Drawn from what could be read: " (cut) "." }
            }
        }
        (section("Side by side", (!judged.is_empty()).then(|| table(&judged))))
        (section("Overlaid figures", Some(html! {
            @if figures.is_empty() { p.missing { "No quantity was observed in both." } }
            div.plots { @for figure in figures { (figure) } }
            @if left_out > 0 {
                p.missing { "At most " (PLOTS_MAX) " plots are drawn; " (left_out) " more quantities are in the records." }
            }
        })))
    };
    document(&format!("{} and {}", names[0], names[1]), &body).into_string()
}

fn table(judged: &[Compared]) -> Markup {
    let rows = html! {
        @for one in judged {
            tr.(one.verdicts[1]) {
                td { strong { (one.name) } }
                td { (one.verdicts[0]) }
                td { @if one.differs() { span.verdict { (one.then()) } } @else { (one.then()) } }
                @for figure in &one.figures { td.number { (figure) } }
                td.number { (one.moved.as_deref().unwrap_or_default()) }
            }
        }
    };
    let heads = ["what", "verdict", "second verdict", "#first", "#second", "#change"];
    listed::table(Some("compared"), &heads, &rows)
}

/// A quantity of both, over the axis that says most about the first.
fn figure(
    name: &str,
    both: [&[Sample]; 2],
    declared: Option<&Quantity>,
    phases: &Phases,
) -> Markup {
    let unit = declared.map_or("", |quantity| &quantity.unit);
    let bands = declared.map_or(&[][..], |quantity| &quantity.bands);
    let all = || both.iter().copied().flatten();
    let every: Vec<Sample> = all().copied().collect();
    let against = Against::of(&every);
    let is_log = matches!(against, Against::Time { .. })
        && both.iter().any(|samples| samples.len() > MARKS_OVER_TIME_MAX);
    let ends = bands.iter().flat_map(|band| [band.lower, band.upper]).flatten();
    let frame = Frame::wide(
        Axis::around(against.label(), all().map(|sample| against.x(sample))),
        Axis::around(figures::axis_label(name, unit), all().map(|sample| sample.value).chain(ends)),
    );
    let plot = frame.plot(name, |chart| {
        draw_bands(chart, &frame, bands, &|band| phases.spans(band, against))?;
        for (samples, style, mark) in [(both[0], CCW, None), (both[1], CW, Some(Direction::Cw))] {
            let points: Vec<Point> =
                samples.iter().map(|sample| (against.x(sample), sample.value)).collect();
            let points = extremes(&points, COLUMNS);
            if is_log {
                // The first is broader, so that it is seen below the second.
                let width = if mark.is_none() { 4 * SCALE } else { SCALE };
                chart.draw_series([PathElement::new(points, style.stroke_width(width))])?;
            } else {
                draw_marks(chart, points, mark, style.mix(0.7).filled())?;
            }
        }
        Ok(())
    });
    html! {
        figure {
            h3 { (title(name, declared)) }
            (plot)
            figcaption {
                p.legend {
                    span { i.mark.ccw { "●" } "first, " (both[0].len()) }
                    span { i.mark.cw { "▲" } "second, " (both[1].len()) }
                    @for band in band_texts(bands, unit) { span { i.swatch {} (band) } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Run, render};
    use record::header::Header;
    use record::outcome::Verdict;
    use record::outcome::samples::summary;
    use record::{Device, Observation, Record, RecordKind};
    use std::collections::BTreeMap;
    use wire::time::Timestamp;

    fn records(offset: f64, also: &str) -> Vec<Record> {
        let observed = |quantity: &str, k: i64| {
            let (quantity, value) = (quantity.to_owned(), offset + k as f64);
            let kind = Observation { quantity, value, uncertainty: 0.0, tags: BTreeMap::new() };
            let at = Timestamp::from_nanos(k * 1_000_000_000);
            Record { at, device: Device::Plan, kind: RecordKind::Observation(kind) }
        };
        let quantities = ["signal.Temperature", also];
        quantities.iter().flat_map(|name| (0..20).map(|k| observed(name, k))).collect()
    }

    #[test]
    fn what_both_observed_is_drawn_over_one_another() {
        let (one, mut other) = (summary(), summary());
        other.measurements[0].verdict = Verdict::Fail;
        let header = Header::default();
        let run = |name, summary, offset, also| {
            let records = records(offset, also).into_iter().map(Ok);
            Run { name, summary, header: &header, records: records.collect::<Vec<_>>() }
        };
        let page = render(
            run("<before>", &one, 1.0, "signal.Old"),
            run("after", &other, 2.0, "signal.New"),
            Some(&["1.0 x".to_owned(), "1.0 <y>".to_owned()]),
        );
        assert!(page.contains("1 verdict differs") && page.contains("&lt;before&gt;"));
        assert!(page.contains("</i> 1.0 x</code>") && page.contains("</i> 1.0 &lt;y&gt;</code>"));
        assert_eq!(page.matches("<figure>").count(), 1, "only one quantity is in both");
        assert!(page.contains("first, 20") && page.contains("second, 20"));
        let drawn = |colour: &str, mark: &str| {
            page.split('<').filter(|it| it.starts_with(mark) && it.contains(colour)).count()
        };
        assert_eq!((drawn("#1F66D1", "circle"), drawn("#D96C06", "polygon")), (20, 20));
        let none = render(run("a", &one, 1.0, "x"), run("b", &one, 1.0, "x"), None);
        assert!(none.contains("no verdict differs") && none.contains("The records are the same."));
        assert!(none.contains("<header class=\"open\">"), "both failed");
    }
}
