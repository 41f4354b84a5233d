//! The model of a block as it grows, round by round.

mod late;
mod sound;
mod walks;

use super::choose::{
    Contender, Profile, contenders, names_a_cause, plainest_first, profiled, surfaces,
    with_lower_orders, without_superfluous,
};
use super::record::Record;
use super::refine::refine;
use super::scene::{Scene, gain};
use super::simplify::simplify;
use crate::candidates::{Candidate, Family};
use crate::fit::{Data, White, robust_fit};
use crate::model::{Form, Shape, Timing, delay_all, is_said_by};
use crate::noise::{NoiseModel, Tuning};
pub(super) use sound::{is_sound, is_within_physics, settle};

/// A term whose removal is less surprising than this is dropped (one in a thousand).
const KEEP_MIN: f64 = 6.9;
/// Strength above the threshold from which a contender without a held-out gain is still reported, in nats.
const LEFT_FROM: f64 = 4.0;
/// Extra strength required of a term that leaves coloured noise or replaces it, in nats (measured on nulls: it halves the
/// false alarms of short records in coloured noise, and costs one effect in a hundred).
pub(super) const BESIDE_COLOUR: f64 = 2.0;
/// Share of what an unnamed shape explains from which its constant is all that matters.
const LEVEL_SHARE: f64 = 0.95;
/// Number of contenders measured with the noise fitted anew.
const PROFILED: usize = 8;
/// Number of contenders tried in a round.
const TRIED: usize = 4;

/// The model of a block as it grows.
#[derive(Clone)]
pub(super) struct State<'a> {
    pub record: &'a Record<'a>,
    pub data: Data<'a>,
    pub base: usize,
    pub terms: Vec<Shape>,
    pub families: Vec<Family>,
    pub noise: NoiseModel,
}

impl<'a> State<'a> {
    /// Columns of the model, derivatives of its numbers included.
    pub fn columns(&self, terms: &[Shape]) -> Vec<Vec<f64>> {
        let mut columns = self.data.all_columns(terms);
        if terms.iter().any(|term| !term.nonlinear().is_empty() || term.form == Form::Delay) {
            let White { columns: white, target, .. } = self.data.whitened(terms, &self.noise);
            let coefficients = robust_fit(&white, &target).coefficients;
            let derivatives = self.data.derivatives(terms, &coefficients);
            let by_delays = self.data.by_delays(terms, &coefficients);
            let all = derivatives.into_iter().chain(by_delays);
            columns.extend(all.map(|derivative| derivative.column));
        }
        columns
    }

    pub fn add(&mut self, candidate: Candidate) {
        self.terms.push(candidate.shape);
        self.families.push(candidate.family);
    }

    /// Takes an added term out.
    pub fn remove(&mut self, index: usize) -> Shape {
        self.families.remove(index - self.base);
        self.terms.remove(index)
    }

    /// Whitened columns of all terms, and the residual.
    pub fn whitened(&self) -> White {
        self.data.whitened(&self.terms, &self.noise)
    }

    pub fn scene(&self, terms: &[Shape]) -> Scene<'a> {
        Scene::new(self.record, &self.noise, &self.columns(terms))
    }

    /// A term, and the scene of all others.
    pub fn without(&self, index: usize) -> (Scene<'a>, Shape) {
        let mut others = self.terms.clone();
        let term = others.remove(index);
        (self.scene(&others), term)
    }

    /// How strong an added term is in the scene of all others.
    pub fn beside_others(&self, index: usize) -> (Scene<'a>, Contender) {
        let (scene, shape) = self.without(index);
        let (score, family) = (scene.score(&shape), self.families[index - self.base]);
        let strength = score.surprise - family.toll(None);
        let contender = Contender::new(Candidate { shape, family }, score, strength, scene.free());
        (scene, contender)
    }

    pub fn fit_noise(&mut self) {
        let columns = self.columns(&self.terms);
        self.noise = self.data.residual(&columns).fit();
    }

    /// Tunes the numbers of every term to their best values, with the others in the fit.
    pub fn refit(&mut self) {
        if self.terms.iter().any(|term| term.form == Form::Delay) {
            let White { columns, target, .. } = self.whitened();
            let fit = robust_fit(&columns, &target);
            let data = self.data;
            delay_all(&mut self.terms, &fit.coefficients, |term| data.width(term));
        }
        for index in 0..self.terms.len() {
            let term = &self.terms[index];
            if term.nonlinear().is_empty() && term.form != Form::Delay {
                continue;
            }
            let (scene, term) = self.without(index);
            self.terms[index] = refine(&scene, &term);
        }
    }

    /// Removes terms that the others make superfluous.
    pub fn prune(&mut self) {
        loop {
            // A constant stays: a wide shape beside it can always replace it.
            let weakest = (self.base..self.terms.len())
                .filter(|&index| !self.terms[index].drivers.is_empty())
                .map(|index| {
                    let (scene, term) = self.without(index);
                    (scene.score(&term).surprise, index)
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match weakest {
                Some((surprise, index))
                    if surprise < KEEP_MIN && self.terms.len() > self.base + 1 =>
                {
                    self.remove(index);
                }
                _ => break,
            }
        }
    }

    /// With the noise tuned to it.
    pub fn likelihood(&self) -> f64 {
        let columns = self.columns(&self.terms);
        self.data.residual(&columns).retune(&self.noise).1
    }

    /// Replaces each added term by the named one that ranks higher beside all others, if there is one (sequential
    /// replacement; Miller 2002, chapter 3): a term was chosen without those that came later.
    pub fn exchange(&mut self, threshold: f64) {
        let rotation = &self.data.channels.rotation_name;
        for index in self.base..self.terms.len() {
            let mut others = self.terms.clone();
            let term = others.remove(index);
            if others.iter().any(|other| term.is_lower_order_of(other)) {
                continue;
            }
            let scene = self.scene(&others);
            let found = contenders(&scene);
            // By its name as well: several causes of a drive have the same form.
            let is_mine = |one: &&Contender| {
                let shape = &one.candidate.shape;
                shape.label() == term.label() && shape.name == term.name
            };
            let Some(mine) = found.iter().find(is_mine) else { continue };
            // A shape that is level is its constant, however certain the rest of it may be.
            let is_level = |one: &Contender| {
                let constant = &one.candidate.shape;
                !term.known
                    && constant.drivers.is_empty()
                    && constant.acts == term.acts
                    && one.score.statistic > LEVEL_SHARE * mine.score.statistic
            };
            let better = found.iter().find(|one| {
                (one.rank > mine.rank || is_level(one))
                    && names_a_cause(&one.candidate)
                    && one.strength >= threshold
                    && !others.iter().any(|other| one.candidate.shape.label() == other.label())
                    && !is_said_by(&others, &one.candidate.shape, rotation)
            });
            let Some(better) = better else { continue };
            let gain = if is_level(better) { f64::INFINITY } else { better.rank - mine.rank };
            let mut next = self.clone();
            next.terms[index] = better.candidate.shape.clone();
            next.families[index - self.base] = better.candidate.family;
            if is_within_physics(&next) {
                next.refit();
                // Its rank is that under the noise of the model before. Under its own it may not lose as much.
                if is_within_physics(&next) && next.likelihood() - self.likelihood() > -gain {
                    *self = next;
                }
            }
        }
    }

    /// Takes the penalty for multiple testing off a smooth function of a driver that a term has already: it is the one
    /// test whether that term's form is right.
    fn complete(&self, found: &mut [Contender]) {
        let added = &self.terms[self.base..];
        for contender in found.iter_mut().filter(|one| one.candidate.family == Family::Smooth) {
            let shape = &contender.candidate.shape;
            if added.iter().any(|term| term.acts == shape.acts && term.drivers == shape.drivers) {
                let toll = contender.score.surprise - contender.strength;
                contender.strength += toll;
                contender.rank += toll;
            }
        }
        found.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    }

    /// Terms that `simpler` lacks and that are as certain as a contender that must be reported as left: held-out runs may
    /// be too few to show what they gain.
    pub fn surely_beyond(&self, simpler: &[Shape], threshold: f64) -> Vec<Contender> {
        let lacking = (self.base..self.terms.len())
            .filter(|&index| !simpler.iter().any(|term| term.says(&self.terms[index])));
        lacking
            .map(|index| self.beside_others(index).1)
            .filter(|one| one.strength > threshold + LEFT_FROM)
            .collect()
    }

    /// The strongest contenders, under white noise and under the noise that fits.
    pub fn round(&self, threshold: f64) -> Vec<Contender> {
        let scene = self.scene(&self.terms);
        let mut found = contenders(&scene);
        self.complete(&mut found);
        let mut groups = with_lower_orders(&scene, &self.terms);
        if found.iter().all(|contender| contender.strength < threshold) {
            found.extend(surfaces(&scene));
            found.sort_by(|a, b| b.rank.total_cmp(&a.rank));
        }
        if !self.noise.is_coloured() {
            if found.iter().all(|contender| contender.strength < threshold) {
                found.extend(self.beside_walks());
            }
            found.extend(groups);
            without_superfluous(&mut found);
            return found;
        }
        let columns = self.columns(&self.terms);
        let tuning = Tuning::new(self.data.residual(&columns), &self.noise.left_out);
        let (noise, likelihood) = tuning.retune(&self.noise);
        let null = Profile { columns: &columns, noise: &noise, tuning: &tuning, likelihood };
        // Contenders that look strong under white noise.
        let plain = NoiseModel { coloured: Vec::new(), ..self.noise.clone() };
        let white = Scene::new(self.record, &plain, &columns);
        let mut naive = contenders(&white);
        self.complete(&mut naive);
        groups.extend(with_lower_orders(&white, &self.terms));
        let mut seen: Vec<String> = Vec::new();
        let mut profiles: Vec<Contender> = Vec::new();
        for list in [&found, &naive, &groups] {
            let mut taken = 0;
            for contender in list.iter() {
                let label: String =
                    contender.all().map(|candidate| candidate.shape.label()).collect();
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
        without_superfluous(&mut profiles);
        profiles
    }

    /// Adds the missing term, if any, and fits the noise again unless it `is_known`; returns the contenders that did not
    /// pass.
    pub fn step(&mut self, threshold: f64, is_known: bool) -> Result<(), Vec<Contender>> {
        let mut found = self.round(threshold);
        let rotation = &self.data.channels.rotation_name;
        found.retain(|one| {
            !one.all().any(|candidate| is_said_by(&self.terms, &candidate.shape, rotation))
        });
        plainest_first(&mut found, threshold);
        let scene = self.scene(&self.terms);
        let columns = self.data.all_columns(&self.terms);
        let mut failed = Vec::new();
        for contender in
            found.iter().filter(|contender| contender.strength >= threshold).take(TRIED)
        {
            if contender.strength - contender.caution < threshold {
                // The likeliest cause may be noise after all; then, as long as no term was added, a less likely one is
                // noise too.
                if self.terms.len() == self.base {
                    break;
                }
                continue;
            }
            let mut chosen: Vec<Candidate> = contender.all().cloned().collect();
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
            if gain(&scene, &columns, &new) <= 0.0 {
                if contender.strength > threshold + LEFT_FROM {
                    failed.push(contender.clone());
                }
                continue;
            }
            let mut next = self.clone();
            // A bump or a sigmoid with its middle outside the data can balance a constant, and a filter a delay.
            let is_narrow = chosen.iter().any(|one| {
                let shape = &one.shape;
                (!shape.known && shape.width() == 1) || Timing::of(shape).is_some()
            });
            chosen.into_iter().for_each(|candidate| next.add(candidate));
            let is_balanced = is_narrow && !is_sound(&next, self.terms.len());
            if !is_within_physics(&next) || is_balanced {
                continue;
            }
            next.refit();
            // The refit may have moved its numbers out of their physical range.
            if !is_within_physics(&next) {
                continue;
            }
            if !is_known {
                next.fit_noise();
                // Slow noise beside the term, or in its place, may well be the whole of it.
                let is_sure = contender.strength >= threshold + BESIDE_COLOUR;
                let has_rival = self.noise.is_coloured() || next.noise.is_coloured();
                if has_rival && !is_sure {
                    continue;
                }
            }
            next.refit();
            *self = next;
            return Ok(());
        }
        Err(failed)
    }
}

fn is_wide(candidate: &Candidate) -> bool {
    matches!(candidate.shape.form, Form::Spline | Form::Surface)
        || (candidate.family == Family::Smooth && !candidate.shape.known)
}
