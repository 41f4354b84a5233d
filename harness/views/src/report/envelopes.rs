//! `report.html` of envelopes: the probability to pass over the severity of a fault.

use super::download::{Table, number};
use super::frame::{Axis, Drawn, Frame, SCALE};
use super::listed;
use super::page::{document, section};
use super::palette::{BAND, CCW, CW, OUTSIDE};
use campaign::{Envelope, Level, Measured};
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use record::figures;

/// Renders the page of a plan's envelopes. The same arguments give the same bytes.
pub fn page(plan: &str, all: &[Measured]) -> String {
    let body = html! {
        header.(whole(all)) {
            h1 { (plan) ": how much of each fault is tolerated" }
            @for one in all { p.answer { (with_code(&answer(one))) } }
            p {
                "A run passes if every measurement is in its band and no property breaks. "
                @if tells(all) {
                    "A failed run is silently wrong unless the controller stopped, refused, or reported a problem in time. "
                }
                "A severity is tolerated if the required share of runs passes at it and at every smaller one that was run. "
                "What counts is the lower end of the 95 % interval (Wilson) of the share."
            }
        }
        (section("Envelopes", Some(table(all))))
        @for one in all {
            (section(&format!("{} of {}", one.envelope.kind, one.envelope.target), Some(figure(one))))
        }
    };
    document(&format!("{plan}: envelopes"), &body).into_string()
}

fn table(all: &[Measured]) -> Markup {
    // Without a requirement there is no verdict.
    let asks = all.iter().any(|one| one.at_least.is_some());
    let mut heads = vec!["fault", "target"];
    heads.extend(asks.then_some("verdict"));
    heads.push("tolerated up to");
    heads.extend(asks.then_some("required"));
    heads.push("by a share of");
    heads.extend(tells(all).then_some("silently wrong"));
    let rows = html! {
        @for one in all {
            @let envelope = &one.envelope;
            tr.(class(one)) {
                td { (envelope.kind) }
                td { (envelope.target) }
                @if asks { td { (verdict(one)) } }
                td {
                    @match envelope.tolerated {
                        Some(most) => {
                            (severity(most, &envelope.unit))
                            @if envelope.is_all { " (the largest that was tried)" }
                        },
                        None => "none of those tried",
                    }
                }
                @if asks {
                    td { @if let Some(least) = one.at_least { (severity(least, &envelope.unit)) } }
                }
                td { (figures::exact(100.0 * envelope.share, 3)) " % of runs" }
                @if tells(all) { td { (silent(one)) } }
            }
        }
    };
    listed::table(None, &heads, &rows)
}

fn tells(all: &[Measured]) -> bool {
    all.iter().any(|one| one.envelope.tells())
}

/// Colour of the page: that of the requirements, if there are any.
fn whole(all: &[Measured]) -> &'static str {
    let asked: Vec<&Measured> = all.iter().filter(|one| one.at_least.is_some()).collect();
    match asked.as_slice() {
        [] => "neutral",
        asked if asked.iter().all(|one| one.holds()) => "passed",
        _ => "failed",
    }
}

/// No colour without a requirement.
fn class(one: &Measured) -> &'static str {
    match (one.at_least, one.holds()) {
        (None, _) => "",
        (_, true) => "pass",
        (_, false) => "fail",
    }
}

/// States the result in a sentence.
fn answer(one: &Measured) -> String {
    let Envelope { kind, target, unit, share, .. } = &one.envelope;
    let share = figures::exact(100.0 * share, 3);
    let passes = match one.envelope.tolerated {
        Some(most) => {
            let most = severity(most, unit);
            format!("At least {share} % of runs pass with `{kind}` on `{target}` at up to {most}.")
        }
        None => {
            format!(
                "With every `{kind}` on `{target}` that was tried, fewer than {share} % of runs pass."
            )
        }
    };
    match one.envelope.most_silent() {
        Some(_) => format!("{passes} Silently wrong: {}.", silent(one)),
        None if one.envelope.levels.iter().any(|level| level.announced > 0) => {
            format!("{passes} None of the others is silently wrong.")
        }
        None => passes,
    }
}

/// The largest share of silently wrong runs.
fn silent(one: &Measured) -> String {
    one.envelope.most_silent().map_or("none".to_owned(), |level| {
        let at = severity(level.severity, &one.envelope.unit);
        format!("{} of {} at {at}", level.silent, level.runs)
    })
}

fn verdict(one: &Measured) -> Markup {
    let word = if one.holds() { "pass" } else { "fail" };
    html! { @if one.at_least.is_some() { span.verdict { (word) } } }
}

/// Plots the share of passing runs with its interval, and of silently wrong runs, over the logarithm of the severity.
fn figure(one: &Measured) -> Markup {
    let envelope = &one.envelope;
    let levels: Vec<&Level> = envelope.levels.iter().filter(|level| level.severity > 0.0).collect();
    let exponents = levels.iter().map(|level| level.severity.log10());
    let asked = one.at_least.filter(|least| *least > 0.0).map(f64::log10);
    let frame = Frame::wide(
        Axis::decades(figures::axis_label("severity", &envelope.unit), exponents.chain(asked)),
        Axis::around("runs in %", [0.0, 100.0]),
    );
    let name = format!("shares of runs over the severity of {}", envelope.kind);
    let plot = frame.plot(&name, |chart| -> Drawn {
        let share = 100.0 * envelope.share;
        let across = [(frame.x.range.start, share), (frame.x.range.end, share)];
        chart.draw_series([PathElement::new(across, BAND.stroke_width(SCALE))])?;
        if let Some(asked) = asked {
            let up = [(asked, 0.0), (asked, 100.0)];
            chart.draw_series([PathElement::new(up, OUTSIDE.stroke_width(SCALE))])?;
        }
        let bars = levels.iter().map(|level| {
            let at = level.severity.log10();
            let (lower, upper) = level.interval;
            PathElement::new([(at, 100.0 * lower), (at, 100.0 * upper)], CCW.stroke_width(SCALE))
        });
        chart.draw_series(bars)?;
        let points: Vec<(f64, f64)> =
            levels.iter().map(|level| (level.severity.log10(), 100.0 * level.share())).collect();
        let radius = 3 * SCALE as i32;
        chart.draw_series(points.iter().map(|at| Circle::new(*at, radius, CCW.filled())))?;
        chart.draw_series([PathElement::new(points, CCW.stroke_width(SCALE))])?;
        if envelope.most_silent().is_some() {
            let share = |level: &Level| 100.0 * level.silent as f64 / level.runs as f64;
            let silent: Vec<(f64, f64)> =
                levels.iter().map(|level| (level.severity.log10(), share(level))).collect();
            chart.draw_series([PathElement::new(silent, CW.stroke_width(SCALE))])?;
        }
        Ok(())
    });
    let mut data =
        Table::new(["severity", "passed", "announced", "silent", "runs", "lower", "upper"]);
    for level in &envelope.levels {
        data.row([
            number(level.severity),
            level.passed.to_string(),
            level.announced.to_string(),
            level.silent.to_string(),
            level.runs.to_string(),
            number(level.interval.0),
            number(level.interval.1),
        ]);
    }
    html! {
        figure {
            (plot)
            figcaption {
                "Points are shares of runs that passed, bars their 95 % intervals. Green: the required share."
                @if envelope.most_silent().is_some() { " Without points: silently wrong." }
                @if one.at_least.is_some() { " Red: the required severity." }
                " " (data.link(&format!("{}-{}", envelope.kind, envelope.target)))
            }
        }
    }
}

fn severity(value: f64, unit: &str) -> String {
    figures::with_unit(figures::exact(value, 3), unit)
}

/// A sentence in which words of a plan stand between backticks.
fn with_code(sentence: &str) -> Markup {
    html! {
        @for (index, part) in sentence.split('`').enumerate() {
            @if index % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Measured, page};
    use campaign::{Envelope, Level};
    use scraper::{Html, Selector};

    fn measured(at_least: Option<f64>) -> Measured {
        let level = |severity, passed| {
            let announced = (40 - passed) / 2;
            let silent = 40 - passed - announced;
            Level { severity, passed, announced, silent, runs: 40, interval: (0.1, 0.9) }
        };
        let envelope = Envelope {
            kind: "drop".to_owned(),
            target: "<gyro>".to_owned(),
            unit: "%".to_owned(),
            share: 0.9,
            levels: vec![level(0.0, 40), level(0.1, 40), level(1.0, 30), level(10.0, 0)],
            tolerated: Some(0.1),
            is_all: false,
        };
        Measured { plan: "x".to_owned(), envelope, at_least }
    }

    fn texts(page: &Html, selector: &str) -> Vec<String> {
        let selector = Selector::parse(selector).unwrap();
        page.select(&selector).map(|found| found.text().collect()).collect()
    }

    #[test]
    fn the_page_says_what_holds_and_draws_what_was_run() {
        let text = page("laps", &[measured(Some(0.1)), measured(Some(0.2)), measured(None)]);
        assert!(!text.contains("<gyro>") && !text.contains("://"), "text from outside is escaped");
        let page = Html::parse_document(&text);
        assert_eq!(texts(&page, ".verdict"), ["pass", "fail"]);
        assert_eq!(page.select(&Selector::parse("svg.plot").unwrap()).count(), 3);
        assert_eq!(page.select(&Selector::parse("a.data").unwrap()).count(), 3);
        assert_eq!(texts(&page, "td:nth-child(4)"), ["0.1 %", "0.1 %", "0.1 %"]);
        assert_eq!(texts(&page, "td:nth-child(7)"), ["20 of 40 at 10 %"; 3]);
        let answer = "At least 90 % of runs pass with drop on <gyro> at up to 0.1 %. Silently wrong: 20 of 40 at 10 %.";
        assert_eq!(texts(&page, "p.answer")[2], answer);
        assert_eq!(page.select(&Selector::parse("tr.fail").unwrap()).count(), 1);
        assert!(text.contains("<th>required</th>"), "{text}");
        // Found by a user: without a requirement, two columns were empty.
        let asked_nothing = Html::parse_document(&super::page("laps", &[measured(None)]));
        assert_eq!(texts(&asked_nothing, "td:nth-child(3)"), ["0.1 %"]);
        assert_eq!(texts(&asked_nothing, "th").len(), 5);
        let mut mute = measured(None);
        mute.envelope.levels.iter_mut().for_each(|level| (level.announced, level.silent) = (0, 0));
        let mute = super::page("oven", &[mute]);
        assert!(text.contains("silently wrong") && !mute.contains("silently wrong"));
        assert_eq!(page.select(&Selector::parse("header.failed").unwrap()).count(), 1);
    }

    #[test]
    fn the_page_is_red_only_if_a_requirement_is_not_met() {
        let class = |all: &[Measured]| {
            let text = page("laps", all);
            let header =
                text.split("<header class=\"").nth(1).and_then(|rest| rest.split('"').next());
            header.unwrap().to_owned()
        };
        assert_eq!(class(&[measured(None)]), "neutral");
        assert_eq!(class(&[measured(None), measured(Some(0.1))]), "passed");
        assert_eq!(class(&[measured(Some(0.1)), measured(Some(0.2))]), "failed");
    }
}
