//! Constants of a drive that the walk of its noise takes for itself.

use super::State;
use crate::select::choose::Contender;
use crate::select::scene::Score;
use crate::significance::surprise;

/// Observations of a run up to which a steady drift and a walk look alike: a few references.
const FEW: usize = 12;

impl State<'_> {
    /// Constants, measured with the noise fitted anew beside each. Where the reference knows little more than the ends of a run, noise
    /// that was fitted without a constant walks as far as it drifts, and leaves nothing of it.
    pub(super) fn beside_walks(&self) -> Vec<Contender> {
        let (layout, runs) = (self.data.layout, self.data.layout.runs());
        let free = runs as f64 - self.terms.len() as f64 - 1.0;
        if !layout.is_poses() || layout.len() > FEW * runs || free < 2.0 {
            return Vec::new();
        }
        let likelihood = |columns: &[Vec<f64>]| {
            let residual = self.data.residual(columns);
            let mut noise = residual.fit();
            // Only then are likelihoods those of the same observations.
            noise.left_out.clear();
            residual.log_likelihood(&noise)
        };
        let columns = self.columns(&self.terms);
        let without = likelihood(&columns);
        let constants = self.record.candidates().iter().map(|seen| &seen.candidate);
        let constants = constants.filter(|one| one.shape.drivers.is_empty());
        constants
            .map(|candidate| {
                let with = [columns.clone(), self.data.columns(&candidate.shape)].concat();
                let gain = (likelihood(&with) - without).max(0.0);
                // A ratio of likelihoods as one of variances, of which there is one in each run.
                let ratio = (2.0 * gain / runs as f64).exp_m1() * free;
                let surprise = surprise(ratio, 1.0, free);
                let score = Score { statistic: 2.0 * gain, width: 1, surprise };
                let strength = surprise - candidate.family.toll(None);
                Contender::new(candidate.clone(), score, strength, layout.len() as f64)
            })
            .collect()
    }
}
