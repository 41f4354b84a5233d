//! Causes that matter to the user, for a residual that is not noise and has no meaningful probabilities: constants
//! before functions, functions before shapes, each judged by its gain on held-out runs.

use super::found::{Asked, Step};
use super::gain::{BETTER, best_of, fall, matters};
use super::record::Record;
use super::roughly::doubtful;
use super::state::{State, is_sound};
use super::wheels::one_wheel;
use crate::candidates::Candidate;
use crate::fit::{Data, White, combine, less};
use crate::judge::{Judge, Metric};
use crate::linear::{Basis, Normal, dot};
use crate::model::{Form, LATE_SHARE, Shape, delay_all, is_said_by};
use crate::noise::{NoiseModel, Whitener};
use crate::robust::root_mean_square;
use std::cell::OnceCell;

/// Maximum number of observations on which candidates are compared.
const SAMPLE: usize = 6000;
/// Number of shapes, and of cycles of an angle, in a class judged on held-out runs.
const JUDGED: usize = 5;
/// Minimum share of the residual that a candidate must explain to be judged.
const SHARE_MIN: f64 = 0.002;
/// A reading this many times the root mean square off is ignored.
const GROSS: f64 = 6.0;
/// Rounds of tuning the numbers of a term.
const SWEEPS: usize = 4;
/// Searches for causes by their benefit to the user.
pub(super) struct Material<'a> {
    data: Data<'a>,
    judge: &'a Judge<'a>,
    candidates: Vec<Candidate>,
    /// Columns of each candidate at the observations on which they are compared.
    sampled: OnceCell<Vec<Vec<Vec<f64>>>>,
}

/// How many times more than a delay a function must lower the error to go before it.
const MUCH_BETTER: f64 = 1.5;

/// Number of classes.
const CLASSES: usize = 3;

/// Class of a shape: what a user would try first goes first. A clock that goes wrong within a record is rarer than a delay.
fn class(shape: &Shape) -> usize {
    let is_late = matches!(shape.form, Form::Delay) && shape.acts != crate::model::Acts::Clock;
    let is_alignment = is_late || shape.acts == crate::model::Acts::Axis;
    if shape.drivers.is_empty() || is_alignment {
        0
    } else if shape.known {
        1
    } else {
        2
    }
}

impl<'a> Material<'a> {
    /// A search over the candidates of `record`.
    pub fn new(judge: &'a Judge<'a>, record: &Record<'a>) -> Self {
        let candidates = record.candidates().iter().map(|seen| seen.candidate.clone()).collect();
        Self { data: record.data, judge, candidates, sampled: OnceCell::new() }
    }

    /// Models from `state` on, one term at a time.
    pub fn path<'s>(&self, state: &State<'s>, asked: Asked<'_>) -> Vec<Step<'s>> {
        let mut path = vec![Step::new(self.fitted(state.clone()), self.judge)];
        self.extend(&mut path, self.judge, asked);
        path
    }

    /// Refits the last model of `path` with the readings that counted as outliers and without the terms that could then
    /// be zero, if that predicts better.
    pub fn look_again<'s>(&self, path: &mut Vec<Step<'s>>, judge: &Judge<'_>) {
        let Some(last) = path.last() else { return };
        let mut state = self.fitted(last.state.clone());
        while let Some(index) = doubtful(&state) {
            state.remove(index);
            state = self.fitted(state);
        }
        let again = Step::new(state, judge);
        if fall(&last.metrics, &again.metrics) > BETTER {
            path.push(again);
        }
    }

    /// Continues from the last model of `path`, one term at a time.
    pub fn extend<'s>(&self, path: &mut Vec<Step<'s>>, judge: &Judge<'_>, asked: Asked<'_>) {
        let Some(last) = path.last() else { return };
        let Step { state: mut now, mut metrics } =
            Step::new(self.fitted(last.state.clone()), self.judge);
        while Shape::causes(&now.terms[now.base..]) < asked.effects_max {
            let Some((next, judged)) = self.step(&now, &metrics) else { break };
            (now, metrics) = match one_wheel(&next, true) {
                Some(one) => {
                    let Step { state, metrics } = Step::new(self.fitted(one), self.judge);
                    (state, metrics)
                }
                None => (next, judged),
            };
            path.push(Step::new(now.clone(), judge));
        }
    }

    /// Uses noise that weighs all rows equally; for levels, the noise stays.
    pub fn fitted<'s>(&self, mut state: State<'s>) -> State<'s> {
        if self.data.layout.is_level() {
            state.noise = NoiseModel::walking(self.data.layout);
            return state;
        }
        state.noise = NoiseModel::white(self.data.layout.runs());
        let columns = self.data.all_columns(&state.terms);
        let residual = &self.data.block.residual;
        state.noise.left_out = vec![false; residual.len()];
        for _ in 0..2 {
            let whitener = Whitener::new(self.data.layout, &state.noise);
            let white = whitener.apply_all(&columns);
            let coefficients = Normal::of(&white, &whitener.apply(residual)).solve();
            let errors = less(residual, &combine(&columns, &coefficients));
            let used = errors.iter().zip(&state.noise.left_out).filter(|(_, out)| !**out);
            let used: Vec<f64> = used.map(|(error, _)| *error).collect();
            let limit = GROSS * root_mean_square(&used);
            state.noise.left_out = errors.iter().map(|error| error.abs() > limit).collect();
        }
        state
    }

    /// The model with the most beneficial term, from the first class that has one that matters.
    fn step<'s>(&self, state: &State<'s>, before: &[Metric]) -> Option<(State<'s>, Vec<Metric>)> {
        let scored = self.scored(state);
        let best = |class: usize| {
            let mut judged = self.judged(state, &scored, class);
            judged.retain(|(_, after)| matters(before, after) && fall(before, after) > BETTER);
            best_of(judged, before)
        };
        let (first, (next, after)) = (0..CLASSES).find_map(|class| Some((class, best(class)?)))?;
        // A delay is simple, but what is late may also be a filter, a backlash or a hysteresis.
        if first == 0
            && next.terms.last().is_some_and(|term| term.form == Form::Delay)
            && let Some((other, its)) = best(1)
            && fall(before, &its) > MUCH_BETTER * fall(before, &after)
        {
            return Some((other, its));
        }
        Some((next, after))
    }

    /// The strongest candidates of each class added to `state`, judged.
    pub fn contenders<'s>(&self, state: &State<'s>) -> Vec<(State<'s>, Vec<Metric>)> {
        let scored = self.scored(state);
        (0..CLASSES).flat_map(|class| self.judged(state, &scored, class)).collect()
    }

    /// Candidates by the share of the residual of `state` that they explain, largest first. Constants are always
    /// included: a small share from row to row can be large at the end of a path.
    fn scored(&self, state: &State<'_>) -> Vec<Candidate> {
        let sample = Sample::new(self.data, state);
        let share = |(index, candidate): (usize, &Candidate)| {
            if sample.whitener.is_by_row() {
                sample.share_of(sample.weighed(&self.sampled(&sample.at)[index]))
            } else {
                sample.share(&candidate.shape)
            }
        };
        let rotation = &self.data.channels.rotation_name;
        let is_said = |shape: &Shape| {
            state.terms.contains(shape) || is_said_by(&state.terms, shape, rotation)
        };
        let mut scored: Vec<(f64, &Candidate)> = self
            .candidates
            .iter()
            .enumerate()
            .filter(|(_, candidate)| !is_said(&candidate.shape))
            .map(|one| (share(one), one.1))
            .filter(|(share, candidate)| *share > SHARE_MIN || candidate.shape.drivers.is_empty())
            .collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        let refined = |candidate: &Candidate| Candidate {
            shape: sample.refined(&candidate.shape),
            family: candidate.family,
        };
        let mut labels: Vec<(String, (usize, bool, bool))> = Vec::new();
        let mut found = Vec::new();
        for (_, candidate) in scored {
            let shape = &candidate.shape;
            // Over an angle, cycles and shapes explain much the same, and with a number of its own, such as a time constant, a
            // shape explains more than without: neither takes the other's place.
            let is_tuned = !shape.nonlinear().is_empty();
            let kind = (class(shape), shape.form == Form::Harmonic, is_tuned);
            let label = shape.label();
            let known = labels.iter().any(|(known, _)| *known == label);
            if known || labels.iter().filter(|(_, its)| *its == kind).count() == JUDGED {
                continue;
            }
            labels.push((label, kind));
            found.push(refined(candidate));
        }
        found
    }

    /// Columns of each candidate at the observations `at`, which are the same in every call.
    fn sampled(&self, at: &[usize]) -> &[Vec<Vec<f64>>] {
        self.sampled.get_or_init(|| {
            let picked = |column: &Vec<f64>| at.iter().map(|&i| column[i]).collect();
            let of = |one: &Candidate| self.data.columns(&one.shape).iter().map(picked).collect();
            self.candidates.iter().map(of).collect()
        })
    }

    /// The candidates of a class, each added to `state` and judged.
    fn judged<'s>(
        &self,
        state: &State<'s>,
        scored: &[Candidate],
        of_class: usize,
    ) -> Vec<(State<'s>, Vec<Metric>)> {
        scored
            .iter()
            .filter(|candidate| class(&candidate.shape) == of_class)
            .filter_map(|candidate| {
                let next = self.with(state, candidate)?;
                let judged = self.judge.judge(&next.terms, &next.noise);
                Some((next, judged))
            })
            .collect()
    }

    /// `state` with `candidate` and the lower orders it lacks, all numbers at their best; `None` if the result is
    /// unphysical, balances another term or could be zero.
    fn with<'s>(&self, state: &State<'s>, candidate: &Candidate) -> Option<State<'s>> {
        let mut tried = state.clone();
        // An unnamed shape finds its own zero.
        let is_named = candidate.shape.known;
        let below =
            |other: &&Candidate| is_named && other.shape.is_lower_order_of(&candidate.shape);
        for other in self.candidates.iter().filter(below) {
            if !tried.terms.iter().any(|term| term.says(&other.shape)) {
                tried.add(other.clone());
            }
        }
        tried.add(candidate.clone());
        for _ in 0..SWEEPS {
            if !settle_delays(self.data, &mut tried) {
                break;
            }
        }
        let (mut tried, mut first) = (self.fitted(tried), state.terms.len());
        // What could be zero beside the new terms only stood for them.
        while let Some(index) = doubtful(&tried) {
            if index >= first {
                return None;
            }
            tried.remove(index);
            first -= 1;
            tried = self.fitted(tried);
        }
        is_sound(&tried, first).then_some(tried)
    }
}

/// Share of a delay by which it moves at least.
const MOVED: f64 = 1e-5;

/// Sets the number of each delay to its coefficient; returns false if none moved.
fn settle_delays(data: Data<'_>, state: &mut State<'_>) -> bool {
    if state.terms.iter().all(|term| term.form != Form::Delay) {
        return false;
    }
    let White { whitener, columns, target } = state.whitened();
    let coefficients = Normal::of(&columns, &target).solve();
    // Those that are longer than a sample move by how late it is, and not by how much.
    let long = data.by_delays(&state.terms, &coefficients);
    let mut with_long = columns;
    with_long.extend(long.iter().map(|one| whitener.apply(&one.column)));
    let moves = if long.is_empty() { Vec::new() } else { Normal::of(&with_long, &target).solve() };
    let share = |term: &Shape| term.number(LATE_SHARE).unwrap_or(1.0);
    let before: Vec<f64> = state.terms.iter().map(share).collect();
    delay_all(&mut state.terms, &coefficients, |term| data.width(term));
    let places = data.places(&state.terms);
    let mut moved = false;
    for (index, (term, places)) in state.terms.iter_mut().zip(places).enumerate() {
        if term.form == Form::Delay {
            let name = term.fixed.first().map(|(name, _)| name.clone()).unwrap_or_default();
            let now = term.number(&name).unwrap_or(0.0);
            let by = long.iter().position(|one| one.term == index);
            let by = by.and_then(|i| moves.get(with_long.len() - long.len() + i));
            let sample = data.channels.interval();
            let of_all = coefficients[places.start] * before[index] / share(term);
            let found = by.map_or(of_all, |by| now + by.clamp(-sample, sample));
            let positive = name != "time_constant" || found > now / 4.0;
            let next = if positive { found } else { now / 4.0 };
            if next.is_finite() && next != 0.0 && (next - now).abs() > MOVED * now.abs() {
                term.set(&name, next);
                moved = true;
            }
        }
    }
    moved
}

/// A part of the observations, with the model so far subtracted.
struct Sample<'a> {
    data: Data<'a>,
    at: Vec<usize>,
    whitener: Whitener,
    basis: Basis,
    left: Vec<f64>,
    total: f64,
}

impl<'a> Sample<'a> {
    fn new(data: Data<'a>, state: &State<'_>) -> Self {
        let whitener = Whitener::new(data.layout, &state.noise);
        let n = data.block.residual.len();
        let stride = n.div_ceil(SAMPLE).max(1);
        let at: Vec<usize> = (0..n).step_by(stride).collect();
        let mut found =
            Self { data, at, whitener, basis: Basis::default(), left: Vec::new(), total: 0.0 };
        let columns = found.picked(&data.all_columns(&state.terms));
        found.basis.extend(columns);
        let mut left = found.picked(std::slice::from_ref(&data.block.residual)).remove(0);
        found.basis.project(&mut left);
        found.basis.project(&mut left);
        found.total = dot(&left, &left).max(f64::MIN_POSITIVE);
        found.left = left;
        found
    }

    fn picked(&self, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let pick = |column: &Vec<f64>| self.at.iter().map(|&i| column[i]).collect();
        if self.whitener.is_by_row() {
            let columns: Vec<Vec<f64>> = columns.iter().map(pick).collect();
            return self.weighed(&columns);
        }
        self.whitener.apply_all(columns).iter().map(pick).collect()
    }

    /// Columns at the observations of the sample, weighted.
    fn weighed(&self, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let weights = self.whitener.weights();
        let weigh = |column: &Vec<f64>| {
            column.iter().zip(&self.at).map(|(value, &i)| value * weights[i]).collect()
        };
        columns.iter().map(weigh).collect()
    }

    /// Share of the residual that `shape` explains.
    fn share(&self, shape: &Shape) -> f64 {
        self.share_of(self.picked(&self.data.columns(shape)))
    }

    fn share_of(&self, picked: Vec<Vec<f64>>) -> f64 {
        if picked.is_empty() {
            return 0.0;
        }
        self.basis.beyond(picked).explained(&self.left) / self.total
    }

    /// `shape` with its best numbers, searched in factors since only orders of magnitude matter at first.
    fn refined(&self, shape: &Shape) -> Shape {
        let mut best = (self.share(shape), shape.clone());
        for name in shape.nonlinear() {
            for factor in [2.0, 1.3, 1.1] {
                for exponent in [-1.0, 1.0] {
                    while let Some(now) = best.1.number(name) {
                        let mut tried = best.1.clone();
                        let number = now * f64::powf(factor, exponent);
                        tried.set(name, self.data.told(shape, name, number));
                        let share = self.share(&tried);
                        if !(share > best.0 * (1.0 + 1e-6)) {
                            break;
                        }
                        best = (share, tried);
                    }
                }
            }
        }
        best.1
    }
}
