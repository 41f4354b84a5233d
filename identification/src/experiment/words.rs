//! Sentences on the use of an experiment.

use super::Gain;
use super::step::Programme;

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
