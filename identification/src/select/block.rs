//! The whole of one block: noise, rounds, refits, rivals.

use super::choose::{Contender, Profile, contenders, plainest_first, profiled, surfaces};
use super::cross;
use super::data::{Data, combine};
use super::record::Record;
use super::refine::refine;
use super::rivals::{RivalFound, rivals};
use super::scene::{Scene, robust_fit};
use super::simplify::simplify;
use crate::candidates::{Candidate, Family};
use crate::lattice;
use crate::model::{Form, Shape};
use crate::noise::Layout;
use crate::noise::{self, NoiseModel, Whitener};
use crate::problem::{Aggregate, Block, Channels};

/// The risk of a false alarm that is taken for a whole data set.
pub const RISK: f64 = 0.005;
/// A term whose removal is less surprising than this goes again (one in a thousand).
const KEEP_MIN: f64 = 6.9;
/// What did not gain on held-out runs is still worth a word if it is stronger than the threshold by this, in nats.
const LEFT_FROM: f64 = 4.0;
/// Contenders that are measured with the noise fitted anew.
const PROFILED: usize = 8;
/// Contenders that are tried one after the other in a round.
const TRIED: usize = 4;

/// An effect that was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// What it is; its numbers at their best.
    pub shape: Shape,
    /// Its coefficients and their standard errors.
    pub coefficients: Vec<(f64, f64)>,
    /// Its other numbers that were fitted, with their standard errors.
    pub numbers: Vec<(String, f64)>,
    /// How surprising it would be in noise, in nats, after the toll.
    pub strength: f64,
    /// What could stand in its place.
    pub rivals: Vec<RivalFound>,
}

/// What came of a block.
#[derive(Debug, Clone)]
pub struct BlockFit {
    /// Terms of the model that was given, with their values.
    pub base: Vec<Found>,
    /// What was added.
    pub effects: Vec<Found>,
    /// The noise that remains.
    pub noise: NoiseModel,
    /// Standard deviation of the white part of the noise, of an observation.
    pub floor: f64,
    /// Strongest candidates that did not pass, with their strength.
    pub left: Vec<Contender>,
    /// Outliers under the final model.
    pub left_out: Vec<bool>,
}

impl BlockFit {
    /// Shapes of the model given and of what was added.
    pub fn shapes(&self) -> Vec<Shape> {
        self.base.iter().chain(&self.effects).map(|found| found.shape.clone()).collect()
    }
}

struct State<'a> {
    record: &'a Record<'a>,
    data: Data<'a>,
    base: usize,
    terms: Vec<Shape>,
    families: Vec<Family>,
    noise: NoiseModel,
    left_out: Vec<bool>,
}

impl<'a> State<'a> {
    /// Columns of the model, derivatives of its numbers included.
    fn columns(&self, terms: &[Shape]) -> Vec<Vec<f64>> {
        let mut columns = self.data.all_columns(terms);
        if terms.iter().any(|term| !term.nonlinear().is_empty()) {
            let whitener = Whitener::new(self.data.layout, &self.noise, &self.left_out);
            let white = whitener.apply_all(&columns);
            let fit = robust_fit(&white, &whitener.apply(&self.data.block.residual));
            let derivatives = self.data.derivatives(terms, &fit.coefficients);
            columns.extend(derivatives.into_iter().map(|derivative| derivative.column));
        }
        columns
    }

    fn scene(&self, terms: &[Shape]) -> Scene<'a> {
        Scene::new(self.record, &self.noise, &self.left_out, &self.columns(terms))
    }

    fn fit_noise(&mut self, anew: bool) {
        let columns = self.columns(&self.terms);
        let start = (!anew).then_some(&self.noise);
        let (noise, left_out) =
            noise::fit(self.data.layout, &self.data.block.residual, &columns, start);
        (self.noise, self.left_out) = (noise, left_out);
    }

    /// Brings the numbers of every term to their best values, with the others in the fit.
    fn refit(&mut self) {
        for index in 0..self.terms.len() {
            let term = &self.terms[index];
            if term.nonlinear().is_empty() && term.form != Form::Delay {
                continue;
            }
            let mut others = self.terms.clone();
            let term = others.remove(index);
            let scene = self.scene(&others);
            self.terms[index] = refine(&scene, &term).0;
        }
    }

    /// Removes what the other terms make superfluous.
    fn prune(&mut self) {
        loop {
            // A constant stays: a wide shape beside it can always stand for it.
            let weakest = (self.base..self.terms.len())
                .filter(|&index| !self.terms[index].drivers.is_empty())
                .map(|index| {
                    let mut others = self.terms.clone();
                    let term = others.remove(index);
                    (self.scene(&others).score(&term).surprise, index)
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match weakest {
                Some((surprise, index))
                    if surprise < KEEP_MIN && self.terms.len() > self.base + 1 =>
                {
                    self.terms.remove(index);
                    self.families.remove(index - self.base);
                }
                _ => break,
            }
        }
    }

    /// The strongest contenders, under white noise and under the noise that fits.
    fn round(&self, threshold: f64) -> Vec<Contender> {
        let scene = self.scene(&self.terms);
        let mut found = contenders(&scene);
        if found.iter().all(|contender| contender.strength < threshold) {
            found.extend(surfaces(&scene));
            found.sort_by(|a, b| b.rank.total_cmp(&a.rank));
        }
        if !self.noise.is_coloured() {
            return found;
        }
        let columns = self.columns(&self.terms);
        let (noise, likelihood) = noise::retune(
            self.data.layout,
            &self.data.block.residual,
            &columns,
            &self.noise,
            &self.left_out,
        );
        let null =
            Profile { columns: &columns, noise: &noise, left_out: &self.left_out, likelihood };
        // What looks strong where the noise is taken for white.
        let plain = NoiseModel { coloured: Vec::new(), ..self.noise.clone() };
        let white = Scene::new(self.record, &plain, &self.left_out, &columns);
        let naive = contenders(&white);
        let mut seen: Vec<String> = Vec::new();
        let mut profiles: Vec<Contender> = Vec::new();
        for list in [&found, &naive] {
            let mut taken = 0;
            for contender in list.iter() {
                let label = contender.candidate.shape.label();
                let is_constant = contender.candidate.shape.drivers.is_empty();
                if (taken == PROFILED && !is_constant) || contender.strength < threshold - 8.0 {
                    continue;
                }
                if !seen.contains(&label) {
                    seen.push(label);
                    taken += 1;
                    profiles.push(profiled(&scene, &null, contender));
                }
            }
        }
        profiles.sort_by(|a, b| b.rank.total_cmp(&a.rank));
        profiles
    }

    /// Adds what is missing, if anything is; what did not pass comes back.
    fn step(&mut self, threshold: f64) -> Result<(), Vec<Contender>> {
        let mut found = self.round(threshold);
        plainest_first(&mut found, threshold);
        let scene = self.scene(&self.terms);
        let columns = self.data.all_columns(&self.terms);
        let mut failed = Vec::new();
        for contender in
            found.iter().filter(|contender| contender.strength >= threshold).take(TRIED)
        {
            if contender.strength - contender.caution < threshold {
                // The likeliest cause may be noise after all; then, as long as nothing is known to be missing, a less
                // likely one is none either.
                if self.terms.len() == self.base {
                    break;
                }
                continue;
            }
            let mut chosen = vec![contender.candidate.clone()];
            if is_wide(&contender.candidate) {
                let named: Vec<Candidate> = found
                    .iter()
                    .filter(|other| !is_wide(&other.candidate))
                    .map(|other| other.candidate.clone())
                    .collect();
                if let Some(narrow) = simplify(&scene, &contender.candidate.shape, &named) {
                    chosen = narrow;
                }
            }
            let new: Vec<Vec<f64>> =
                chosen.iter().flat_map(|candidate| self.data.columns(&candidate.shape)).collect();
            if cross::gain(&scene, &columns, &new) <= 0.0 {
                if contender.strength > threshold + LEFT_FROM {
                    failed.push(contender.clone());
                }
                continue;
            }
            for candidate in chosen {
                self.terms.push(candidate.shape);
                self.families.push(candidate.family);
            }
            return Ok(());
        }
        Err(failed)
    }
}

fn is_wide(candidate: &Candidate) -> bool {
    matches!(candidate.shape.form, Form::Spline | Form::Surface)
        || (candidate.family == Family::Smooth && !candidate.shape.known)
}

/// Finds what the `base` terms lack to explain a block. `share` of the risk of a false alarm is this block's.
pub fn identify_block(
    data: Data<'_>,
    base: Vec<Shape>,
    share: f64,
    effects_max: usize,
    known_noise: Option<&NoiseModel>,
    progress: &mut dyn FnMut(f64),
) -> BlockFit {
    let threshold = -(RISK * share).ln();
    let record = Record::new(data);
    let mut state = State {
        record: &record,
        data,
        base: base.len(),
        terms: base,
        families: Vec::new(),
        noise: NoiseModel::white(data.layout.runs()),
        left_out: Vec::new(),
    };
    if let Some(noise) = known_noise {
        state.noise = NoiseModel { run_scale: vec![1.0; data.layout.runs()], ..noise.clone() };
    } else {
        state.fit_noise(true);
    }
    let mut left = Vec::new();
    for round in 0..2 * effects_max {
        progress(round as f64 / (round as f64 + 2.0));
        if state.terms.len() >= state.base + effects_max {
            break;
        }
        let before = state.terms.clone();
        match state.step(threshold) {
            Ok(()) => {
                state.refit();
                if known_noise.is_none() {
                    state.fit_noise(true);
                }
                state.refit();
                state.prune();
                // What was added went again: the next round would be this one.
                if state.terms == before {
                    break;
                }
            }
            Err(failed) => {
                left = failed;
                break;
            }
        }
    }
    finish(&state, left)
}

/// The block with the rounding of a coarse lattice taken out, as far as `base` predicts the readings; and the step.
pub fn without_rounding(
    block: &Block,
    channels: &Channels,
    base: &[Shape],
) -> Option<(Block, f64)> {
    if block.aggregate != Aggregate::Row {
        return None;
    }
    let step = lattice::step(&block.raw)? * block.raw_si.abs();
    let mut working = block.clone();
    let mut corrected = None;
    for _ in 0..6 {
        let layout = Layout::new(&working, channels);
        let data = Data { block: &working, channels, layout: &layout };
        let noise = NoiseModel::white(layout.runs());
        let fitted: Vec<(Vec<Vec<f64>>, Vec<f64>)> = fit_terms(data, base, &noise, &[])
            .iter()
            .map(|found| {
                let values = found.coefficients.iter().map(|(value, _)| *value).collect();
                (data.columns(&found.shape), values)
            })
            .collect();
        let mut left = block.residual.clone();
        for (columns, values) in &fitted {
            for (value, fitted) in left.iter_mut().zip(combine(columns, values)) {
                *value -= fitted;
            }
        }
        let predicted: Vec<f64> =
            left.iter().enumerate().map(|(i, left)| block.measured(i) - left).collect();
        let found = lattice::correct(&left, &predicted, step)?;
        // The corrected rest, with what the model explains put back.
        working.residual = found
            .residual
            .iter()
            .zip(&left)
            .zip(&block.residual)
            .map(|((corrected, left), residual)| corrected + residual - left)
            .collect();
        working.spread.clone_from(&found.spread);
        corrected = Some(());
    }
    corrected.map(|()| (working, step))
}

/// `terms` fitted as they are.
pub fn fit_terms(
    data: Data<'_>,
    terms: &[Shape],
    noise: &NoiseModel,
    left_out: &[bool],
) -> Vec<Found> {
    let whitener = Whitener::new(data.layout, noise, left_out);
    let white = whitener.apply_all(&data.all_columns(terms));
    let fit = robust_fit(&white, &whitener.apply(&data.block.residual));
    let mut at = 0;
    terms
        .iter()
        .map(|shape| {
            let width = data.columns(shape).len();
            let coefficients =
                (at..at + width).map(|i| (fit.coefficients[i], fit.errors[i])).collect();
            at += width;
            Found {
                shape: shape.clone(),
                coefficients,
                numbers: Vec::new(),
                strength: 0.0,
                rivals: Vec::new(),
            }
        })
        .collect()
}

fn finish(state: &State<'_>, left: Vec<Contender>) -> BlockFit {
    let data = state.data;
    let whitener = Whitener::new(data.layout, &state.noise, &state.left_out);
    let target = whitener.apply(&data.block.residual);
    let columns = data.all_columns(&state.terms);
    let mut white = whitener.apply_all(&columns);
    let linear = white.len();
    let first = robust_fit(&white, &target);
    let derivatives = data.derivatives(&state.terms, &first.coefficients);
    // The numbers are at their best, so that what is left has nothing along the derivatives: they only widen the
    // errors of the rest.
    let fitted = combine(&white, &first.coefficients);
    let residual: Vec<f64> = if fitted.is_empty() {
        target.clone()
    } else {
        target.iter().zip(&fitted).map(|(t, f)| t - f).collect()
    };
    white.extend(derivatives.iter().map(|derivative| whitener.apply(&derivative.column)));
    if let Some(closing) = &data.block.closing {
        // The lever comes from the same ends of laps: where they lie says little of how large their error is.
        let fitted = combine(&columns, &first.coefficients);
        let by_lever = |(fitted, component): (&f64, &usize)| match component {
            0 => 0.0,
            _ => *fitted,
        };
        let by_lever: Vec<f64> = fitted.iter().zip(&closing.component).map(by_lever).collect();
        // Where there is no term, there is nothing for the lever to act on.
        if !by_lever.is_empty() {
            white.push(whitener.apply(&by_lever));
        }
    }
    let errors = robust_fit(&white, &residual).errors;
    let mut at = 0;
    let mut found = Vec::new();
    for (index, shape) in state.terms.iter().enumerate() {
        let width = data.columns(shape).len();
        let coefficients =
            (at..at + width).map(|i| (first.coefficients[i], errors[i])).collect::<Vec<_>>();
        at += width;
        let numbers = derivatives
            .iter()
            .enumerate()
            .filter(|(_, derivative)| derivative.term == index)
            .map(|(i, derivative)| (derivative.name.to_owned(), errors[linear + i]))
            .collect();
        found.push(Found {
            shape: shape.clone(),
            coefficients,
            numbers,
            strength: 0.0,
            rivals: Vec::new(),
        });
    }
    for index in state.base..state.terms.len() {
        let mut others = state.terms.clone();
        let effect = others.remove(index);
        let scene = state.scene(&others);
        let family = state.families[index - state.base];
        let score = scene.score(&effect);
        let strength = score.surprise - family.toll(None);
        let mine =
            Contender::new(Candidate { shape: effect, family }, score, strength, scene.free());
        found[index].strength = strength;
        found[index].rivals = rivals(&scene, &mine, &contenders(&scene));
    }
    let scene = state.scene(&state.terms);
    let effects = found.split_off(state.base);
    BlockFit {
        base: found,
        effects,
        noise: state.noise.clone(),
        floor: scene.scale * state.noise.white.sqrt(),
        left,
        left_out: state.left_out.clone(),
    }
}
