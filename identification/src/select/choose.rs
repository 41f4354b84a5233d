//! One round: decides whether anything is missing, and what.
use super::period::{loudness, periods};
use super::refine::refine;
use super::scene::{NOTHING, Scene, Score};
use crate::candidates::{Candidate, Family, narrow_on};
use crate::fit::Data;
use crate::linear::{Basis, dot};
use crate::model::{Acts, Shape, WHEEL_SIZE, Wrap, is_delay};
use crate::noise::{NoiseModel, TIME_CAUTION, Tuning};
use crate::significance::surprise_chi2;

/// A candidate with its numbers at their best.
#[derive(Debug, Clone)]
pub struct Contender {
    pub candidate: Candidate,
    /// What it explains.
    pub score: Score,
    /// Surprise minus the penalty for multiple testing, in nats.
    pub strength: f64,
    /// Strength minus half the logarithm of the observations for each number fitted besides the coefficients (Schwarz);
    /// ranks contenders.
    pub rank: f64,
    /// Extra strength required beyond the threshold, in nats.
    pub caution: f64,
    /// Lower-order terms that come with it, since they determine its zero.
    pub beside: Vec<Candidate>,
}

impl Contender {
    /// A contender ranked among `observations`.
    pub fn new(candidate: Candidate, score: Score, strength: f64, observations: f64) -> Self {
        let numbers = candidate.shape.nonlinear().len() as f64;
        let rank = strength - 0.5 * numbers * observations.ln() + simplicity(&candidate.shape);
        Self { candidate, score, strength, rank, caution: 0.0, beside: Vec::new() }
    }

    /// All candidates that it adds.
    pub fn all(&self) -> impl Iterator<Item = &Candidate> {
        self.beside.iter().chain(std::iter::once(&self.candidate))
    }

    /// Columns of all candidates that it adds.
    fn columns(&self, data: Data<'_>) -> Vec<Vec<f64>> {
        self.all().flat_map(|candidate| data.columns(&candidate.shape)).collect()
    }
}

/// Preference for the simplest physical cause where others do as well, in nats: a constant over any function, a delay over
/// a filter or an error that goes with the slope, which to first order are the same.
const SIMPLEST: f64 = 2.0;

/// The same for two wheels that are wrong by the same: a wheel is easily measured, and where it touches the ground is not, so
/// that of two causes that the data do not tell apart the track is the usual one (Borenstein and Feng 1996).
const RARE: f64 = 1.0;

/// Preference for `shape` over less simple ones, in nats.
pub(super) fn simplicity(shape: &Shape) -> f64 {
    match shape.drivers.is_empty() {
        true if shape.name == WHEEL_SIZE => RARE,
        true => SIMPLEST,
        false if is_delay(shape) => SIMPLEST,
        false => 0.0,
    }
}

/// Number of contenders in a family to refine.
const REFINED: usize = 3;
/// Surprise of a spline from which hinges and bumps are tried.
const NARROW_FROM: f64 = 5.0;
/// Maximum distance of that spline behind the best named effect.
const NARROW_BEHIND: f64 = 4.0;
/// Number of contenders measured on every row.
const EXACT: usize = 12;
/// Extra strength required of a cause that only follows time, and of an unnamed shape, if the noise is coloured, in
/// nats.
const NATS_OF_TIME: f64 = 0.5;
const NATS_OF_SHAPE: f64 = 1.0;

/// Measures every candidate in `scene`; strongest first.
pub fn contenders(scene: &Scene<'_>) -> Vec<Contender> {
    let data = scene.data;
    let mut scored: Vec<(Candidate, Score, f64)> = Vec::new();
    let mut look = |candidate: &Candidate, score: Score, tests: f64| {
        if score.width > 0 {
            let toll = candidate.family.toll(Some(tests));
            scored.push((candidate.clone(), score, score.surprise - toll));
        }
    };
    let every = scene.record.candidates();
    for family in [Family::Library, Family::Memory, Family::Smooth, Family::Pair, Family::Step] {
        let tests = family.tests(every.iter().map(|seen| &seen.candidate));
        for seen in every.iter().filter(|seen| seen.candidate.family == family) {
            look(&seen.candidate, scene.look_at_seen(seen), tests);
        }
    }
    let (found, tests) = periods(scene);
    for candidate in &found {
        look(candidate, scene.look(&candidate.shape), tests);
    }
    let is_wave = |one: &&mut (Candidate, Score, f64)| one.0.family == Family::Periodic;
    for (candidate, score, strength) in scored.iter_mut().filter(is_wave) {
        if *strength > 0.0 {
            let loudness = loudness(scene, &candidate.shape);
            *strength -= score.surprise * (1.0 - loudness.recip());
        }
    }
    // If a named effect explains as much as any smooth function of a driver, hinges and bumps add nothing.
    let named = scored
        .iter()
        .filter(|(candidate, _, _)| candidate.shape.known)
        .map(|(_, score, _)| score.surprise)
        .fold(0.0, f64::max);
    let curved: Vec<(Acts, crate::model::Driver)> = scored
        .iter()
        .filter(|(candidate, score, _)| {
            candidate.family == Family::Smooth
                && score.surprise > NARROW_FROM
                && score.surprise > named - NARROW_BEHIND
        })
        .map(|(candidate, _, _)| (candidate.shape.acts, candidate.shape.drivers[0].clone()))
        .collect();
    for (on, driver) in curved {
        for candidate in narrow_on(data.channels, on, &driver) {
            let score = scene.look(&candidate.shape);
            if score.width > 0 {
                let strength = score.surprise - candidate.family.toll(None);
                scored.push((candidate, score, strength));
            }
        }
    }
    refined(scene, scored)
}

/// Powers and products, each with the lower orders that `terms` lack (the principle of marginality, Nelder 1977):
/// alone, its zero would be at the arbitrary middle of the data, and an effect with its zero elsewhere shows in none of
/// its parts.
pub fn with_lower_orders(scene: &Scene<'_>, terms: &[Shape]) -> Vec<Contender> {
    let every: Vec<&Candidate> =
        scene.record.candidates().iter().map(|seen| &seen.candidate).collect();
    let mut found = Vec::new();
    for candidate in &every {
        let is_there = |lower: &Shape| terms.iter().any(|term| term.says(lower));
        // A function of a driver has its zero where a constant puts it.
        let is_lower = |lower: &Shape| {
            let is_constant = lower.drivers.is_empty() && lower.acts == candidate.shape.acts;
            lower.is_lower_order_of(&candidate.shape)
                || (is_constant && candidate.shape.number("origin").is_some())
        };
        let mut beside: Vec<Candidate> = Vec::new();
        for lower in every.iter().filter(|other| is_lower(&other.shape) && !is_there(&other.shape))
        {
            if !beside.iter().any(|one| one.shape.says(&lower.shape)) {
                beside.push((*lower).clone());
            }
        }
        if beside.is_empty() || !candidate.shape.known {
            continue;
        }
        let mut contender = Contender::new((*candidate).clone(), NOTHING, 0.0, scene.free());
        contender.beside = beside;
        contender.score = scene.score_columns(&contender.columns(scene.data));
        contender.strength = contender.score.surprise - Family::Pair.toll(None);
        contender.rank = contender.strength;
        found.push(contender);
    }
    found
}

/// Drops groups in which one term explains the most: that term goes first and the others, if needed, later.
pub fn without_superfluous(contenders: &mut Vec<Contender>) {
    let alone: Vec<(Shape, f64)> = contenders
        .iter()
        .filter(|one| one.beside.is_empty())
        .map(|one| (one.candidate.shape.clone(), one.score.statistic))
        .collect();
    contenders.retain(|group| {
        let says_most = |(shape, statistic): &(Shape, f64)| {
            *statistic > NAMED_SHARE * group.score.statistic
                && group.all().any(|member| member.shape.says(shape))
        };
        group.beside.is_empty() || !alone.iter().any(says_most)
    });
    contenders.sort_by(|a, b| b.rank.total_cmp(&a.rank));
}

/// Puts a named effect first that passes `threshold` and explains a good part of what the strongest contender, an
/// unnamed one, does.
pub fn plainest_first(contenders: &mut Vec<Contender>, threshold: f64) {
    let Some(first) = contenders.first() else { return };
    let most = first.score.statistic;
    let first_is_named = first.candidate.shape.known;
    let is_named = |other: &Contender| {
        names_a_cause(&other.candidate)
            && other.strength > threshold
            && other.score.statistic > NAMED_SHARE * most
    };
    if first_is_named {
        return;
    }
    if let Some(index) = contenders.iter().position(is_named) {
        let plain = contenders.remove(index);
        contenders.insert(0, plain);
    }
}

/// Whether it names a cause: a step or a wave over time only tells when.
pub fn names_a_cause(candidate: &Candidate) -> bool {
    candidate.shape.known && matches!(candidate.family, Family::Library | Family::Memory)
}

/// Share of an unnamed shape's explanation from which a named effect is preferred.
const NAMED_SHARE: f64 = 0.6;

/// Surfaces over two drivers, tried only when nothing else is left.
pub fn surfaces(scene: &Scene<'_>) -> Vec<Contender> {
    let scored = scene
        .record
        .pairs()
        .iter()
        .map(|seen| {
            let (candidate, score) = (&seen.candidate, scene.look_at_seen(seen));
            (candidate.clone(), score, score.surprise - candidate.family.toll(None))
        })
        .collect();
    refined(scene, scored)
}

/// Refines the numbers of the best few of each family and kind of term.
fn refined(scene: &Scene<'_>, mut scored: Vec<(Candidate, Score, f64)>) -> Vec<Contender> {
    scored.sort_by(|a, b| b.2.total_cmp(&a.2));
    let best = scored.first().map_or(0.0, |first| first.2);
    let mut seen: Vec<(String, usize)> = Vec::new();
    let mut found: Vec<Contender> = Vec::new();
    for (mut candidate, mut score, mut strength) in scored {
        let has_numbers = !candidate.shape.nonlinear().is_empty()
            || candidate.shape.form == crate::model::Form::Delay;
        if has_numbers {
            let label = candidate.shape.label();
            let count = match seen.iter_mut().find(|(known, _)| *known == label) {
                Some((_, count)) => count,
                None => {
                    seen.push((label, 0));
                    &mut seen.last_mut().expect("just pushed").1
                }
            };
            *count += 1;
            // Refines only what could still win or be a rival.
            let worth = if candidate.family == Family::Narrow { 6.0 } else { 12.0 };
            if *count <= REFINED && strength > best - worth && score.surprise > 3.0 {
                let toll = score.surprise - strength;
                candidate.shape = refine(scene, &candidate.shape);
                score = scene.look(&candidate.shape);
                strength = score.surprise - toll;
            } else if *count > REFINED {
                continue;
            }
        }
        if holds_back_all(scene, &candidate.shape) {
            found.push(Contender::new(candidate, score, strength, scene.free()));
        }
    }
    found.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    // The best are measured on every row.
    for contender in found.iter_mut().take(EXACT) {
        let toll = contender.score.surprise - contender.strength;
        let score = scene.score(&contender.candidate.shape);
        *contender =
            Contender::new(contender.candidate.clone(), score, score.surprise - toll, scene.free());
    }
    found.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    found
}

/// Maximum deviation of the suppressed part from the whole, unless `HELD_ERRORS` of its standard errors are more.
const HELD_OFF_MAX: f64 = 0.3;
const HELD_ERRORS: f64 = 3.0;

/// Whether `shape` can be a dead zone, by the part of the rate that it would suppress in `scene`: a dead zone suppresses small
/// rates completely, and an effect that suppresses a small part of them is a different one at the same rates. (For a saturation
/// a part is enough: a gyro's gain falls before its limit.)
fn holds_back_all(scene: &Scene<'_>, shape: &Shape) -> bool {
    if shape.acts != Acts::DeadZone {
        return true;
    }
    let columns = scene.data.columns(shape);
    let Some(column) = columns.first() else { return false };
    let mut column = scene.whitener.apply(column);
    scene.project(&mut column);
    let length = dot(&column, &column);
    // Uses the residual, not its scores, which cut off large values.
    let gain = scene.data.channels.gain;
    let part = dot(&column, &scene.white) / length / gain;
    let error = scene.scale / length.sqrt() / gain.abs();
    (part - 1.0).abs() <= HELD_OFF_MAX.max(HELD_ERRORS * error)
}

/// Extra strength for causes that only follow time, which coloured noise imitates easily.
fn caution(candidate: &Candidate, noise: &NoiseModel) -> f64 {
    if !noise.is_coloured() {
        return 0.0;
    }
    let in_time = candidate.shape.drivers.first().is_some_and(|driver| {
        matches!(driver.wrap, Wrap::Step | Wrap::Trend)
            || candidate.shape.form == crate::model::Form::Exponential
    });
    let step = if candidate.family == Family::Step { NATS_OF_TIME } else { 0.0 };
    let shape = if candidate.shape.known { 0.0 } else { NATS_OF_SHAPE };
    step + shape + if in_time { NATS_OF_TIME } else { 0.0 }
}

/// Extra strength required if the noise is coloured, in nats: slow noise looks like a cause that follows only time, or
/// one that is nearly an offset or a trend.
fn caution_of(data: Data<'_>, candidate: &Candidate) -> f64 {
    let is_slow = follows_time(candidate)
        || data.columns(&candidate.shape).iter().any(|column| is_offset_or_trend(column));
    if is_slow { TIME_CAUTION } else { 0.0 }
}

fn follows_time(candidate: &Candidate) -> bool {
    matches!(candidate.family, Family::Step | Family::Periodic)
        || candidate.shape.drivers.first().is_some_and(|driver| driver.wrap == Wrap::Trend)
        || candidate.shape.form == crate::model::Form::Exponential
}

/// Share of a column that an offset and a trend explain, from which it counts as slow.
const SLOW_SHARE: f64 = 0.98;

fn is_offset_or_trend(column: &[f64]) -> bool {
    let n = column.len() as f64;
    let mut basis = Basis::default();
    basis.push(vec![1.0; column.len()]);
    basis.push((0..column.len()).map(|i| i as f64 - (n - 1.0) / 2.0).collect());
    let mut left = column.to_vec();
    basis.project(&mut left);
    dot(&left, &left) < (1.0 - SLOW_SHARE) * dot(column, column)
}

/// Measures a candidate with the noise fitted anew with it and without it: under coloured noise a slow effect and the
/// noise can replace one another.
pub fn profiled(scene: &Scene<'_>, null: &Profile<'_>, contender: &Contender) -> Contender {
    let tuning = null.tuning.beside(&contender.columns(scene.data));
    let (noise, likelihood) = tuning.retune(null.noise);
    let mut null_likelihood = null.likelihood;
    if !scene.record.means.is_empty() {
        // On a long record, slightly better noise gains more than most effects, so both sides get it.
        let also = scene.data.residual(null.columns).priced(&noise);
        null_likelihood = null_likelihood.max(also);
    }
    let gain = (likelihood - null_likelihood).max(0.0);
    let width = contender.score.width.max(1);
    let surprise = surprise_chi2(2.0 * gain, width as f64);
    let toll = contender.score.surprise - contender.strength;
    let mut found = Contender::new(
        contender.candidate.clone(),
        Score { statistic: 2.0 * gain, width, surprise },
        surprise - toll - contender.all().map(|one| caution(one, null.noise)).fold(0.0, f64::max),
        scene.free(),
    );
    found.caution = contender.all().map(|one| caution_of(scene.data, one)).fold(0.0, f64::max);
    found.beside.clone_from(&contender.beside);
    found
}

/// The model without new terms, under noise fitted to it.
pub struct Profile<'a> {
    /// Columns of the model so far.
    pub columns: &'a [Vec<f64>],
    pub noise: &'a NoiseModel,
    pub tuning: &'a Tuning<'a>,
    /// Logarithm of its likelihood.
    pub likelihood: f64,
}
