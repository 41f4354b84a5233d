//! How long ago the last message of each kind came, for what a plan measures of the time between two.
//!
//! A gap that is still open is a lower bound: it may break an upper limit, and says nothing else.

use super::observe::{Tags, Waited};
use plan::quantities::{SINCE_START, during_tag};
use plan::{Declared, Plan, Speaker, resolve};
use wire::time::{Span, Timestamp};

/// The messages whose periods the plan measures.
#[derive(Debug, Clone, Default)]
pub(super) struct Gaps {
    each: Vec<Gap>,
    waits: Vec<Wait>,
}

/// The time before the first message, where a measurement says since when it counts.
#[derive(Debug, Clone)]
struct Wait {
    quantity: String,
    /// By speaker and message.
    message: (usize, usize),
    since: String,
    began: Option<Timestamp>,
}

impl Wait {
    fn until(&self, now: Timestamp) -> Option<Waited> {
        let (quantity, since) = (self.quantity.clone(), self.since.clone());
        Some(Waited { quantity, since, seconds: (now - self.began?).as_secs_f64() })
    }
}

#[derive(Debug, Clone)]
struct Gap {
    quantity: String,
    /// By speaker and message.
    message: (usize, usize),
    last: Option<Timestamp>,
    /// The longest that ended since the step began.
    longest: Span,
    judges: Vec<Declared>,
}

impl Gaps {
    /// Those of a run that begins now.
    pub(super) fn of(plan: &Plan, speakers: &[Speaker], now: Timestamp) -> Self {
        let mut gaps: Vec<Gap> = Vec::new();
        let mut waits: Vec<Wait> = Vec::new();
        for declared in &plan.measurements {
            let of = declared.quantity.of_message();
            let place = of.and_then(|of| resolve(speakers, of).ok());
            let Some(place) = place.filter(|place| place.signal.is_none()) else { continue };
            let quantity = declared.quantity.as_str();
            let since = declared.since.as_ref().map(|since| since.as_str().to_owned());
            let is_known = |since: &str| {
                waits.iter().any(|one| one.quantity == quantity && one.since == since)
            };
            if let Some(since) = since.filter(|since| !is_known(since)) {
                let message = (place.speaker, place.message);
                let began = (since == SINCE_START).then_some(now);
                waits.push(Wait { quantity: quantity.to_owned(), message, since, began });
            }
            if let Some(known) = gaps.iter_mut().find(|gap| gap.quantity == quantity) {
                known.judges.push(declared.clone());
                continue;
            }
            gaps.push(Gap {
                quantity: quantity.to_owned(),
                message: (place.speaker, place.message),
                last: None,
                longest: Span::ZERO,
                judges: vec![declared.clone()],
            });
        }
        Self { each: gaps, waits }
    }

    /// A message came. Returns how long it has been waited for, if it is the first.
    pub(super) fn heard(&mut self, now: Timestamp, message: (usize, usize)) -> Vec<Waited> {
        for gap in self.each.iter_mut().filter(|gap| gap.message == message) {
            if let Some(last) = gap.last.replace(now) {
                gap.longest = gap.longest.max(now - last);
            }
        }
        let over = self.waits.extract_if(.., |wait| wait.message == message);
        over.filter_map(|wait| wait.until(now)).collect()
    }

    /// A step ends and another begins. Returns the quantities, and the gaps in s, that break a limit which is judged during
    /// the first and not during the second.
    pub(super) fn left(&mut self, now: Timestamp, from: &Tags, to: &Tags) -> Vec<(String, f64)> {
        for wait in self.waits.iter_mut().filter(|wait| to.contains_key(&during_tag(&wait.since))) {
            wait.began.get_or_insert(now);
        }
        let is_left = |one: &Declared| one.is_judged_at(from) && !one.is_judged_at(to);
        let open = self.open(now, |_, judges, seconds| {
            judges.iter().any(|one| is_left(one) && one.is_broken_by_gap(seconds))
        });
        self.each.iter_mut().for_each(|gap| gap.longest = Span::ZERO);
        open
    }

    /// The run ends. Returns the quantities, and the gaps in s, that break a limit or are longer than those of this step.
    pub(super) fn finish(&mut self, now: Timestamp) -> Vec<(String, f64)> {
        self.open(now, |longest, judges, seconds| {
            seconds > longest || judges.iter().any(|one| one.is_broken_by_gap(seconds))
        })
    }

    /// The run ends. Returns how long messages have been waited for that never came.
    pub(super) fn waited(&self, now: Timestamp) -> Vec<Waited> {
        self.waits.iter().filter_map(|wait| wait.until(now)).collect()
    }

    fn open(
        &self,
        now: Timestamp,
        is_telling: impl Fn(f64, &[Declared], f64) -> bool,
    ) -> Vec<(String, f64)> {
        let open = self.each.iter().filter_map(|gap| {
            let seconds = (now - gap.last?).as_secs_f64();
            let is_telling = is_telling(gap.longest.as_secs_f64(), &gap.judges, seconds);
            is_telling.then(|| (gap.quantity.clone(), seconds))
        });
        open.collect()
    }
}
