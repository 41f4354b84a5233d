//! Pairs of an effect and a rival, and what the given rows say about them.

use super::contest::{Contest, Triangle, lambda};
use crate::dataset::Axis;
use crate::fit::{Data, Found, RivalFound, fit_terms};
use crate::linear::Basis;
use crate::noise::Whitener;
use crate::robust;
use crate::select::BlockFit;

/// Maximum number of pairs, taken from the strongest effect on.
const PAIRS_MAX: usize = 12;

/// An effect and a rival.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair {
    /// Name of the effect.
    pub effect: String,
    /// Axis of the gyro.
    pub axis: Option<Axis>,
    /// Name of the rival.
    pub rival: String,
    /// What the rival sees.
    pub drivers: Vec<String>,
}

/// A fitted block with its effects.
#[derive(Clone, Copy)]
pub(crate) struct Doubt<'a> {
    pub data: Data<'a>,
    pub fit: &'a BlockFit,
}

/// A pair with both contests and what the given rows say about them.
pub(crate) struct Case {
    pub(super) pair: Pair,
    /// Index of its block.
    pub doubt: usize,
    /// The effect true, and the rival true.
    pub(super) contests: [Contest; 2],
    /// Number of columns of the true cause in each contest.
    pub widths: [usize; 2],
    /// What the given rows say.
    pub(super) given: [Triangle; 2],
    /// Standard deviation of the whitened noise.
    pub sigma: f64,
    /// The distance on the given rows.
    pub now: f64,
    /// Whether the rival was found to be behind the effect.
    pub is_behind: bool,
}

/// Effects with rivals, the strongest first.
pub(crate) fn cases(doubts: &[Doubt<'_>]) -> Vec<Case> {
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
                cases.extend(case(doubt, doubts[doubt], index, rival));
            }
        }
    }
    cases
}

fn case(index: usize, doubt: Doubt<'_>, effect: usize, rival: &RivalFound) -> Option<Case> {
    let RivalFound { shape: rival, behind } = rival;
    let Doubt { data, fit } = doubt;
    let all = fit.all();
    let at = fit.base.len() + effect;
    let mut rest = all.clone();
    let found = rest.remove(at);
    let mut shapes: Vec<_> = rest.iter().map(|found| found.shape.clone()).collect();
    shapes.push(rival.clone());
    let mut other = fit_terms(data, &shapes, &fit.noise);
    let instead = other.pop().filter(|found| !found.coefficients.is_empty())?;
    let contests = [
        Contest { rest, truth: found.clone(), instead: instead.clone() },
        Contest { rest: other, truth: instead.clone(), instead: found.clone() },
    ];
    let whitener = Whitener::new(data.layout, &fit.noise);
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
        sigma,
        now,
        is_behind: *behind > 0.0,
    })
}

/// Standard deviation of the whitened residual.
fn sigma(data: Data<'_>, terms: &[Found], whitener: &Whitener) -> f64 {
    let mut basis = Basis::default();
    for column in terms.iter().flat_map(|found| data.columns(&found.shape)) {
        basis.push(whitener.apply(&column));
    }
    let mut white = whitener.apply(&data.block.residual);
    basis.project(&mut white);
    let used: Vec<f64> = white.into_iter().filter(|value| *value != 0.0).collect();
    robust::spread(&used).max(f64::MIN_POSITIVE)
}
