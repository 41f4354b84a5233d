//! The record as the search for correlation times of one order sees it.

use super::layout::means;
use super::residual::Residual;
use super::{Layout, NoiseModel, Whitener};
use crate::linear::Normal;
use std::borrow::Cow;
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Observations under many noises, beside columns of their own.
#[derive(Clone)]
pub(super) struct View<'a> {
    seen: Rc<Seen<'a>>,
    /// Further columns.
    more: Vec<Vec<f64>>,
}

/// Equations under noises that were asked for, the last first.
type Known = Vec<(NoiseModel, Rc<Equations>)>;

/// What views of the same observations share.
struct Seen<'a> {
    of: Part,
    layout: Cow<'a, Layout>,
    values: Cow<'a, [f64]>,
    columns: Cow<'a, [Vec<f64>]>,
    left_out: Cow<'a, [bool]>,
    /// Variance of its white noise over that of a single observation.
    white: f64,
    /// Information in the whole record over that in the view.
    weight: f64,
    /// Equations under the latest noises, where others will ask for them beside other columns.
    known: Option<RefCell<Known>>,
}

/// The part of the record that a view has.
enum Part {
    Whole,
    /// Means of each group of observations.
    Means(Vec<Range<usize>>),
    Stretch(Range<usize>),
}

/// The observations under a noise.
struct Equations {
    whitener: Whitener,
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    normal: Normal,
}

/// Maximum number of values in the equations that are kept (32 MB).
const VALUES_MAX: usize = 4_000_000;
/// Values of the filter of each observation.
const OF_FILTER: usize = 12;

impl<'a> View<'a> {
    /// All of `of`, without those that are `left_out`; many `others` will be asked for beside further columns.
    pub(super) fn whole(of: Residual<'a>, left_out: &'a [bool], others: bool) -> Self {
        let seen = Seen {
            of: Part::Whole,
            layout: Cow::Borrowed(of.layout),
            values: Cow::Borrowed(of.values),
            columns: Cow::Borrowed(of.columns),
            left_out: Cow::Borrowed(left_out),
            white: 1.0,
            weight: 1.0,
            known: others.then(RefCell::default),
        };
        Self { seen: Rc::new(seen), more: Vec::new() }
    }

    /// Means of every `block` of its observations.
    pub(super) fn means(&self, block: usize) -> Self {
        let Seen { layout, values, columns, left_out, known, .. } = &*self.seen;
        let (thin, groups) = layout.thinned(block);
        let is_out = |i: usize| left_out[i];
        let mean = |values: &[f64]| means(&groups, values, is_out);
        let all_out = groups.iter().map(|range| range.clone().all(is_out)).collect();
        let seen = Seen {
            values: Cow::Owned(mean(values)),
            columns: Cow::Owned(columns.iter().map(|column| mean(column)).collect()),
            left_out: Cow::Owned(all_out),
            white: 1.0 / block as f64,
            weight: 1.0,
            layout: Cow::Owned(thin),
            known: known.is_some().then(RefCell::default),
            of: Part::Means(groups),
        };
        Self { seen: Rc::new(seen), more: Vec::new() }
    }

    /// A stretch of its observations.
    pub(super) fn stretch(&self, range: Range<usize>) -> Self {
        let Seen { layout, values, columns, left_out, known, .. } = &*self.seen;
        let columns = columns.iter().map(|column| column[range.clone()].to_vec()).collect();
        let seen = Seen {
            layout: Cow::Owned(layout.part(range.clone())),
            values: Cow::Owned(values[range.clone()].to_vec()),
            columns: Cow::Owned(columns),
            left_out: Cow::Owned(left_out[range.clone()].to_vec()),
            white: 1.0,
            weight: layout.len() as f64 / range.len() as f64,
            known: known.is_some().then(RefCell::default),
            of: Part::Stretch(range),
        };
        Self { seen: Rc::new(seen), more: Vec::new() }
    }

    /// The same beside `more` columns of the record as well.
    pub(super) fn beside(&self, whole: &Self, more: &[Vec<f64>]) -> Self {
        let left_out = &whole.seen.left_out;
        let of = |column: &Vec<f64>| match &self.seen.of {
            Part::Whole => column.clone(),
            Part::Means(groups) => means(groups, column, |i| left_out[i]),
            Part::Stretch(range) => column[range.clone()].to_vec(),
        };
        Self { seen: Rc::clone(&self.seen), more: more.iter().map(of).collect() }
    }

    /// Logarithm of the likelihood of the record under `noise`.
    pub(super) fn value(&self, noise: &NoiseModel) -> f64 {
        let Seen { layout, values, columns, weight, known, .. } = &*self.seen;
        if known.is_none() && self.more.is_empty() {
            let own = self.seen.own(noise);
            return weight * Residual { layout, values, columns }.log_likelihood(&own);
        }
        let equations = self.seen.equations(noise);
        let Equations { whitener, columns, target, normal } = &*equations;
        let more = whitener.apply_all(&self.more);
        let with_more = normal.with(columns, &more, target);
        let left = with_more.left_of(target, || columns.iter().cloned().chain(more).collect());
        weight * whitener.log_likelihood(left)
    }
}

impl Seen<'_> {
    /// `noise` as it is in the view.
    fn own(&self, noise: &NoiseModel) -> NoiseModel {
        let white = noise.white * self.white;
        NoiseModel { white, left_out: self.left_out.to_vec(), ..noise.clone() }
    }

    fn equations(&self, noise: &NoiseModel) -> Rc<Equations> {
        let mut kept = self.known.iter().map(RefCell::borrow_mut).next();
        let found = kept.as_ref().and_then(|kept| kept.iter().find(|one| one.0 == *noise));
        if let Some((_, found)) = found {
            return Rc::clone(found);
        }
        let whitener = Whitener::new(&self.layout, &self.own(noise));
        let columns = whitener.apply_all(&self.columns);
        let target = whitener.apply(&self.values);
        let normal = Normal::of(&columns, &target);
        let found = Rc::new(Equations { whitener, columns, target, normal });
        if let Some(kept) = &mut kept {
            let size = (self.columns.len() + OF_FILTER) * self.values.len().max(1);
            kept.truncate((VALUES_MAX / size).max(2) - 1);
            kept.insert(0, (noise.clone(), Rc::clone(&found)));
        }
        found
    }
}
