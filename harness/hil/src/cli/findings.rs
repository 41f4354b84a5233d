//! Findings as a few lines of text.

use identification::finding::{Effect, Finding, HeldOut, Parameter, Prediction, in_unit, p_value};
use identification::model::is_frame;
use std::fmt::Write;

/// Formats verdict, errors before and after, each effect, what remains, and the next step.
pub(super) fn summary(finding: &Finding) -> String {
    let Finding { dataset, kind, rows, runs, .. } = finding;
    let verdict = finding.verdict_in_words();
    let mut out = format!(
        "{dataset}: {verdict} ({} of {rows} rows, {runs} {})\n",
        kind.name(),
        if *runs == 1 { "run" } else { "runs" }
    );
    for sentence in finding.in_words() {
        line(&mut out, &sentence);
    }
    for held_out in std::iter::once(&finding.held_out).chain(&finding.held_out_also) {
        line(&mut out, &errors(held_out));
    }
    let floor = &finding.noise_floor;
    line(&mut out, &format!("noise floor {}{}", number(floor.value), in_unit(&floor.unit)));
    for effect in &finding.effects {
        let sign = match finding.not_told_apart(effect) {
            Some(other) => format!("not told apart from {}", other.name),
            None => p_value(effect.p_value),
        };
        line(&mut out, &format!("{}; {sign}", words(effect)));
        for rival in &effect.rivals {
            let by = rival
                .separated_by
                .as_ref()
                .map_or(String::new(), |plan| format!(", {plan} decides"));
            let percent = 100.0 * rival.probability;
            let seen = seen(&rival.drivers);
            line(
                &mut out,
                &format!("  or {} ({}{seen}; {percent:.0} %{by})", rival.name, rival.term),
            );
        }
    }
    for compensation in finding.compensations() {
        let HeldOut { unit, before, after, .. } = &compensation.held_out;
        let (before, after) = (number(*before), number(*after));
        let of = &compensation.of;
        let unit = in_unit(unit);
        line(&mut out, &format!("compensation of {of}: error {before} -> {after}{unit}, by"));
        for step in &compensation.steps {
            line(&mut out, &format!("  {} = {}", step.name, step.expression));
        }
    }
    for left in &finding.left {
        let percent = 100.0 * left.share_of_residual_variance;
        // The name of a memory contains its time.
        let over = match left.is_memory() {
            true => String::new(),
            false => format!(" over {}", left.drivers.join(", ")),
        };
        let shape = &left.shape;
        line(&mut out, &format!("left: {shape}{over}, {percent:.1} % of the residual's variance"));
    }
    if let Some(next) = &finding.next_experiment {
        let between = next.separates.join(" and ");
        line(
            &mut out,
            &format!("next: {} tells {between} apart: {}", next.plan, next.expected_gain),
        );
    }
    for notice in &finding.notices {
        line(&mut out, &format!("note: {notice}"));
    }
    out
}

/// Error with the plain model and with the given one.
pub(super) fn prediction(prediction: &Prediction) -> String {
    let Prediction { dataset, kind, rows, unit, rmse, .. } = prediction;
    let (before, after) = (number(rmse.before), number(rmse.after));
    let (kind, unit) = (kind.name(), in_unit(unit));
    let mut out = format!("{dataset}: rmse {before} -> {after}{unit} ({kind} of {rows} rows)\n");
    for aside in &prediction.set_aside {
        line(&mut out, &aside.in_words());
    }
    out
}

/// Appends one line, whatever it contains: names come from files.
fn line(out: &mut String, text: &str) {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "  {plain}");
}

fn errors(held_out: &HeldOut) -> String {
    let HeldOut { metric, quantity, unit, before, after, ci95: [low, high], folds } = held_out;
    let of = quantity.as_ref().map_or(String::new(), |quantity| format!(" of {quantity}"));
    let (before, after, low, high) = (number(*before), number(*after), number(*low), number(*high));
    let unit = in_unit(unit);
    format!(
        "held-out {metric}{of} {before} -> {after}{unit} (95 %: {low} to {high}, {folds} folds)"
    )
}

fn words(effect: &Effect) -> String {
    let axis = effect.axis.map_or(String::new(), |axis| format!(", axis {axis:?}").to_lowercase());
    let is_number = |one: &&Parameter| !is_frame(&one.name);
    let parameters: Vec<_> = effect.parameters.iter().filter(is_number).map(parameter).collect();
    format!(
        "effect {}: {}{} ({}{axis}): {}",
        effect.name,
        effect.term,
        seen(&effect.drivers),
        effect.form,
        parameters.join(", "),
    )
}

/// What an effect sees; a constant sees nothing.
fn seen(drivers: &[String]) -> String {
    if drivers.is_empty() { String::new() } else { format!(" by {}", drivers.join(", ")) }
}

fn parameter(parameter: &Parameter) -> String {
    let Parameter { name, value, standard_error, unit, .. } = parameter;
    let error = standard_error.map_or(String::new(), |error| format!(" ± {}", number(error)));
    format!("{name} = {}{error}{}", number(*value), in_unit(unit))
}

/// Formats to three significant digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    // Between -3 and 4.
    let digits = (2 - size.log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::{seen, summary};
    use identification::finding::Finding;

    #[test]
    fn a_constant_is_by_nothing() {
        assert_eq!(seen(&[]), "");
        assert_eq!(seen(&["speed".to_owned(), "time".to_owned()]), " by speed, time");
    }

    #[test]
    fn a_finding_in_a_few_lines() {
        let finding: Finding = serde_json::from_str(
            r#"{ "schema": 1, "dataset": "bench", "kind": "turns", "rows": 300, "runs": 150, "seed": 1,
              "verdict": "explained", "noise_floor": { "value": 0.05, "unit": "deg" },
              "held_out": { "metric": "rmse", "unit": "deg", "before": 0.21, "after": 0.06,
                            "ci95": [0.055, 0.066], "folds": 5 },
              "effects": [ { "name": "shupe", "known": true, "term": "bias",
                "drivers": ["rate_of(temperature)"], "form": "linear", "parameters": [
                  { "name": "h", "value": 0.01, "standard_error": 1e-5, "unit": "deg/s/(K/s)" } ],
                "p_value": 1e-9, "held_out_before": 0.21, "held_out_after": 0.06, "rivals": [
                  { "name": "bias_over_temperature", "term": "bias", "drivers": ["temperature"],
                    "probability": 0.2, "separated_by": "hot-restart.toml" } ] } ],
              "left": [ { "drivers": ["time"], "shape": "trend", "share_of_residual_variance": 0.1 } ],
              "next_experiment": { "plan": "hot-restart.toml", "separates": ["shupe", "bias\u001b"],
                                   "expected_gain": "decided in 9 of 10 cases" },
              "notices": ["V is constant"] }"#,
        )
        .unwrap();
        insta::assert_snapshot!(summary(&finding));
    }
}
