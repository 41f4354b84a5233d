//! Search for the parts of a noise: views of the record propose correlation times, the whole record judges them.

use super::residual::Residual;
use super::view::View;
use super::whiten::COLOURED_MAX;
use super::{Coloured, Layout, NoiseModel};
use std::cell::RefCell;

/// Maximum number of coloured parts; more explain nothing further.
const PARTS_MAX: usize = 3;
/// Gain in log-likelihood required of a coloured part (two parameters).
const PART_GAIN_MIN: f64 = 3.0;
/// Longest correlation time, as a share of the longest stretch: slower noise is a constant, and constants are causes,
/// not noise.
const CORRELATION_MAX: f64 = 0.5;
/// Number of observations above which the search uses means of several, and a stretch of single ones.
const WHOLE_MAX: usize = 5000;
/// Observations of a thinned record.
const THINNED: usize = 2500;
/// Decades of the variance that a walk adds between observations, over that of the white noise.
const WALKS: (i32, i32) = (-8, 5);
/// A correlation time shows in the thinned record from this multiple of its interval on.
const SHOWS_FROM: f64 = 4.0;

/// Searches for the coloured parts and the walk of a noise.
pub(super) struct Search<'a> {
    /// The record itself: the views only propose.
    whole: View<'a>,
    /// Likelihoods computed so far.
    known: RefCell<Vec<(NoiseModel, f64)>>,
    /// View for short correlation times.
    fine: View<'a>,
    /// View for long ones, if the record is too long to use whole.
    coarse: Option<(View<'a>, f64)>,
    correlations: Vec<f64>,
    unit: f64,
    is_level: bool,
    span: f64,
    mean_activity: f64,
}

impl<'a> Search<'a> {
    /// A search in `of`, without what is `left_out`; many `others` will follow beside further columns.
    pub(super) fn new(of: Residual<'a>, left_out: &'a [bool], others: bool) -> Self {
        let (layout, n) = (of.layout, of.layout.len());
        let whole = View::whole(of, left_out, others);
        // On levels a coloured part is a rate; its variance is scaled so that 1 adds much in one step.
        let unit = if layout.is_level() { layout.interval().powi(-2) * 1e-2 } else { 1.0 };
        let mut search = Self {
            known: RefCell::default(),
            fine: whole.clone(),
            whole,
            coarse: None,
            correlations: correlations(layout),
            unit,
            is_level: layout.is_level(),
            span: layout.span(),
            mean_activity: layout.mean_activity(),
        };
        if n > WHOLE_MAX && !layout.is_level() {
            let block = n.div_ceil(THINNED);
            let shows_from = SHOWS_FROM * block as f64 * layout.interval();
            search.coarse = Some((search.whole.means(block), shows_from));
            // Single observations, in the middle of the record.
            let from = (n - WHOLE_MAX) / 2;
            search.fine = search.whole.stretch(from..from + WHOLE_MAX);
        }
        search
    }

    /// The same beside `more` columns.
    pub(super) fn beside(&self, more: &[Vec<f64>]) -> Self {
        let of = |view: &View<'a>| view.beside(&self.whole, more);
        Self {
            whole: of(&self.whole),
            known: RefCell::default(),
            fine: of(&self.fine),
            coarse: self.coarse.as_ref().map(|(view, from)| (of(view), *from)),
            correlations: self.correlations.clone(),
            ..*self
        }
    }

    /// Whether the record is so long that only the final decision uses all of it.
    pub(super) const fn proposes_by_views(&self) -> bool {
        self.coarse.is_some()
    }

    /// Log-likelihood of the whole record.
    pub(super) fn on_whole(&self, noise: &NoiseModel) -> f64 {
        if let Some((_, value)) = self.known.borrow().iter().find(|(known, _)| known == noise) {
            return *value;
        }
        let value = self.whole.value(noise);
        self.known.borrow_mut().push((noise.clone(), value));
        value
    }

    /// The view in which a correlation time shows.
    fn view(&self, correlation_s: f64) -> &View<'a> {
        match &self.coarse {
            Some((coarse, from)) if correlation_s >= *from => coarse,
            _ => &self.fine,
        }
    }

    /// The best positive factor for a parameter, from a coarse search over decades and a fine one.
    fn best(
        &self,
        view: &View<'_>,
        (from, to): (i32, i32),
        set: impl Fn(f64) -> NoiseModel,
    ) -> (f64, f64) {
        let at = |exponent: f64| {
            let value = 10_f64.powf(exponent);
            (view.value(&set(value)), exponent)
        };
        let best = (from..=to)
            .map(|exponent| at(f64::from(exponent)))
            .fold((f64::NEG_INFINITY, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        let best = finer(best, &[0.5, 0.25, 0.12], at);
        (best.0, 10_f64.powf(best.1))
    }

    /// Fits the walk of levels.
    pub(super) fn walk(&self, noise: &mut NoiseModel) {
        let unit = 1.0 / self.mean_activity;
        let set = |ratio: f64| NoiseModel { walk: ratio * unit, ..noise.clone() };
        noise.walk = self.best(&self.fine, WALKS, set).1 * unit;
    }

    /// Fits the walks of poses, each beside the others; near those of `noise`, if they are `known`. The heading comes first: its
    /// walk takes the position with it, and beside a position that walks already it would find nothing to explain.
    pub(super) fn walks(&self, noise: &mut NoiseModel, known: bool) {
        let unit = 1.0 / self.mean_activity;
        let set = |noise: &NoiseModel, which: usize, exponent: f64| {
            let (value, mut noise) = (10_f64.powf(exponent) * unit, noise.clone());
            match (which, &mut noise.slide) {
                (1 | 2, Some(slide)) => slide[which - 1] = value,
                _ => noise.walk = value,
            }
            noise
        };
        let mut exponents = [noise.walk, 0.0, 0.0];
        exponents[1..].copy_from_slice(&noise.slide.unwrap_or_default());
        let mut exponents = exponents.map(|walk| (walk / unit).max(f64::MIN_POSITIVE).log10());
        let order = [(0, known), (1, known), (2, known), (0, true), (1, true), (2, true)];
        let mut known = None;
        for (which, is_near) in order {
            let at = |exponent: f64| (self.fine.value(&set(noise, which, exponent)), exponent);
            // The best of one walk is where the next begins.
            let now = known.map_or_else(|| at(exponents[which]), |value| (value, exponents[which]));
            let best = if is_near {
                finer(now, &[1.0, 0.5, 0.25, 0.12], at)
            } else {
                let (from, to) = WALKS;
                let every = (from..=to).step_by(2).map(|exponent| at(f64::from(exponent)));
                let best = every.fold(now, |a, b| if b.0 > a.0 { b } else { a });
                finer(best, &[1.0, 0.5, 0.25, 0.12], at)
            };
            (exponents[which], known) = (best.1, Some(best.0));
            *noise = set(noise, which, best.1);
        }
    }

    /// Adds coloured parts while they pay, then tunes all and drops those that no longer pay.
    pub(super) fn parts(&self, noise: &mut NoiseModel) {
        self.tune(noise, PART_GAIN_MIN);
        let most = if self.is_level { 1 } else { PARTS_MAX.min(COLOURED_MAX) };
        while noise.coloured.len() < most {
            let Some(part) = self.proposals(noise).into_iter().find(|part| self.pays(noise, *part))
            else {
                break;
            };
            let count = noise.coloured.len();
            noise.coloured.push(part);
            self.tune(noise, PART_GAIN_MIN);
            if noise.coloured.len() <= count {
                break;
            }
        }
        noise.coloured.sort_by(|a, b| a.correlation_s.total_cmp(&b.correlation_s));
    }

    /// Parts of each correlation time that pay in their view, best first.
    fn proposals(&self, noise: &NoiseModel) -> Vec<Coloured> {
        let fine_now = self.fine.value(noise);
        let coarse_now = self.coarse.as_ref().map(|(view, _)| view.value(noise));
        let mut found: Vec<(f64, Coloured)> = Vec::new();
        for &correlation_s in &self.correlations {
            let view = self.view(correlation_s);
            let now = match coarse_now {
                Some(value) if !std::ptr::eq(view, &self.fine) => value,
                _ => fine_now,
            };
            let with = |variance: f64| {
                let mut noise = noise.clone();
                noise.coloured.push(Coloured { correlation_s, variance: variance * self.unit });
                noise
            };
            // A quick check first: most correlation times gain nothing.
            let quick = [0.0005, 0.005, 0.05, 0.5, 5.0].map(|variance| view.value(&with(variance)));
            if quick.iter().all(|value| *value < now + 0.5) {
                continue;
            }
            let (value, variance) = self.best(view, (-5, 3), with);
            let part = Coloured { correlation_s, variance: variance * self.unit };
            if value - now > PART_GAIN_MIN {
                found.push((value - now, part));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, part)| part).collect()
    }

    /// Whether a part pays on the whole record. What a stretch shows may be chance.
    fn pays(&self, noise: &NoiseModel, part: Coloured) -> bool {
        if self.coarse.is_none() {
            return true;
        }
        let mut with = noise.clone();
        with.coloured.push(part);
        self.on_whole(&with) - self.on_whole(noise) > PART_GAIN_MIN
    }

    /// Tries much smaller parts first: an effect may explain all that a part stood for.
    pub(super) fn shrink(&self, noise: &mut NoiseModel) {
        for k in 0..noise.coloured.len() {
            let view = self.view(noise.coloured[k].correlation_s);
            let mut now = view.value(noise);
            for factor in [0.3, 0.1, 0.03, 0.01] {
                let mut tried = noise.clone();
                tried.coloured[k].variance *= factor;
                let value = view.value(&tried);
                if value > now {
                    (*noise, now) = (tried, value);
                }
            }
        }
    }

    /// Tunes the parts to their best values and drops those that gain less than `price`.
    pub(super) fn tune(&self, noise: &mut NoiseModel, price: f64) {
        let before = noise.clone();
        for step in [3.0, 1.8, 1.3] {
            for k in 0..noise.coloured.len() {
                let view = self.view(noise.coloured[k].correlation_s);
                let mut now = view.value(noise);
                for factor in [step, 1.0 / step] {
                    for which in 0..2 {
                        let mut tried = noise.clone();
                        if which == 0 {
                            tried.coloured[k].variance *= factor;
                        } else {
                            tried.coloured[k].correlation_s *= factor;
                            let now = tried.coloured[k].correlation_s;
                            if now.is_finite() && now > CORRELATION_MAX * self.span {
                                continue;
                            }
                        }
                        let value = view.value(&tried);
                        if value > now {
                            (*noise, now) = (tried, value);
                        }
                    }
                }
            }
        }
        if noise.coloured.is_empty() {
            return;
        }
        let mut now = self.on_whole(noise);
        if self.coarse.is_some() && *noise != before {
            let untuned = self.on_whole(&before);
            if now < untuned {
                (*noise, now) = (before, untuned);
            }
        }
        let mut k = 0;
        while k < noise.coloured.len() {
            let mut without = noise.clone();
            without.coloured.remove(k);
            let value = self.on_whole(&without);
            if value > now - price {
                (*noise, now) = (without, value);
            } else {
                k += 1;
            }
        }
    }
}

/// The best of `best` and what lies beside it, in steps that get smaller.
fn finer(best: (f64, f64), steps: &[f64], at: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    let mut best = best;
    for step in steps {
        for side in [best.1 - step, best.1 + step] {
            let tried = at(side);
            if tried.0 > best.0 {
                best = tried;
            }
        }
    }
    best
}

/// Correlation times to try.
fn correlations(layout: &Layout) -> Vec<f64> {
    let (interval, span) = (layout.interval(), layout.span());
    let mut found = Vec::new();
    let mut at = if layout.is_level() { 10.0 * interval } else { 2.0 * interval };
    while at < CORRELATION_MAX * span {
        found.push(at);
        at *= if layout.is_level() { 10.0 } else { 10_f64.sqrt() };
    }
    if !layout.is_level() && layout.runs() >= 4 {
        found.push(f64::INFINITY);
    }
    found
}
