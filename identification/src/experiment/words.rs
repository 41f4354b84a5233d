//! What an experiment is good for, in words.

use super::Gain;
use super::step::Programme;

/// A rival counts as told apart where it is refused more probably than not.
const TOLD_APART: f64 = 0.5;
/// Probabilities above this are written as such.
const CERTAIN: f64 = 0.99;

/// Names of the effect and of the rivals that it tells apart; of the farthest rival where it tells none.
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

/// What it brings, rival by rival.
pub(super) fn gain(effect: &str, rivals: &[(String, Gain)]) -> String {
    let each: Vec<String> = rivals
        .iter()
        .map(|(rival, gain)| {
            let percent = if gain.probability > CERTAIN {
                "more than 99".to_owned()
            } else {
                format!("{:.0}", 100.0 * gain.probability)
            };
            format!(
                "between {effect} and {rival} with {percent} % probability (lambda {} against {} now)",
                figure(gain.then),
                figure(gain.now)
            )
        })
        .collect();
    format!("decides {}", each.join("; "))
}

fn figure(lambda: f64) -> String {
    if lambda < 10.0 { format!("{lambda:.1}") } else { format!("{lambda:.0}") }
}

/// Why the plan is as it is, and what a reader should know before it is run.
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
