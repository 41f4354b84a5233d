//! Numbers of the model and of the noise.

use super::super::listed::table;
use super::meaning::title;
use identification::finding::Parameter;
use identification::model::{Model, Term};
use identification::outcome::Diagnostics;
use maud::{Markup, html};
use record::figures;

const HEADS: [&str; 8] = [
    "term",
    "acts on",
    "over",
    "parameter",
    "#value",
    "#standard error",
    "unit",
    "#in the model given",
];

/// Renders every parameter of every term, and its previous value.
pub(super) fn parameters(model: &Model) -> Markup {
    html! {
        @if model.terms.is_empty() { p.missing { "The model has no term." } } @else {
            p {
                "As in model.toml. The error is one standard error: two times as much to either side "
                "holds the true value in 95 of 100 cases, if the model is right."
            }
            (table(Some("model"), &HEADS, &html! {
                @for term in &model.terms { (rows(term, &model.plain)) }
            }))
        }
    }
}

fn rows(term: &Term, plain: &[Term]) -> Markup {
    let given = plain.iter().find(|other| {
        (&other.name, other.term, other.axis, &other.quantity)
            == (&term.name, term.term, term.axis, &term.quantity)
    });
    let drivers: Vec<String> = term.drivers.iter().map(ToString::to_string).collect();
    let before = |name: &str| given.and_then(|term| term.parameter(name));
    html! {
        @for (index, parameter) in term.parameters.iter().enumerate() {
            tr {
                @if index == 0 {
                    td rowspan=(term.parameters.len()) {
                        strong { (title(&term.name)) }
                        @if let Some(quantity) = &term.quantity { span.small { " of " (quantity) } }
                        @if let Some(axis) = term.axis { span.small { " " (format!("{axis:?}").to_lowercase()) } }
                    }
                    td rowspan=(term.parameters.len()) { (word(term.term)) }
                    td rowspan=(term.parameters.len()) {
                        @if drivers.is_empty() { "-" } @else { code { (drivers.join(", ")) } }
                    }
                }
                td { (parameter.name) }
                td.number { (value(parameter)) }
                td.number { (error(parameter)) }
                td { (parameter.unit) }
                td.number { (before(&parameter.name).map_or_else(|| "-".to_owned(), value)) }
            }
        }
    }
}

/// Returns the contract's word for a value.
fn word(value: impl serde::Serialize) -> String {
    let word = serde_json::to_value(value).ok();
    word.and_then(|word| Some(word.as_str()?.replace('_', " "))).unwrap_or_default()
}

fn value(parameter: &Parameter) -> String {
    figures::value(parameter.value, parameter.standard_error.unwrap_or(0.0))
}

fn error(parameter: &Parameter) -> String {
    match parameter.standard_error {
        Some(error) if error > 0.0 => figures::value(error, error),
        _ => "fixed".to_owned(),
    }
}

/// Renders the noise components of each observed quantity.
pub(super) fn noise(diagnostics: &Diagnostics) -> Option<Markup> {
    if diagnostics.blocks.iter().all(|block| block.noise.is_empty()) {
        return None;
    }
    Some(html! {
        p { "Standard deviations of the parts that no cause explains." }
        (table(Some("noise"), &["quantity", "part", "#size", "unit"], &html! {
            @for block in &diagnostics.blocks {
                @for part in &block.noise {
                    tr {
                        td { code { (block.label) } }
                        td { (noise_part(&part.name)) }
                        td.number { (value(part)) }
                        td { (part.unit) }
                    }
                }
            }
        }))
    })
}

fn noise_part(name: &str) -> String {
    match name {
        "white" => "white: new in every observation".to_owned(),
        "offset_of_each_run" => "an offset of each run".to_owned(),
        other => match other.strip_prefix("correlated_over_") {
            Some(time) => format!("wanders, remembers {}", time.replace('_', " ")),
            None => other.replace('_', " "),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::noise_part;

    #[test]
    fn parts_of_the_noise_in_words() {
        assert_eq!(noise_part("correlated_over_12.500_s"), "wanders, remembers 12.500 s");
        assert_eq!(noise_part("white"), "white: new in every observation");
    }
}
