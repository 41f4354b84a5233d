//! Sentences on the effects added to the model, with their alternatives.

use super::meaning::{cause, meaning, title};
use super::ruler::ends;
use identification::dataset::Axis;
use identification::finding::{Effect, Finding, Parameter, Rival};
use identification::model::is_place;
use identification::outcome::{Diagnostics, EffectCurve};
use maud::{Markup, html};
use record::figures;

/// Maximum number of parameters in a sentence.
const PARAMETERS_MAX: usize = 4;

/// Smaller probabilities are not distinguished.
const PROBABILITY_MIN: f64 = 0.01;

/// Renders one card per effect, the strongest first.
pub(super) fn cards(finding: &Finding, diagnostics: &Diagnostics) -> Markup {
    html! {
        @if finding.effects.is_empty() { p.missing { "No effect was added to the model." } }
        @if finding.effects.len() > 1 { p { "The strongest first." } }
        div.cards { @for effect in &finding.effects { (card(effect, finding, diagnostics)) } }
    }
}

fn card(effect: &Effect, finding: &Finding, diagnostics: &Diagnostics) -> Markup {
    let unit = error_unit(effect, finding);
    html! {
        article.effect {
            h3 {
                (title(&effect.name))
                @if let Some(axis) = effect.axis { ", " (axis_name(axis)) " axis" }
                @if !effect.known { " " span.tag { "no standard effect" } }
            }
            p { (size(effect, curve(effect, diagnostics))) }
            p { (meaning(effect, finding.kind)) }
            p.small {
                "Without it the error on data left out of the fit would be "
                (figures::quantity(effect.held_out_before, 0.0, unit)) ", with it it is "
                (figures::quantity(effect.held_out_after, 0.0, unit))
                @if effect.held_out_after >= effect.held_out_before {
                    ": there it does not help, beside all else that was found"
                }
                @if let Some(other) = finding.not_told_apart(effect) {
                    ". It is not told apart from " strong { (title(&other.name)) }
                    ", which has a constant in itself."
                } @else {
                    ". Noise alone gives as strong a sign with a probability "
                    (probability(effect.p_value)) "."
                }
            }
            @if !effect.rivals.is_empty() { (rivals(effect)) }
        }
    }
}

/// Describes its size: its parameters, and its contribution over these data.
fn size(effect: &Effect, curve: Option<&EffectCurve>) -> String {
    let sizes: Vec<&Parameter> = effect.parameters.iter().filter(|p| !is_place(&p.name)).collect();
    let mut text = if sizes.is_empty() {
        "It has no number of its own".to_owned()
    } else if sizes.len() <= PARAMETERS_MAX {
        let written: Vec<String> = sizes.iter().map(|p| parameter(p)).collect();
        format!("Size: {}", written.join(", "))
    } else {
        let what = if effect.drivers.len() > 1 { "surface" } else { "curve" };
        format!("A {what} through {} values", sizes.len())
    };
    let causes: Vec<String> = effect.drivers.iter().map(|driver| cause(driver)).collect();
    if !causes.is_empty() {
        text += &format!(", driven by {}", causes.join(" and by "));
    }
    let (low, high) = ends(curve.iter().flat_map(|curve| curve.points.iter().map(|p| p.1)));
    if let Some(curve) = curve
        && low <= high
    {
        let fine = (high - low) / 10.0;
        let (low, high) = (figures::value(low, fine), figures::value(high, fine));
        let unit = if curve.unit == "1" { "" } else { &curve.unit };
        text += &format!(". Over these data it goes from {low} to {high} {unit}");
    }
    format!("{}.", text.trim_end())
}

fn parameter(parameter: &Parameter) -> String {
    let Parameter { name, value, standard_error, unit, .. } = parameter;
    let error = standard_error.unwrap_or(0.0);
    format!("{} {}", name.replace('_', " "), figures::quantity(*value, error, unit))
}

/// Returns the curve of an effect if exactly one has its name; with several axes, the curve of its axis.
fn curve<'a>(effect: &Effect, diagnostics: &'a Diagnostics) -> Option<&'a EffectCurve> {
    let driver = effect.drivers.first()?;
    let named = |label: Option<char>| {
        let blocks = diagnostics
            .blocks
            .iter()
            .filter(move |block| label.is_none_or(|axis| block.label.ends_with(axis)));
        let mut curves = blocks
            .flat_map(|block| &block.effects)
            .filter(|curve| curve.name == effect.name && curve.driver == *driver);
        match (curves.next(), curves.next()) {
            (Some(one), None) => Some(one),
            _ => None,
        }
    };
    named(None).or_else(|| named(Some(axis_name(effect.axis?))))
}

const fn axis_name(axis: Axis) -> char {
    match axis {
        Axis::X => 'x',
        Axis::Y => 'y',
        Axis::Z => 'z',
    }
}

/// Unit of an effect's held-out error: that of the finding with the same value.
fn error_unit<'a>(effect: &Effect, finding: &'a Finding) -> &'a str {
    let mut all = std::iter::once(&finding.held_out).chain(&finding.held_out_also);
    all.find(|held_out| held_out.after == effect.held_out_after)
        .map_or(&finding.noise_floor.unit, |held_out| &held_out.unit)
}

fn probability(value: f64) -> String {
    // A double cannot represent smaller ones precisely.
    if value < f64::MIN_POSITIVE { "below 1e-300".to_owned() } else { format!("of {value:.0e}") }
}

/// Renders the effect and its rivals with their probabilities.
fn rivals(effect: &Effect) -> Markup {
    let rest: f64 = effect.rivals.iter().map(|rival| rival.probability).sum();
    html! {
        h4 { "What else it could be" }
        p.small { "These data fit the following causes about as well; the bars are how probable each is." }
        table.rivals {
            tbody {
                tr {
                    td { strong { (title(&effect.name)) } }
                    (bar((1.0 - rest).clamp(0.0, 1.0)))
                    td.small { "as found" }
                }
                @for rival in &effect.rivals { (row(rival)) }
            }
        }
    }
}

fn row(rival: &Rival) -> Markup {
    let causes: Vec<String> = rival.drivers.iter().map(|driver| cause(driver)).collect();
    html! {
        tr {
            td { (title(&rival.name)) }
            (bar(rival.probability.clamp(0.0, 1.0)))
            td.small {
                "acts on " (rival.term.replace('_', " "))
                @if !causes.is_empty() { " by " (causes.join(" and ")) }
                @if let Some(plan) = &rival.separated_by { "; " code { (plan) } " would tell" }
            }
        }
    }
}

fn bar(probability: f64) -> Markup {
    let percent = 100.0 * probability;
    html! {
        td.share {
            span.bar { i style={ "width:" (format!("{percent:.1}")) "%" } {} }
            " "
            @if probability < PROBABILITY_MIN { "< 1 %" } @else { (format!("{percent:.0}")) " %" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Effect, cards, probability, size};
    use crate::report::identification::samples::{diagnostics, effect, finding};

    #[test]
    fn a_sentence_has_the_size_with_its_error_and_what_it_makes() {
        let diagnostics = diagnostics(300);
        let effect = &finding().effects[0];
        let curve = super::curve(effect, &diagnostics);
        assert_eq!(
            size(effect, curve),
            "Size: h 0.0100 ± 0.0010 deg/s/(K/s), driven by how fast temperature changes. Over these \
             data it goes from -0.0100 to 0.0100 deg/s."
        );
    }

    #[test]
    fn a_spline_is_not_listed_in_a_sentence() {
        let mut spline = effect("bias_shape_over_sun", &["sun"]);
        let one = spline.parameters[0].clone();
        spline.parameters = vec![one; 8];
        assert_eq!(size(&spline, None), "A curve through 8 values, driven by sun.");
    }

    #[test]
    fn a_constant_that_a_curve_holds_is_not_told_apart_from_it() {
        let mut finding = finding();
        let constant = Effect {
            form: "constant".into(),
            p_value: 1.0,
            rivals: Vec::new(),
            ..effect("bias", &[])
        };
        finding.effects = vec![constant.clone()];
        let alone = cards(&finding, &diagnostics(30)).into_string();
        assert!(alone.contains("with a probability of 1e0"), "{alone}");
        let curve = Effect { form: "spline".into(), ..effect("bias_shape_over_sun", &["sun"]) };
        finding.effects.push(curve.clone());
        let page = cards(&finding, &diagnostics(30)).into_string();
        assert!(page.contains("not told apart from <strong>Bias shape over sun"), "{page}");
        assert!(!page.contains("1e0"), "{page}");
        finding.effects[1].term = "scale".into();
        assert_eq!(finding.not_told_apart(&constant), None);
        finding.effects[1] = curve;
        finding.effects[0].p_value = 1e-3;
        assert_eq!(finding.not_told_apart(&finding.effects[0]), None);
    }

    #[test]
    fn probabilities_add_up_to_one() {
        let page = cards(&finding(), &diagnostics(30)).into_string();
        assert!(page.contains("width:80.0%") && page.contains("width:20.0%"), "{page}");
        assert_eq!(probability(0.0), "below 1e-300");
        assert_eq!(probability(1.2e-9), "of 1e-9");
    }
}
