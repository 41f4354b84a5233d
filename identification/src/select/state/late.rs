//! Which of the ways in which readings are late.

use super::{State, is_within_physics};
use crate::candidates::Candidate;
use crate::model::{Acts, Shape, Timing};
use crate::select::refine::refine;
use crate::select::scene::Scene;

/// Gain in log-likelihood from which another way of being late takes the place of one.
const LIKELIER: f64 = 3.0;

/// The way in which `shape` says that readings are late, if it does. A clock that goes wrong does not count: it is rarer by far.
fn way(shape: &Shape) -> Option<Timing> {
    Timing::of(shape).filter(|_| shape.acts != Acts::Clock)
}

impl State<'_> {
    /// Replaces the first term, if it is late, by the likeliest other way of being late, if all numbers at their best make it so: in a
    /// residual that is many times the noise, in which it was chosen, a delay and a lag look the same.
    pub fn retime(&mut self) {
        let index = self.base;
        let Some(mine) = self.terms.get(index).and_then(way) else { return };
        let (scene, _) = self.without(index);
        let others = Self::other_ways(&scene, mine).into_iter().filter_map(|other| {
            let mut next = self.clone();
            next.terms[index] = other.shape;
            next.families[0] = other.family;
            next.refit();
            is_within_physics(&next).then(|| (next.likelihood(), next))
        });
        let best = others.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((likelihood, next)) = best
            && likelihood > self.likelihood() + LIKELIER
        {
            *self = next;
        }
    }

    /// The strongest candidate of each other way of being late.
    fn other_ways(scene: &Scene<'_>, mine: Timing) -> Vec<Candidate> {
        let mut best: Vec<(Timing, f64, &Candidate)> = Vec::new();
        for seen in scene.record.candidates() {
            let Some(way) = way(&seen.candidate.shape).filter(|way| *way != mine) else { continue };
            let statistic = scene.look_at_seen(seen).statistic;
            match best.iter_mut().find(|(known, ..)| *known == way) {
                Some(known) if known.1 >= statistic => {}
                Some(known) => *known = (way, statistic, &seen.candidate),
                None => best.push((way, statistic, &seen.candidate)),
            }
        }
        let refined = |(_, _, candidate): (Timing, f64, &Candidate)| Candidate {
            shape: refine(scene, &candidate.shape),
            family: candidate.family,
        };
        best.into_iter().map(refined).collect()
    }
}
