//! Measured values, against the paper if it gives any, with a gauge of each value in its band.

use super::listed;
use maud::{Markup, html};
use plan::Proves;
use record::figures;
use record::outcome::{Measurement, Verdict};

/// Size of the gauge in CSS pixels: the band takes the middle half.
const GAUGE_WIDTH: f64 = 140.0;
const GAUGE_HEIGHT: f64 = 18.0;
/// Least width of a band in the picture.
const BAND_WIDTH_MIN: f64 = 2.0;

/// Expanded uncertainty: about 95 % of a normal distribution.
const COVERAGE_FACTOR: f64 = 2.0;

pub(super) fn heading(measurements: &[Measurement]) -> &'static str {
    if has_paper(measurements) { "Paper against measured" } else { "Measured" }
}

fn has_paper(measurements: &[Measurement]) -> bool {
    measurements.iter().any(|measurement| measurement.paper.is_some())
}

pub(super) fn table(measurements: &[Measurement]) -> Markup {
    let paper = has_paper(measurements);
    if measurements.is_empty() {
        return html! { p.missing { "The plan declares no measurement." } };
    }
    let mut heads = vec!["measurement", "verdict", "#measured", "#band"];
    heads.extend(paper.then_some("paper"));
    heads.extend(["in the band", "#margin"]);
    let rows =
        html! { @for measurement in worst_first(measurements) { (row(measurement, paper)) } };
    listed::table(Some("measurements"), &heads, &rows)
}

/// Those that failed first, otherwise in the order of the plan.
fn worst_first(measurements: &[Measurement]) -> Vec<&Measurement> {
    let mut all: Vec<&Measurement> = measurements.iter().collect();
    all.sort_by_key(|measurement| match measurement.verdict {
        Verdict::Fail => 0,
        Verdict::Unset => 1,
        Verdict::Marginal => 2,
        Verdict::NotJudged => 3,
        Verdict::Pass => 4,
    });
    all
}

fn row(measurement: &Measurement, paper: bool) -> Markup {
    let Measurement { name, unit, lower, upper, verdict, .. } = measurement;
    let margin = measurement.margin().filter(|margin| margin.is_finite());
    html! {
        tr.(verdict.name()) {
            td {
                strong { (name) }
                div.small { (measurement.statistic) }
                @if let Some(proves) = measurement.proves { div.small { (sentence(proves)) } }
                @if let Some(reason) = reason(measurement) { div.reason { (reason) } }
            }
            td { span.verdict { (verdict.name()) } }
            td.number { (measurement.figure().unwrap_or_else(|| "-".to_owned())) }
            td.number { (figures::band(*lower, *upper, unit)) }
            @if paper { td.paper { (measurement.paper.as_deref().unwrap_or("-")) } }
            td { @if let Some(gauge) = gauge(measurement) { (gauge) } }
            td.number { (margin.map_or_else(|| html! { "-" }, |margin| margin_cell(margin, measurement))) }
        }
    }
}

fn sentence(proves: Proves) -> &'static str {
    match proves {
        Proves::TestsTheController => "tests the controller",
        Proves::ConsistencyOfInputs => "consistency of inputs",
    }
}

/// Distance to the limit, in the unit, as a share of the band and in standard uncertainties; negative outside.
fn margin_cell(margin: f64, measurement: &Measurement) -> Markup {
    let Measurement { lower, upper, unit, uncertainty, .. } = measurement;
    let share = match (lower, upper) {
        (Some(lower), Some(upper)) => Some(((upper - lower) / 2.0, "of half the band")),
        (Some(limit), None) | (None, Some(limit)) => Some((limit.abs(), "of the limit")),
        (None, None) => None,
    };
    let share = share.filter(|(whole, _)| *whole > 0.0);
    let sigmas = (*uncertainty > 0.0).then(|| margin / uncertainty);
    html! {
        (figures::with_unit(figures::value(margin, *uncertainty), unit))
        @if let Some((whole, of)) = share {
            div.small { (format!("{:.0} % ", 100.0 * margin / whole)) (of) }
        }
        @if let Some(sigmas) = sigmas.filter(|sigmas| sigmas.is_finite()) {
            div.small { (figures::exact(sigmas, 2)) " σ" }
        }
    }
}

/// Why it did not simply pass.
pub(super) fn reason(measurement: &Measurement) -> Option<String> {
    let Measurement { unit, uncertainty, .. } = measurement;
    let figure = |value: f64| figures::quantity(value, 0.0, unit);
    let margin = measurement.margin().map(|margin| {
        let digits = figures::value(margin.abs(), *uncertainty);
        if unit.is_empty() || unit == "1" { digits } else { format!("{digits} {unit}") }
    });
    match (measurement.verdict, margin) {
        (Verdict::Pass, _) => None,
        (Verdict::Unset | Verdict::NotJudged, _) => Some(measurement.statistic.clone()),
        (Verdict::Marginal, Some(margin)) => Some(format!(
            "inside by {margin}, less than its expanded uncertainty of {} (k = 2)",
            figure(COVERAGE_FACTOR * uncertainty)
        )),
        (Verdict::Fail, Some(margin)) if measurement.margin() < Some(0.0) => {
            Some(format!("outside by {margin}"))
        }
        (Verdict::Marginal, None) => Some("inside by less than its uncertainty".to_owned()),
        (Verdict::Fail, _) => Some("an observation was outside or no number".to_owned()),
    }
}

/// Draws the value with its expanded uncertainty in the band; a one-sided band ends at an edge.
fn gauge(measurement: &Measurement) -> Option<Markup> {
    let value = measurement.value.filter(|value| value.is_finite())?;
    let (begin, end) = match (measurement.lower, measurement.upper) {
        (Some(lower), Some(upper)) if upper > lower => {
            let half = (upper - lower) / 2.0;
            (lower - half, upper + half)
        }
        // A band without width is a limit on either side.
        (Some(limit), _) | (None, Some(limit)) => {
            let reach = (value - limit).abs().max(limit.abs() / 2.0).max(f64::MIN_POSITIVE) * 1.3;
            (limit - reach, limit + reach)
        }
        (None, None) => return None,
    };
    let x = |at: f64| ((at - begin) / (end - begin)).clamp(0.0, 1.0) * GAUGE_WIDTH;
    let low = measurement.lower.map_or(0.0, x);
    let high = measurement.upper.map_or(GAUGE_WIDTH, x);
    let spread = COVERAGE_FACTOR * measurement.uncertainty;
    let wide = (high - low).max(BAND_WIDTH_MIN);
    let px = |at: f64| format!("{at:.1}");
    let middle = GAUGE_HEIGHT / 2.0;
    Some(html! {
        svg.gauge width=(GAUGE_WIDTH) height=(GAUGE_HEIGHT) aria-hidden="true" {
            line.axis x1="0" x2=(GAUGE_WIDTH) y1=(middle) y2=(middle) {}
            rect.band x=(px((low + high - wide) / 2.0)) y="2" width=(px(wide)) height=(GAUGE_HEIGHT - 4.0) rx="2" {}
            @if spread > 0.0 {
                line.spread x1=(px(x(value - spread))) x2=(px(x(value + spread))) y1=(middle) y2=(middle) {}
            }
            circle.value cx=(px(x(value).clamp(4.0, GAUGE_WIDTH - 4.0))) cy=(middle) r="4" {}
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{gauge, margin_cell, reason, table};
    use record::outcome::samples::{measurement, summary};
    use record::outcome::{Measurement, Verdict};

    #[test]
    fn what_did_not_pass_says_why() {
        let reasons: Vec<_> = summary().measurements.iter().map(reason).collect();
        let expected = [
            None,
            Some("inside by 0.19 deg, less than its expanded uncertainty of 0.4 deg (k = 2)"),
            Some("outside by 0.25 deg"),
            Some("share inside"),
            None,
        ];
        assert_eq!(reasons.iter().map(Option::as_deref).collect::<Vec<_>>(), expected);
        let inside = measurement("x", 0.0, Verdict::Fail);
        assert_eq!(reason(&inside).unwrap(), "an observation was outside or no number");
    }

    #[test]
    fn the_gauge_shows_any_figure_and_any_band() {
        let any = measurement("x", 0.5, Verdict::Pass);
        let text = |m: &Measurement| gauge(m).unwrap().into_string();
        assert!(text(&any).contains(r#"cx="87.5""#), "{}", text(&any));
        assert!(text(&Measurement { value: Some(1e300), ..any.clone() }).contains(r#"cx="136.0""#));
        let exact = Measurement { lower: Some(0.0), upper: Some(0.0), ..any.clone() };
        assert!(text(&exact).contains(r#"x="69.0" y="2" width="2.0""#), "{}", text(&exact));
        let met = Measurement { lower: Some(1.0), upper: Some(1.0), value: Some(1.0), ..exact };
        assert!(text(&met).contains(r#"cx="70.0""#), "{}", text(&met));
        let at_most = Measurement { lower: None, value: Some(1.0), ..any.clone() };
        assert!(text(&at_most).contains(r#"cx="70.0""#), "{}", text(&at_most));
        assert!(gauge(&Measurement { value: Some(f64::NAN), ..any.clone() }).is_none());
        assert!(gauge(&Measurement { lower: None, upper: None, ..any }).is_none());
    }

    #[test]
    fn a_margin_is_told_in_the_unit_in_shares_and_in_uncertainties() {
        let cell = |m: &Measurement| margin_cell(m.margin().unwrap(), m).into_string();
        let any = Measurement { uncertainty: 0.1, ..measurement("x", 0.5, Verdict::Pass) };
        let small = |text: &str| format!("<div class=\"small\">{text}</div>");
        assert_eq!(
            cell(&any),
            format!("0.50 deg{}{}", small("50 % of half the band"), small("5 σ"))
        );
        let outside = Measurement { value: Some(1.2), uncertainty: 0.0, ..any.clone() };
        assert_eq!(cell(&outside), format!("-0.2 deg{}", small("-20 % of half the band")));
        let limit = Measurement { lower: None, ..any };
        assert!(cell(&limit).contains("50 % of the limit"), "{}", cell(&limit));
    }

    #[test]
    fn a_plan_without_measurements_says_so() {
        assert!(table(&[]).into_string().contains("declares no measurement"));
    }
}
