//! The last step: all numbers of the chosen model at their best together, those that its columns are linear in and the
//! others (Gauss and Newton's method with halved steps; Nocedal and Wright 2006, section 10.3). Until then each was tuned
//! alone, and the errors of all hold only where all are at their best.

use super::limit::is_hard;
use super::state::{State, is_within_physics};
use crate::fit::{Data, Found, Number, RobustFit, Tangent, White, combine, less, robust_fit};
use crate::linear::{Normal, dot};
use crate::model::{Form, Shape, is_threshold, levels};
use crate::noise::Whitener;
use crate::robust;

/// Maximum number of steps, and of halvings of each.
const STEPS: usize = 10;
const HALVINGS: usize = 6;
/// Share of its standard error that no number moves any more.
const SETTLED: f64 = 0.02;

/// How outliers count.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outliers {
    /// Less, by Huber's weights: the residual is noise.
    Less,
    /// As all others that are not left out.
    Alike,
}

impl Outliers {
    fn fit(self, columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
        match self {
            Self::Less => robust_fit(columns, target).coefficients,
            Self::Alike => Normal::of(columns, target).solve(),
        }
    }

    /// Size from which a value counts less, of those that are `left`.
    fn limit(self, left: &[f64]) -> f64 {
        match self {
            Self::Less => robust::HUBER * robust::spread(left),
            Self::Alike => f64::INFINITY,
        }
    }
}

/// A model with all numbers at their best together.
pub(super) struct Joint<'a> {
    pub state: State<'a>,
    pub coefficients: Vec<f64>,
    pub tangents: Vec<Tangent>,
    /// The tangents and what is left of the observations, whitened.
    pub white: Vec<Vec<f64>>,
    pub left: Vec<f64>,
    outliers: Outliers,
    pub whitener: Whitener,
    /// Errors of thresholds.
    thresholds: Vec<(usize, &'static str, f64)>,
    /// Terms that are hard limits: all beyond them is missing.
    pub hard: Vec<usize>,
}

impl<'a> Joint<'a> {
    /// The model of `state` with its numbers at their best; with those that it has if the best are unphysical.
    pub fn new(state: &State<'a>, outliers: Outliers) -> Self {
        let at = || Self::at(state.clone(), outliers);
        let found = at().refined();
        if is_within_physics(&found.state) { found } else { at() }
    }

    /// The model of `state` with the numbers that it has.
    fn at(state: State<'a>, outliers: Outliers) -> Self {
        let white = state.whitened();
        let mut coefficients = outliers.fit(&white.columns, &white.target);
        for (term, places) in state.terms.iter().zip(state.data.places(&state.terms)) {
            let late = term.fixed.first().filter(|_| term.form == Form::Delay);
            if let (Some((_, number)), false) = (late, places.is_empty()) {
                coefficients[places.start] = *number;
            }
        }
        let whitener = white.whitener;
        let (tangents, thresholds) = (Vec::new(), Vec::new());
        let (white, left) = (Vec::new(), Vec::new());
        let hard = Vec::new();
        let mut found = Self {
            state,
            coefficients,
            tangents,
            white,
            left,
            outliers,
            whitener,
            thresholds,
            hard,
        };
        found.look();
        found.harden();
        found
    }

    /// Holds the gain of each limit at that of the readings where they do not tell it.
    fn harden(&mut self) {
        let gain = self.data().channels.gain;
        let noise = robust::spread(&self.left) / gain.abs();
        for (index, places) in self.data().places(&self.state.terms).into_iter().enumerate() {
            let is_mine = |one: &Tangent| one.term == index;
            let mut mine = self.tangents.iter().zip(&self.white).filter(|one| is_mine(one.0));
            if self.state.terms[index].form == Form::Saturation
                && let (Some((_, by_share)), Some((_, by_place))) = (mine.next(), mine.next())
                && is_hard(by_share, by_place, noise)
            {
                self.hard.push(index);
                self.coefficients[places.start] = gain;
            }
        }
        if !self.hard.is_empty() {
            self.look();
        }
    }

    fn data(&self) -> Data<'a> {
        self.state.data
    }

    /// Computes what is left and the tangents.
    fn look(&mut self) {
        let data = self.data();
        self.left = self.whitener.apply(&data.left(&self.state.terms, &self.coefficients));
        self.tangents = data.tangents(&self.state.terms, &self.coefficients);
        let is_held = |one: &Tangent| {
            matches!(one.number, Number::Coefficient(_)) && self.hard.contains(&one.term)
        };
        self.tangents.retain(|one| !is_held(one));
        self.white = self.tangents.iter().map(|one| self.whitener.apply(&one.column)).collect();
    }

    fn refined(mut self) -> Self {
        let is_linear = |one: &Shape| one.nonlinear().is_empty() && one.form != Form::Delay;
        if self.state.terms.iter().all(is_linear) {
            return self;
        }
        let limit = self.outliers.limit(&self.left);
        for _ in 0..STEPS {
            let free = self.free();
            let white: Vec<_> = free.iter().map(|at| self.white[*at].clone()).collect();
            let RobustFit { coefficients, errors, .. } = robust_fit(&white, &self.left);
            let best = match self.outliers {
                Outliers::Less => coefficients,
                Outliers::Alike => self.outliers.fit(&white, &self.left),
            };
            let mut steps = vec![0.0; self.tangents.len()];
            let mut moves = false;
            for ((at, step), error) in free.into_iter().zip(best).zip(errors) {
                steps[at] = step;
                moves |= step.abs() > SETTLED * error;
            }
            if !moves || !self.step(&steps, limit) {
                break;
            }
            self.look();
        }
        self.thresholds = self.threshold_errors();
        self
    }

    /// Tangents along which the model may move. Several smooth curves over one driver describe one unknown curve: their
    /// places and widths mean nothing apart, and at their best together they cancel each other.
    fn free(&self) -> Vec<usize> {
        let terms = &self.state.terms;
        let is_curve = |one: &Shape| matches!(one.form, Form::Bump | Form::Tanh | Form::Hinge);
        let is_one_of_several = |term: &Shape| {
            let alike = |other: &&Shape| is_curve(other) && other.drivers == term.drivers;
            is_curve(term) && terms.iter().filter(alike).count() > 1
        };
        let is_free = |one: &Tangent| {
            !matches!(one.number, Number::Other(_)) || !is_one_of_several(&terms[one.term])
        };
        let all = self.tangents.iter().enumerate();
        all.filter_map(|(at, one)| is_free(one).then_some(at)).collect()
    }

    /// Moves by the largest share of `steps` that leaves less; returns false if none does.
    fn step(&mut self, steps: &[f64], limit: f64) -> bool {
        let now = loss(&self.left, limit);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let model = (&self.state.terms[..], &self.coefficients[..]);
            let (terms, coefficients) = self.data().moved(model, &self.tangents, (steps, share));
            let left = self.whitener.apply(&self.data().left(&terms, &coefficients));
            if loss(&left, limit) < now {
                (self.state.terms, self.coefficients) = (terms, coefficients);
                return true;
            }
            share /= 2.0;
        }
        false
    }

    /// Standard errors of thresholds. The place where the fit is best is that of the largest value of a random walk that
    /// falls on both sides by half of what the jump explains for each unit of the driver; its variance is 26 over the square
    /// of that (Yao 1987; Bai 1997).
    fn threshold_errors(&self) -> Vec<(usize, &'static str, f64)> {
        let scale = robust::spread(&self.left);
        let mut found = Vec::new();
        for (index, name, levels) in thresholds(&self.state) {
            let term = &self.state.terms[index];
            let now = term.number(name).unwrap_or(0.0);
            let above = levels.partition_point(|level| *level < now);
            let (low, high) = (above.saturating_sub(BESIDE), (above + BESIDE).min(levels.len()));
            if low + 1 >= high {
                continue;
            }
            let place = &self.data().places(&self.state.terms)[index];
            let [before, after] = [levels[low], levels[high - 1]].map(|at| {
                let mut moved = term.clone();
                moved.set(name, at);
                combine(&self.data().columns(&moved), &self.coefficients[place.clone()])
            });
            let change = self.whitener.apply(&less(&before, &after));
            let explains =
                dot(&change, &change) / (scale * scale) / (levels[high - 1] - levels[low]);
            found.push((index, name, 26.0_f64.sqrt() / explains));
        }
        found
    }

    /// The terms, where the tangents have these `errors`.
    pub fn found(&self, errors: &[f64]) -> Vec<Found> {
        let places = self.data().places(&self.state.terms);
        let terms = self.state.terms.iter().zip(places);
        let mut found: Vec<Found> = terms
            .map(|(shape, places)| {
                Found::new(
                    shape,
                    self.coefficients[places].iter().map(|one| (*one, f64::NAN)).collect(),
                )
            })
            .collect();
        for (Tangent { term, number, .. }, error) in self.tangents.iter().zip(errors) {
            let found = &mut found[*term];
            match number {
                Number::Coefficient(at) => found.coefficients[*at].1 = *error,
                Number::Late(_) => found.coefficients[0].1 = *error,
                Number::Other(name) => found.numbers.push(((*name).to_owned(), *error)),
            }
        }
        for (term, name, error) in &self.thresholds {
            found[*term].numbers.push(((*name).to_owned(), *error));
        }
        found
    }
}

/// Thresholds of the terms: index of the term, name, and the values of its driver.
fn thresholds(state: &State<'_>) -> Vec<(usize, &'static str, Vec<f64>)> {
    let of = |(index, term): (usize, &Shape)| {
        let name = term.nonlinear().into_iter().find(|name| is_threshold(term, name))?;
        Some((index, name, levels(term, state.data.channels)?))
    };
    state.terms.iter().enumerate().filter_map(of).collect()
}

/// Moves each threshold of `state` to the gap between two values of its driver that leaves least; returns whether any moved.
/// Readings that were left out count: beside a wrong threshold they are far off.
pub(super) fn cross_thresholds(state: &mut State<'_>, outliers: Outliers) -> bool {
    let all = thresholds(state);
    if all.is_empty() {
        return false;
    }
    let data = state.data;
    let White { whitener, columns, target } = data.whitened(&state.terms, &state.noise.of_all());
    let coefficients = outliers.fit(&columns, &target);
    let left = |terms: &[Shape]| whitener.apply(&data.left(terms, &coefficients));
    let limit = outliers.limit(&left(&state.terms));
    let mut moved = false;
    for (index, name, levels) in all {
        let gap = |above: usize| f64::midpoint(levels[above - 1], levels[above]);
        let now = state.terms[index].number(name).unwrap_or(0.0);
        let first = levels.partition_point(|level| *level < now);
        let mut best = (first, f64::INFINITY);
        for stride in STRIDES {
            let middle = best.0;
            for step in -REACH..=REACH {
                let above = middle as i64 + step * stride;
                if above < 1 || above >= levels.len() as i64 {
                    continue;
                }
                let mut terms = state.terms.clone();
                terms[index].set(name, gap(above as usize));
                let loss = loss(&left(&terms), limit);
                if loss < best.1 {
                    best = (above as usize, loss);
                }
            }
        }
        if best.1.is_finite() {
            state.terms[index].set(name, gap(best.0));
            moved |= best.0 != first;
        }
    }
    moved
}

/// Gaps by which a threshold moves at a time, and how many times.
const STRIDES: [i64; 6] = [243, 81, 27, 9, 3, 1];
const REACH: i64 = 3;
/// Values on each side of a threshold over which its jump is seen.
const BESIDE: usize = 10;

/// Half the sum of squares, in which values beyond `limit` count in proportion to their size (Huber 1964).
fn loss(left: &[f64], limit: f64) -> f64 {
    let of = |value: &f64| {
        let size = value.abs();
        if size <= limit { 0.5 * size * size } else { limit * (size - 0.5 * limit) }
    };
    left.iter().map(of).sum()
}
