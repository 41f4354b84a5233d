//! Selects the observations of a measurement, sorted by time.

use super::figure::{Refusal, too_few};
use super::jackknife::Together;
use crate::observation::{Observations, Observed};
use crate::quantities::{OPEN_TAG, SINCE_PREFIX, during_tag, is_undecided};
use crate::quantity::{Filter, QuantityName};
use crate::speakers::OfMessage;
use std::cmp::Ordering;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub(super) at: f64,
    pub(super) sample: Sample,
}

/// A position, and the direction of its lap if known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Position {
    pub(super) x: Sample,
    pub(super) y: Sample,
    pub(super) direction: Option<f64>,
}

/// The observations that a measurement means.
#[derive(Debug, Clone, Copy)]
pub struct Meant<'a> {
    /// What is observed.
    pub quantity: &'a QuantityName,
    /// The quantity that it is judged with.
    pub second: Option<&'a QuantityName>,
    /// Tags that both must have.
    pub filter: &'a Filter,
    /// The step or label during which both were observed.
    pub during: Option<&'a str>,
    /// Since when the time before the first message counts.
    pub since: Option<&'a str>,
    /// Fewest observations of the first.
    pub least: usize,
    /// The most that a value may be. A reaction, or a gap between messages, that was still open when the run ended, and
    /// had lasted no longer than this, is not judged: it might have ended in time.
    pub most: Option<f64>,
}

/// The observations of a measurement.
#[derive(Debug, Clone)]
pub struct Selection<'a> {
    least: usize,
    /// Whether the observations' own uncertainties are ignored.
    is_exact: bool,
    first: Vec<Observed<'a>>,
    second: Vec<Observed<'a>>,
    /// The longest that a reaction had waited which is not judged.
    open: Option<f64>,
    /// Whether the values are times between messages, which fill the run.
    are_periods: bool,
}

impl<'a> Selection<'a> {
    /// Those of `observations` that are meant. These may contain other quantities and be in any order.
    pub fn new(meant: &Meant<'_>, observations: &'a Observations) -> Self {
        let during = meant.during.map(during_tag);
        let of = |quantity: &QuantityName| {
            let mut chosen: Vec<_> = observations
                .of(quantity.as_str())
                .filter(|o| meant.filter.matches(|tag| o.tag(tag)))
                .filter(|o| {
                    let is_during = |tag: &String| o.tag(tag).is_some_and(|value| value != 0.0);
                    during.as_ref().is_none_or(is_during)
                })
                .collect();
            // They usually are sorted, and sorting takes memory.
            if !chosen.is_sorted_by(|a, b| order(a, b).is_le()) {
                chosen.sort_by(order);
            }
            chosen
        };
        let mut first = of(meant.quantity);
        let second = meant.second.map(of).unwrap_or_default();
        let is_of_step = meant.during.is_some() || meant.filter.tags().next().is_some();
        let is_open = |one: &Observed<'_>| {
            one.tag(OPEN_TAG)
                .is_some_and(|open| is_undecided(open, one.value(), meant.most, is_of_step))
        };
        let open = first.iter().filter(|one| is_open(one)).map(Observed::value).reduce(f64::max);
        if open.is_some() {
            first.retain(|one| !is_open(one));
        }
        let open = open.filter(|_| meant.quantity.reaction().is_some());
        let of_message = meant.quantity.of_message();
        let are_periods = matches!(of_message, Some(OfMessage::Period { .. }));
        if are_periods {
            first.retain(|one| {
                let since = one.others().find_map(|(tag, _)| tag.strip_prefix(SINCE_PREFIX));
                since.is_none() || since == meant.since
            });
        }
        Self { least: meant.least, is_exact: false, first, second, open, are_periods }
    }

    /// The same selection without the observations' own uncertainties.
    pub fn taken_as_exact(&self) -> Self {
        Self { is_exact: true, ..self.clone() }
    }

    fn sample(&self, observed: &Observed<'_>) -> Sample {
        let uncertainty = if self.is_exact { 0.0 } else { observed.uncertainty() };
        Sample { value: observed.value(), uncertainty }
    }

    /// Number of observations of the measurement's own quantity.
    pub fn count(&self) -> usize {
        self.first.len()
    }

    /// Checks that there are enough observations and that all are usable.
    pub fn complete(&self) -> Result<(), Refusal> {
        let count = self.first.len();
        if count == 0 {
            return Err(Refusal::Unset(match self.open {
                None => "no observation".to_owned(),
                Some(waited) => {
                    format!("no answer in the {waited:.3} s until the run ended")
                }
            }));
        }
        for chosen in [&self.first, &self.second] {
            let unusable = chosen.iter().filter(|o| !is_usable(o)).count();
            if unusable > 0 {
                let all = chosen.len();
                return Err(Refusal::Fail(format!("{unusable} of {all} observations not finite")));
            }
        }
        let least = self.least;
        if count < least {
            return Err(Refusal::Unset(too_few(count, least)));
        }
        Ok(())
    }

    /// Whether the values are times between messages, which fill the run.
    pub(super) const fn are_periods(&self) -> bool {
        self.are_periods
    }

    pub(super) fn samples(&self) -> Vec<Sample> {
        self.first.iter().map(|o| self.sample(o)).collect()
    }

    pub(super) fn second_samples(&self) -> Vec<Sample> {
        self.second.iter().map(|o| self.sample(o)).collect()
    }

    /// Whether the values are in time order, so that neighbours can be grouped.
    pub(super) fn together(&self) -> Together {
        let is_timed = self.first.iter().all(|o| o.time().is_some());
        if is_timed { Together::InTime } else { Together::Alone }
    }

    /// The values against a tag, sorted by the tag.
    pub(super) fn points(&self, tag: &str) -> Result<Vec<Point>, Refusal> {
        let mut points = self.points_in_time(tag)?;
        // A stable sort: points with the same abscissa stay in time order.
        points.sort_by(|a, b| a.at.total_cmp(&b.at));
        Ok(points)
    }

    /// The values against a tag, in time order.
    pub(super) fn points_in_time(&self, tag: &str) -> Result<Vec<Point>, Refusal> {
        let points: Vec<_> = self
            .first
            .iter()
            .filter_map(|o| {
                let at = o.tag(tag)?;
                at.is_finite().then_some(Point { at, sample: self.sample(o) })
            })
            .collect();
        let lost = self.first.len() - points.len();
        if lost > 0 {
            let all = self.first.len();
            return Err(Refusal::Fail(format!("{lost} of {all} observations without `{tag}`")));
        }
        Ok(points)
    }

    /// The two quantities joined by the tags `run` and `direction`; several of the same run and direction are paired in
    /// time order.
    pub(super) fn positions(&self) -> Result<Vec<Position>, Refusal> {
        let (mut xs, mut ys) = (self.first.clone(), self.second.clone());
        xs.sort_by(order_of_pairs);
        ys.sort_by(order_of_pairs);
        let joined = xs.len() == ys.len() && xs.iter().zip(&ys).all(|(x, y)| same_run(x, y));
        if !joined {
            return Err(Refusal::Fail("positions that lack x or y".to_owned()));
        }
        let position = |(x, y): (&Observed<'_>, &Observed<'_>)| Position {
            x: self.sample(x),
            y: self.sample(y),
            direction: x.tag("direction"),
        };
        Ok(xs.iter().zip(&ys).map(position).collect())
    }
}

fn is_usable(observed: &Observed<'_>) -> bool {
    let (value, uncertainty) = (observed.value(), observed.uncertainty());
    value.is_finite() && uncertainty.is_finite() && uncertainty >= 0.0
}

/// By time, then value, so that sums do not depend on the order of arrival.
fn order(a: &Observed<'_>, b: &Observed<'_>) -> Ordering {
    order_of_tag(a, b, "time")
        .then_with(|| a.value().total_cmp(&b.value()))
        .then_with(|| a.uncertainty().total_cmp(&b.uncertainty()))
        .then_with(|| order_of_tags(a, b))
}

fn order_of_tags(a: &Observed<'_>, b: &Observed<'_>) -> Ordering {
    let others = |(tag, value)| (tag, rank(value));
    a.others().map(others).cmp(b.others().map(others))
}

fn order_of_pairs(a: &Observed<'_>, b: &Observed<'_>) -> Ordering {
    order_of_tag(a, b, "run")
        .then_with(|| order_of_tag(a, b, "direction"))
        .then_with(|| order_of_tag(a, b, "time"))
}

fn same_run(a: &Observed<'_>, b: &Observed<'_>) -> bool {
    order_of_tag(a, b, "run").then_with(|| order_of_tag(a, b, "direction")).is_eq()
}

fn order_of_tag(a: &Observed<'_>, b: &Observed<'_>, tag: &str) -> Ordering {
    let key = |o: &Observed<'_>| o.tag(tag).map(rank);
    key(a).cmp(&key(b))
}

/// A whole number in the order of `f64::total_cmp`.
fn rank(value: f64) -> i64 {
    let bits = value.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}
