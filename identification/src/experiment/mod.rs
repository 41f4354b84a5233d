//! The next experiment: from a finite menu of plans, the one that best tells an effect from its rivals.
//!
//! For each plan and rival the distance is the smaller of both directions (the effect true and the rival fitted, and
//! the reverse) on the given and the planned rows together. The plan with the largest minimum distance over the rivals
//! wins; distances are capped, so that of two sufficient plans the shorter wins.

mod case;
mod contest;
mod gain;
mod menu;
mod menu_base;
mod plan;
mod planned;
mod step;
mod surroundings;
#[cfg(test)]
mod tests;
mod timeline;

use crate::dataset::{Dataset, Kind};
use crate::finding::{Effect, Finding, NextExperiment, Rival};
use crate::model::Acts;
use crate::problem::Problem;
use case::Pair;
pub(crate) use case::{Case, Doubt, cases};
use gain::{Gain, gains};
use step::Programme;
use surroundings::levels;

/// Cap on distances: a rival that far is refused with certainty.
const ENOUGH: f64 = 100.0;
/// Probability of refusing the wrong cause from which a plan decides between two causes.
const DECIDES: f64 = 0.8;
/// Minimum gain in distance to any rival; a plan with less is useless.
const GAIN_MIN: f64 = 1.0;

/// A plan that would decide between an effect and its rivals.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Name of the plan, and of its file without `.toml`.
    pub name: String,
    /// The plan.
    pub plan_toml: String,
    /// Names of the effect and of the rivals that the plan separates from it.
    pub separates: Vec<String>,
    /// Sentence with the expected gain.
    pub expected_gain: String,
    decided: Vec<Pair>,
}

impl Experiment {
    /// File name of the plan.
    pub fn file(&self) -> String {
        format!("{}.toml", self.name)
    }

    /// Enters the plan in a finding: as the next experiment, and at each rival that it decides.
    pub fn note(&self, finding: &mut Finding) {
        for effect in &mut finding.effects {
            for rival in &mut effect.rivals {
                let pair = Pair {
                    effect: effect.name.clone(),
                    axis: effect.axis,
                    rival: rival.name.clone(),
                    drivers: rival.drivers.clone(),
                };
                if self.decided.contains(&pair) {
                    rival.separated_by = Some(self.file());
                }
            }
        }
        finding.next_experiment = Some(NextExperiment {
            plan: self.file(),
            separates: self.separates.clone(),
            expected_gain: self.expected_gain.clone(),
        });
    }
}

/// Every plan for data of that kind, with bias tests throughout and with only one: name and text. `by_hand` lists
/// fields that a person sets: name, unit, lowest and highest value.
pub fn plans(kind: Kind, by_hand: &[(&str, &'static str, f64, f64)]) -> Vec<(String, String)> {
    let levels: Vec<_> = by_hand
        .iter()
        .map(|&(field, unit, low, high)| surroundings::Level {
            field: field.to_owned(),
            unit,
            low,
            high,
        })
        .collect();
    menu(kind, &levels)
        .iter()
        .flat_map(|programme| [programme.clone(), programme.clone().with_one_bias_test()])
        .map(|programme| {
            (programme.name.to_owned(), plan::toml(&programme, &plan::why(&programme)))
        })
        .collect()
}

fn menu(kind: Kind, levels: &[surroundings::Level]) -> Vec<Programme> {
    match kind {
        Kind::Turns | Kind::Series => menu::table(levels),
        Kind::Odometry | Kind::Laps => menu_base::base(),
        Kind::Sensor => Vec::new(),
    }
}

/// The plan that best separates an effect from its rivals; `None` if there are no rivals, or none that a plan separates.
pub(crate) fn next(
    dataset: &Dataset,
    problem: &Problem,
    doubts: &[Doubt<'_>],
    cases: &[Case],
) -> Option<Experiment> {
    let first = cases.first()?;
    let mine = cases
        .iter()
        .take_while(|case| case.pair.effect == first.pair.effect && case.doubt == first.doubt)
        .count();
    let fields: Vec<&str> = cases
        .iter()
        .flat_map(|case| &case.contests)
        .flat_map(|contest| &contest.truth.shape.drivers)
        .map(|driver| driver.field.as_str())
        .collect();
    let on_bias = cases
        .iter()
        .flat_map(|case| &case.contests)
        .any(|contest| is_bias(contest.truth.shape.acts));
    let menu: Vec<Programme> = menu(dataset.kind, &levels(dataset, &fields))
        .into_iter()
        .map(|programme| if on_bias { programme.with_one_bias_test() } else { programme })
        .collect();
    let offers: Vec<(&Programme, Vec<Gain>)> = menu
        .iter()
        .filter_map(|programme| {
            Some((programme, gains(dataset, problem, doubts, programme, cases)?))
        })
        .collect();
    // Rivals that no plan can separate do not affect the choice.
    let separable = |rival: &usize| {
        offers.iter().any(|(_, gains)| gains[*rival].then - gains[*rival].now > GAIN_MIN)
    };
    let count: Vec<usize> = (0..mine).filter(separable).collect();
    if count.is_empty() {
        return None;
    }
    let worth = |gains: &[Gain]| {
        count.iter().map(|&rival| gains[rival].then.min(ENOUGH)).fold(f64::INFINITY, f64::min)
    };
    let (programme, gains) = offers
        .iter()
        .reduce(|best, offer| if worth(&offer.1) > worth(&best.1) { offer } else { best })?;
    let named: Vec<(String, Gain)> = cases
        .iter()
        .take(mine)
        .zip(gains)
        .map(|(case, gain)| (case.pair.rival.clone(), *gain))
        .collect();
    let effect = &first.pair.effect;
    let separates = plan::separates(effect, &named);
    let expected_gain = plan::gain(effect, &named);
    let mut notes =
        vec![format!("Tells apart: {}.", separates.join(", ")), format!("It {expected_gain}.")];
    notes.extend(plan::why(programme));
    let decided = cases.iter().zip(gains).filter(|(_, gain)| gain.probability >= DECIDES);
    Some(Experiment {
        name: programme.name.to_owned(),
        plan_toml: plan::toml(programme, &notes),
        separates,
        expected_gain,
        decided: decided.map(|(case, _)| case.pair.clone()).collect(),
    })
}

/// Takes the rivals that the given rows refuse with certainty from `effects` and from `cases`. They were rivals while the
/// noise was not known as well as after the last effect. A rival that predicts as well as the effect, or better, is not
/// refused, however well the rows tell the two apart.
pub(crate) fn refuse(cases: &mut Vec<Case>, effects: &mut [Effect]) {
    for Case { pair, .. } in cases.extract_if(.., |case| case.is_behind && case.now >= ENOUGH) {
        let mine = |one: &&mut Effect| one.name == pair.effect && one.axis == pair.axis;
        for effect in effects.iter_mut().filter(mine) {
            let is_rival =
                |rival: &Rival| rival.name == pair.rival && rival.drivers == pair.drivers;
            let gone: f64 = effect
                .rivals
                .extract_if(.., |rival| is_rival(rival))
                .map(|one| one.probability)
                .sum();
            effect.rivals.iter_mut().for_each(|rival| rival.probability /= 1.0 - gone);
        }
    }
}

/// Whether a term adds to the rate, so that a bias test would remove part of it.
fn is_bias(acts: Acts) -> bool {
    matches!(acts, Acts::Bias | Acts::DeadZone | Acts::Noise)
}
