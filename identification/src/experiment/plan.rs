//! A programme as a plan for `hil run`, with sentences on its use.

use super::Gain;
use super::step::{Programme, Step, TURN_RAMP};
use std::fmt::Write;

/// Longest operator prompt that a plan accepts, in bytes.
const PROMPT_MAX: usize = 500;
/// Interval between observations of a log, s.
const LOG_INTERVAL_S: f64 = 10.0;

/// The plan as TOML, with `notes` above it as comments, one per line.
pub(super) fn toml(programme: &Programme, notes: &[String]) -> String {
    let mut out = String::new();
    for note in notes {
        let plain: String = note.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        line(&mut out, &format!("# {plain}"));
    }
    if !notes.is_empty() {
        out.push('\n');
    }
    line(&mut out, &format!("name = {}", text(programme.name)));
    line(&mut out, &format!("title = {}", text(programme.title)));
    line(&mut out, &format!("devices = {}", text(programme.devices)));
    out.push_str("\nsteps = [\n");
    steps(&mut out, &programme.steps, 1);
    out.push_str("]\n\n");
    out.push_str(concat!(
        "[[measurement]]\n",
        "name = \"samples_lost\"\n",
        "doc = \"Gyro samples lost on the way: with any, the run is no basis for a finding\"\n",
        "quantity = \"samples.lost\"\n",
        "unit = \"1\"\n",
        "check = { all_within = [0, 0] }\n",
    ));
    out
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

fn text(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn steps(out: &mut String, all: &[Step], depth: usize) {
    for step in all {
        let indent = "    ".repeat(depth);
        let _ = write!(out, "{indent}{{ ");
        match step {
            Step::Repeat { times, period_s, steps: inner } => {
                let period =
                    period_s.map_or(String::new(), |period| format!("period_s = {period}, "));
                let _ = writeln!(out, "repeat = {{ times = {times}, {period}steps = [");
                steps(out, inner, depth + 1);
                let _ = write!(out, "{indent}] }}");
            }
            Step::Sweep { ambient, steps: inner } => {
                let values: Vec<String> = ambient.iter().map(|value| format!("{value}")).collect();
                let values = values.join(", ");
                let _ = writeln!(
                    out,
                    "sweep = {{ parameter = \"gyro.ambient_celsius\", values = [{values}], steps = ["
                );
                steps(out, inner, depth + 1);
                let _ = write!(out, "{indent}] }}");
            }
            other => out.push_str(&simple(other)),
        }
        out.push_str(" },\n");
    }
}

fn simple(step: &Step) -> String {
    match step {
        Step::Ambient(celsius) => {
            format!("set_parameter = {{ parameter = \"gyro.ambient_celsius\", value = {celsius} }}")
        }
        Step::Rest(duration) => {
            let interval = LOG_INTERVAL_S.min(*duration);
            format!("log = {{ duration_s = {duration}, interval_s = {interval} }}")
        }
        Step::BiasTest => "bias_test = { duration_s = 20 }".to_owned(),
        Step::TableTurn(angle, rate) => format!(
            "table_turn = {{ angle_deg = {angle}, rate_deg_per_s = {rate}, acceleration_deg_per_s2 = {TURN_RAMP} }}"
        ),
        Step::Ask(what) => prompt(what),
        Step::Level { field, unit, value } => {
            prompt(&format!("Set {field} to {} {unit}.", (value * 1e3).round() / 1e3))
        }
        Step::Place(heading) => {
            format!("place = {{ x_m = 0, y_m = 0, heading_deg = {heading} }}")
        }
        Step::Straight(distance, speed) => {
            format!("straight = {{ distance_m = {distance}, speed_m_per_s = {speed} }}")
        }
        Step::Turn(angle, rate) => {
            format!("turn = {{ angle_deg = {angle}, rate_deg_per_s = {rate} }}")
        }
        Step::Lap { ccw, side, speed, rate } => format!(
            "lap = {{ direction = \"{}\", side_m = {side}, speed_m_per_s = {speed}, turn_rate_deg_per_s = {rate} }}",
            if *ccw { "ccw" } else { "cw" }
        ),
        // `steps` writes these.
        Step::Repeat { .. } | Step::Sweep { .. } => String::new(),
    }
}

fn prompt(what: &str) -> String {
    let mut shown = String::new();
    for c in what.chars().map(|c| if c.is_control() { ' ' } else { c }) {
        if shown.len() + c.len_utf8() > PROMPT_MAX {
            break;
        }
        shown.push(c);
    }
    format!("operator_prompt = {{ text = {} }}", text(&shown))
}

/// Probability of refusal from which a rival counts as separated.
const TOLD_APART: f64 = 0.5;
/// Probabilities above this are written as "more than 99 %".
const CERTAIN: f64 = 0.99;

/// Names of the effect and of the rivals that the plan separates from it; of the farthest rival if it separates none.
pub(super) fn separates(effect: &str, rivals: &[(String, Gain)]) -> Vec<String> {
    let mut told: Vec<String> = rivals
        .iter()
        .filter(|(_, gain)| gain.probability >= TOLD_APART)
        .map(|(rival, _)| rival.clone())
        .collect();
    if told.is_empty() {
        let farthest = rivals.iter().max_by(|a, b| a.1.then.total_cmp(&b.1.then));
        told.extend(farthest.map(|(rival, _)| rival.clone()));
    }
    let mut names = vec![effect.to_owned()];
    names.extend(told);
    names
}

/// The plan's gain, rival by rival.
pub(super) fn gain(effect: &str, rivals: &[(String, Gain)]) -> String {
    let (told, open): (Vec<_>, Vec<_>) =
        rivals.iter().partition(|(_, gain)| gain.probability >= TOLD_APART);
    let words = |(rival, gain): &&(String, Gain)| {
        let percent = if gain.probability > CERTAIN {
            "more than 99".to_owned()
        } else {
            format!("{:.0}", 100.0 * gain.probability)
        };
        let (then, now) = (figure(gain.then), figure(gain.now));
        format!("{rival} with {percent} % probability (lambda {then} against {now} now)")
    };
    let list = |rivals: &[&(String, Gain)]| rivals.iter().map(words).collect::<Vec<_>>().join("; ");
    match (told.is_empty(), open.is_empty()) {
        (false, true) => format!("decides between {effect} and {}", list(&told)),
        (false, false) => {
            format!("decides between {effect} and {}; leaves open {}", list(&told), list(&open))
        }
        _ => format!("most likely leaves {effect} in doubt: it decides against {}", list(&open)),
    }
}

fn figure(lambda: f64) -> String {
    match lambda {
        ..10.0 => format!("{lambda:.1}"),
        ..1e6 => format!("{lambda:.0}"),
        _ => format!("{lambda:.0e}"),
    }
}

/// The reason for the plan, and what a reader should know before running it.
pub(super) fn why(programme: &Programme) -> Vec<String> {
    let mut notes = vec![format!("Why: {}.", programme.reason)];
    if programme.warm {
        notes.push(
            "A simulated bench has nobody to switch the gyro: set powered_before_s = 7200 in its model there."
                .to_owned(),
        );
    }
    if programme.name == "levels-by-hand" {
        notes.push("The run does not hold the field: add it to the exported table.".to_owned());
    }
    notes.push("Another bench with the same roles: change `devices`.".to_owned());
    notes
}
