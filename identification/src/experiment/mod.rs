//! The next experiment: from a finite menu of plans, the one that best tells an effect from its rivals.
//!
//! For each plan and rival the distance is the smaller of both directions: the effect true and the rival fitted, and
//! the reverse, on the given and the planned rows together. The plan with the largest least distance over the rivals
//! wins; what is more than enough counts no further, so that a shorter plan is then taken.

mod contest;
mod decide;
mod menu;
mod menu_base;
mod plan;
mod planned;
mod step;
mod surroundings;
mod timeline;
mod words;
#[cfg(test)]
mod tests;

use crate::dataset::{Axis, Dataset, Kind};
use crate::finding::{Finding, NextExperiment};
use crate::linear::Basis;
use crate::model::{Acts, Shape};
use crate::noise::{Layout, NoiseModel, Whitener};
use crate::problem::{Aggregate, Block, Channel, Channels, Problem};
use crate::robust;
use crate::select::{BlockFit, Data, Found, fit_terms};
use crate::signal::Smooth;
use contest::{Contest, Triangle, Valued, lambda};
use decide::probability;
use step::Programme;
use surroundings::{Thermal, levels};

/// Distances above this are more than enough: a rival that far is refused with certainty.
const ENOUGH: f64 = 100.0;
/// A plan decides between two causes where it refuses the wrong one this probably.
const DECIDES: f64 = 0.8;
/// A plan that brings no more than this to any rival is of no use for it.
const GAIN_MIN: f64 = 1.0;
/// Pairs of an effect and a rival that are looked at, the strongest effect's first.
const PAIRS_MAX: usize = 12;

/// A plan that would decide between an effect and its rivals.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Name of the plan; its file is that and `.toml`.
    pub name: String,
    /// The plan.
    pub plan_toml: String,
    /// Names of the effect and of the rivals that it tells apart.
    pub separates: Vec<String>,
    /// What it brings, in words with a figure.
    pub expected_gain: String,
    /// Least distance of the effect from a rival that the plan brings, squared, in units of the noise.
    pub lambda: f64,
    /// The same of each rival.
    pub by_rival: Vec<(String, f64)>,
    decided: Vec<Pair>,
}

/// An effect and a rival.
#[derive(Debug, Clone, PartialEq)]
struct Pair {
    effect: String,
    axis: Option<Axis>,
    rival: String,
    drivers: Vec<String>,
}

/// A fitted block with its effects.
#[derive(Clone, Copy)]
pub(crate) struct Doubt<'a> {
    /// The data.
    pub data: Data<'a>,
    /// What was found in them.
    pub fit: &'a BlockFit,
}

/// A pair with both contests and what the given rows say of them.
struct Case {
    pair: Pair,
    doubt: usize,
    contests: [Contest; 2],
    widths: [usize; 2],
    given: [Triangle; 2],
    now: f64,
}

/// What a plan brings to a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gain {
    now: f64,
    then: f64,
    probability: f64,
}

impl Experiment {
    /// Name of the file of the plan.
    pub fn file(&self) -> String {
        format!("{}.toml", self.name)
    }

    /// Notes it in a finding: as the next experiment, and at each rival that it decides about.
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

/// Every plan of the menu for data of that kind, with bias tests throughout and with one alone: name and text. `by_hand` are fields that a person moves: name, unit,
/// lowest and highest value.
pub fn plans(kind: Kind, by_hand: &[(&str, &'static str, f64, f64)]) -> Vec<(String, String)> {
    let levels: Vec<_> = by_hand
        .iter()
        .map(|&(field, unit, low, high)| surroundings::Level { field: field.to_owned(), unit, low, high })
        .collect();
    menu(kind, &levels)
        .iter()
        .flat_map(|programme| [programme.clone(), programme.clone().with_one_bias_test()])
        .map(|programme| (programme.name.to_owned(), plan::toml(&programme, &words::why(&programme))))
        .collect()
}

fn menu(kind: Kind, levels: &[surroundings::Level]) -> Vec<Programme> {
    match kind {
        Kind::Turns | Kind::Series => menu::table(levels),
        Kind::Odometry | Kind::Laps => menu_base::base(),
    }
}

/// The plan that best separates what is in doubt; `None` where nothing has a rival.
pub(crate) fn next(dataset: &Dataset, problem: &Problem, doubts: &[Doubt<'_>]) -> Option<Experiment> {
    let cases = cases(doubts);
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
        .filter_map(|programme| Some((programme, gains(dataset, problem, doubts, programme, &cases)?)))
        .collect();
    // What no plan can separate does not choose between them.
    let separable = |rival: &usize| {
        offers.iter().any(|(_, gains)| gains[*rival].then - gains[*rival].now > GAIN_MIN)
    };
    let mut count: Vec<usize> = (0..mine).filter(separable).collect();
    if count.is_empty() {
        count = (0..mine).collect();
    }
    let worth = |gains: &[Gain]| {
        count.iter().map(|&rival| gains[rival].then.min(ENOUGH)).fold(f64::INFINITY, f64::min)
    };
    let mut best: Option<&(&Programme, Vec<Gain>)> = None;
    for offer in &offers {
        if best.is_none_or(|best| worth(&offer.1) > worth(&best.1)) {
            best = Some(offer);
        }
    }
    let (programme, gains) = best?;
    let named: Vec<(String, Gain)> =
        cases.iter().take(mine).zip(gains).map(|(case, gain)| (case.pair.rival.clone(), *gain)).collect();
    let effect = &first.pair.effect;
    let separates = words::separates(effect, &named);
    let expected_gain = words::gain(effect, &named);
    let mut notes = vec![format!("Tells apart: {}.", separates.join(", ")), format!("It {expected_gain}.")];
    notes.extend(words::why(programme));
    let decided = cases.iter().zip(gains).filter(|(_, gain)| gain.probability >= DECIDES);
    Some(Experiment {
        name: programme.name.to_owned(),
        plan_toml: plan::toml(programme, &notes),
        separates,
        expected_gain,
        lambda: count.iter().map(|&rival| gains[rival].then).fold(f64::INFINITY, f64::min),
        by_rival: named.iter().map(|(rival, gain)| (rival.clone(), gain.then)).collect(),
        decided: decided.map(|(case, _)| case.pair.clone()).collect(),
    })
}

/// Does a term add to the rate, so that a bias test would take a part of it away?
fn is_bias(acts: Acts) -> bool {
    matches!(acts, Acts::Bias | Acts::DeadZone | Acts::Noise)
}

/// Effects with rivals, the strongest first.
fn cases(doubts: &[Doubt<'_>]) -> Vec<Case> {
    let mut doubtful: Vec<(usize, usize, &Found)> = doubts
        .iter()
        .enumerate()
        .flat_map(|(doubt, one)| {
            one.fit.effects.iter().enumerate().map(move |(index, found)| (doubt, index, found))
        })
        .filter(|(_, _, found)| !found.rivals.is_empty())
        .collect();
    doubtful.sort_by(|a, b| b.2.strength.total_cmp(&a.2.strength));
    let mut cases = Vec::new();
    for (doubt, index, found) in doubtful {
        for rival in &found.rivals {
            if cases.len() < PAIRS_MAX {
                cases.extend(case(doubt, doubts[doubt], index, &rival.shape));
            }
        }
    }
    cases
}

fn valued(found: &Found) -> Valued {
    let coefficients = found.coefficients.iter().map(|(value, _)| *value).collect();
    Valued { shape: found.shape.clone(), coefficients }
}

fn case(index: usize, doubt: Doubt<'_>, effect: usize, rival: &Shape) -> Option<Case> {
    let Doubt { data, fit } = doubt;
    let all: Vec<Valued> = fit.base.iter().chain(&fit.effects).map(valued).collect();
    let at = fit.base.len() + effect;
    let mut rest = all.clone();
    let found = rest.remove(at);
    let mut shapes: Vec<_> = rest.iter().map(|valued| valued.shape.clone()).collect();
    shapes.push(rival.clone());
    let refitted = fit_terms(data, &shapes, &fit.noise, &fit.left_out);
    let mut other: Vec<Valued> = refitted.iter().map(valued).collect();
    let instead = other.pop().filter(|valued| !valued.coefficients.is_empty())?;
    let contests = [
        Contest { rest, truth: found.clone(), instead: instead.clone() },
        Contest { rest: other, truth: instead.clone(), instead: found.clone() },
    ];
    let whitener = Whitener::new(data.layout, &fit.noise, &fit.left_out);
    let sigma = sigma(data, &all, &whitener);
    let given = [0, 1].map(|way: usize| contests[way].seen(data, &whitener, sigma, false));
    let now = lambda(&[&given[0]]).min(lambda(&[&given[1]]));
    Some(Case {
        pair: Pair {
            effect: found.shape.name.clone(),
            axis: data.block.axis,
            rival: rival.name.clone(),
            drivers: rival.drivers.iter().map(ToString::to_string).collect(),
        },
        doubt: index,
        // The test that refuses one cause asks what the other adds to it.
        widths: [found.shape.width(), instead.shape.width()],
        contests,
        given,
        now,
    })
}

/// Standard deviation of what the model leaves, whitened.
fn sigma(data: Data<'_>, terms: &[Valued], whitener: &Whitener) -> f64 {
    let mut basis = Basis::default();
    for column in terms.iter().flat_map(|valued| data.columns(&valued.shape)) {
        basis.push(whitener.apply(&column));
    }
    let mut white = whitener.apply(&data.block.residual);
    basis.project(&mut white);
    let used: Vec<f64> = white.into_iter().filter(|value| *value != 0.0).collect();
    robust::spread(&used).max(f64::MIN_POSITIVE)
}

/// What `programme` brings to each case; `None` where data of this kind see nothing of it.
fn gains(
    dataset: &Dataset,
    problem: &Problem,
    doubts: &[Doubt<'_>],
    programme: &Programme,
    cases: &[Case],
) -> Option<Vec<Gain>> {
    let thermal = Thermal::of(dataset);
    let phases = timeline::phases(programme, thermal);
    let celsius = |phase: &timeline::Phase, time: f64| {
        thermal.after(phase.celsius, phase.ambient, time - phase.start)
    };
    let interval = problem.channels.interval();
    let mut gains = vec![None; cases.len()];
    for (index, doubt) in doubts.iter().enumerate() {
        if cases.iter().all(|case| case.doubt != index) {
            continue;
        }
        let given = doubt.data.block;
        let rows = planned::planned(dataset, interval, given.axis, &phases, celsius)?;
        let mut ahead = Problem::new(&rows.dataset, problem.counts_per_unit).ok()?;
        complete(&mut ahead.channels, &rows.dataset, doubt.data.channels);
        let block = ahead.blocks.iter().find(|block| block.label == given.label)?;
        let layout = Layout::new(block, &ahead.channels);
        let noise = noise_of_means(&doubt.fit.noise, given, block, rows.samples, layout.runs());
        let whitener = Whitener::new(&layout, &noise, &[]);
        let data = Data { block, channels: &ahead.channels, layout: &layout };
        let terms: Vec<Valued> =
            doubt.fit.base.iter().chain(&doubt.fit.effects).map(valued).collect();
        let given_whitener = Whitener::new(doubt.data.layout, &doubt.fit.noise, &doubt.fit.left_out);
        let sigma = sigma(doubt.data, &terms, &given_whitener);
        for (case, gain) in cases.iter().zip(&mut gains).filter(|(case, _)| case.doubt == index) {
            let both = [0, 1].map(|way: usize| {
                let seen = case.contests[way].seen(data, &whitener, sigma, true);
                let then = lambda(&[&case.given[way], &seen]);
                (then, probability(then, case.widths[way]))
            });
            *gain = Some(Gain {
                now: case.now,
                then: both[0].0.min(both[1].0),
                probability: both[0].1.min(both[1].1),
            });
        }
    }
    gains.into_iter().collect()
}

/// Noise of planned rows that are each the mean of `samples`. Coloured noise is stated for the mean duration of the
/// rows of a block, which may be another in the planned one.
fn noise_of_means(
    noise: &NoiseModel,
    given: &Block,
    planned: &Block,
    samples: f64,
    runs: usize,
) -> NoiseModel {
    let mut noise = noise.clone();
    noise.run_scale = vec![1.0; runs];
    if planned.aggregate == Aggregate::Level {
        return noise;
    }
    if noise.coloured.is_empty() {
        noise.run_scale = vec![samples.sqrt().recip(); runs];
        return noise;
    }
    noise.white /= samples;
    let duration = |block: &Block| {
        let bias = block.exposure(Acts::Bias)?;
        let sum: f64 = block.rows.iter().map(|&row| bias.per_row[row]).sum();
        Some(sum / block.rows.len().max(1) as f64)
    };
    if let (Some(before), Some(after)) = (duration(given), duration(planned))
        && before > 0.0
    {
        noise.coloured.iter_mut().for_each(|part| part.variance *= (after / before).powi(2));
    }
    noise
}

/// Adds the causes that a plan holds constant: they are no channels of their own there.
fn complete(channels: &mut Channels, rows: &Dataset, given: &Channels) {
    for channel in &given.channels {
        if channels.named(&channel.name).is_some() {
            continue;
        }
        let count = channels.time.len();
        let values: Vec<f64> =
            rows.named(&channel.name).map_or_else(|| vec![0.0; count], |column| column.si().collect());
        let range = (values[0], values[0]);
        let smooth = Smooth { level: values.clone(), slope: vec![0.0; count] };
        channels.channels.push(Channel { values, smooth, range, ..channel.clone() });
    }
}
