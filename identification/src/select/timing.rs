//! Axes of one sensor share their clock and their filter, so they share one delay.

use super::block::BlockFit;
use crate::candidates::Candidate;
use crate::model::{Acts, Driver, Form, Shape, Wrap};

/// A kind of delay: a delay, a filter or a clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing(Acts, Wrap);

impl Timing {
    /// Kind of delay of `shape`, if it is one.
    pub fn of(shape: &Shape) -> Option<Self> {
        let wrap = shape.drivers.first().map_or(Wrap::Plain, |driver| driver.wrap);
        (shape.form == Form::Delay).then_some(Self(shape.acts, wrap))
    }

    /// Removes other kinds of delay from `candidates`.
    pub fn keep(self, candidates: &mut Vec<Candidate>) {
        candidates.retain(|one| Self::of(&one.shape).is_none_or(|timing| timing == self));
    }

    /// Whether a block has another kind of delay.
    pub fn is_against(self, fit: &BlockFit) -> bool {
        let ways: Vec<Self> = fit.effects.iter().filter_map(|one| Self::of(&one.shape)).collect();
        !ways.is_empty() && !ways.contains(&self)
    }
}

/// Whether `shape` is a plain delay.
pub fn is_delay(shape: &Shape) -> bool {
    Timing::of(shape) == Some(Timing(Acts::Delay, Wrap::Plain))
}

/// Whether one of `terms` already states the delay, the lag or the hysteresis of `shape`. Its size is a number of that
/// term: a second one would repeat it, and the two could balance each other. To first order a delay subtracts the slope of
/// the `rotation`, so an error proportional to that slope repeats it as well.
pub fn is_said_by(terms: &[Shape], shape: &Shape, rotation: &str) -> bool {
    let goes_with_slope = |shape: &Shape| {
        let slope = Driver::new(Wrap::RateOf, rotation);
        shape.acts == Acts::Bias && shape.drivers == [slope]
    };
    let of = |shape: &Shape| match Timing::of(shape) {
        None if goes_with_slope(shape) => Some(Timing(Acts::Delay, Wrap::Plain)),
        timing => timing,
    };
    let timing = of(shape);
    let remembers = matches!(shape.drivers.first(), Some(one) if matches!(one.wrap, Wrap::LagOf | Wrap::BranchOf));
    terms
        .iter()
        .any(|term| (timing.is_some() && of(term) == timing) || (remembers && term.says(shape)))
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

#[cfg(test)]
mod tests {
    use super::{Timing, agreed, is_said_by};
    use crate::model::{Acts, Driver, Form, Shape, Wrap};
    use crate::noise::NoiseModel;
    use crate::select::{BlockFit, Found, RivalFound};

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
            left_out: Vec::new(),
            path: Vec::new(),
            chosen: 0,
            nested: Vec::new(),
            goes: None,
        }
    }

    #[test]
    fn one_is_late_in_one_way_once() {
        let terms = [late(Wrap::LagOf), late(Wrap::Plain)];
        let is_said = |terms: &[Shape], shape: &Shape| is_said_by(terms, shape, "reference");
        assert!(is_said(&terms, &late(Wrap::Plain)));
        assert!(!is_said(&terms[..1], &late(Wrap::Plain)));
        // An error over the slope of the reference is a delay; one over the slope of another field is not.
        let goes_with = |field: &str| {
            let driver = Driver::new(Wrap::RateOf, field);
            Shape::new("rate_dependence", Acts::Bias, driver, Form::Linear)
        };
        assert!(is_said(&terms, &goes_with("reference")));
        assert!(is_said(&[goes_with("reference")], &late(Wrap::Plain)));
        assert!(!is_said(&terms, &goes_with("temperature")));
        // A driver has one hysteresis, of one width.
        let play = |width: f64| {
            let driver = Driver::new(Wrap::BranchOf, "temperature");
            Shape::new("thermal_hysteresis", Acts::Bias, driver, Form::Linear)
                .with("half_width", width)
        };
        assert!(is_said(&[play(1.0)], &play(3.0)));
        // Two axes without delay carry no information on it.
        let constant = Shape { form: Form::Constant, ..late(Wrap::Plain) };
        assert!(!is_said(std::slice::from_ref(&constant), &constant));
    }

    #[test]
    fn axes_agree_on_what_none_excludes() {
        let x = fit(Wrap::Plain, &[(Wrap::LagOf, 1.3)]);
        let y = fit(Wrap::LagOf, &[(Wrap::Plain, 0.2)]);
        let z = fit(Wrap::Plain, &[(Wrap::LagOf, 0.7)]);
        let timing = agreed(&[&y, &x, &z]);
        assert_eq!(timing, Timing::of(&late(Wrap::Plain)));
        let against = |fit: &BlockFit| timing.is_some_and(|timing| timing.is_against(fit));
        assert_eq!([&x, &y, &z].map(against), [false, true, false]);
        // One that excludes all others leaves nothing to agree on; a single axis has no other to agree with.
        assert_eq!(agreed(&[&fit(Wrap::LagOf, &[]), &fit(Wrap::Plain, &[])]), None);
        assert_eq!(agreed(&[&x]), None);
    }
}
