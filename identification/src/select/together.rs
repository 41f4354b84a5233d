//! What several quantities of one data set settle together: axes of one sensor share their clock and their filter, so they
//! share one delay; and all have a few causes at most.

use super::found::BlockFit;
use super::gain::fall;
use crate::fit::Found;
use crate::model::Timing;

/// Whether a block has another kind of delay than `timing`.
pub fn is_against(timing: Timing, fit: &BlockFit) -> bool {
    let of = |found: &Found| Timing::of(&found.shape);
    let ways: Vec<Timing> = fit.effects.iter().filter_map(of).collect();
    !ways.is_empty() && !ways.contains(&timing)
}

/// The likeliest kind of delay for all late axes, if there is one that none excludes.
pub fn agreed(fits: &[&BlockFit]) -> Option<Timing> {
    let ways: Vec<Vec<(Timing, f64)>> = fits
        .iter()
        .filter_map(|fit| fit.effects.iter().find(|one| Timing::of(&one.shape).is_some()))
        .map(|found| {
            let rivals = found.rivals.iter().map(|rival| (&rival.shape, rival.behind));
            std::iter::once((&found.shape, 0.0))
                .chain(rivals)
                .filter_map(|(shape, behind)| Some((Timing::of(shape)?, behind)))
                .collect()
        })
        .collect();
    if ways.len() < 2 {
        return None;
    }
    let behind = |timing: Timing| -> Option<f64> {
        let of = |way: &Vec<(Timing, f64)>| {
            way.iter().filter(|(its, _)| *its == timing).map(|way| way.1).reduce(f64::min)
        };
        ways.iter().map(of).sum()
    };
    let all = ways[0].iter().filter_map(|(timing, _)| Some((*timing, behind(*timing)?)));
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(timing, _)| timing)
}

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
                Some((fall(&path[earlier].metrics, &path[at[block]].metrics), block, earlier))
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

#[cfg(test)]
mod tests {
    use super::{BlockFit, Found, Timing, agreed, is_against};
    use crate::fit::RivalFound;
    use crate::model::{Acts, Driver, Form, Shape, Wrap};
    use crate::noise::NoiseModel;

    fn late(wrap: Wrap) -> Shape {
        Shape::new("any", Acts::Delay, Driver::new(wrap, "reference"), Form::Delay)
    }

    /// A block that is late by `wrap`, or in another way that many nats behind.
    fn fit(wrap: Wrap, rivals: &[(Wrap, f64)]) -> BlockFit {
        let rival =
            |(wrap, behind): &(Wrap, f64)| RivalFound { shape: late(*wrap), behind: *behind };
        BlockFit {
            base: Vec::new(),
            effects: vec![Found {
                shape: late(wrap),
                coefficients: Vec::new(),
                numbers: Vec::new(),
                strength: 10.0,
                rivals: rivals.iter().map(rival).collect(),
            }],
            applied: Vec::new(),
            noise: NoiseModel::white(1),
            floor: 1.0,
            scale: 1.0,
            left: Vec::new(),
            path: Vec::new(),
            chosen: 0,
            nested: Vec::new(),
            goes: None,
        }
    }

    #[test]
    fn axes_agree_on_what_none_excludes() {
        let x = fit(Wrap::Plain, &[(Wrap::LagOf, 1.3)]);
        let y = fit(Wrap::LagOf, &[(Wrap::Plain, 0.2)]);
        let z = fit(Wrap::Plain, &[(Wrap::LagOf, 0.7)]);
        let timing = agreed(&[&y, &x, &z]);
        assert_eq!(timing, Timing::of(&late(Wrap::Plain)));
        let against = |fit: &BlockFit| timing.is_some_and(|timing| is_against(timing, fit));
        assert_eq!([&x, &y, &z].map(against), [false, true, false]);
        // One that excludes all others leaves nothing to agree on; a single axis has no other to agree with.
        assert_eq!(agreed(&[&fit(Wrap::LagOf, &[]), &fit(Wrap::Plain, &[])]), None);
        assert_eq!(agreed(&[&x]), None);
    }
}
