//! Few causes: those that help least are left out of a finding over several quantities.

use super::found::{BlockFit, Waypoint};

/// Maximum number of causes for each block, so that all have at most `most`; `None` where a block keeps its model. The
/// last step that lowers its block's errors least goes first.
pub fn fewer(fits: &[&BlockFit], most: usize) -> Vec<Option<usize>> {
    let mut at: Vec<usize> = fits.iter().map(|fit| fit.chosen).collect();
    loop {
        let total: usize = fits.iter().zip(&at).map(|(fit, &at)| fit.path[at].causes).sum();
        let before = |block: usize| {
            let path = &fits[block].path;
            (0..at[block]).rev().find(|&earlier| path[earlier].causes < path[at[block]].causes)
        };
        let least = (0..fits.len())
            .filter_map(|block| {
                let earlier = before(block)?;
                let path = &fits[block].path;
                Some((fall(&path[earlier], &path[at[block]]), block, earlier))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((_, block, earlier)) if total > most => at[block] = earlier,
            _ => break,
        }
    }
    let kept = fits.iter().zip(at);
    kept.map(|(fit, at)| (at != fit.chosen).then(|| fit.path[at].causes)).collect()
}

/// Logarithm by which the errors fall from one model to another.
fn fall(before: &Waypoint, after: &Waypoint) -> f64 {
    let pairs = before.metrics.iter().zip(&after.metrics);
    pairs.map(|(a, b)| (a.errors.rmse() / b.errors.rmse().max(f64::MIN_POSITIVE)).ln()).sum()
}
