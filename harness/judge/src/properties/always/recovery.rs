//! Within a time after the last fault ends, the controller works again or reports that it does not.
//!
//! It works again when its count of gyro samples rises from one state to the next. Any health other than `ok` reports
//! that it does not work, or not fully.

use super::Judge;
use crate::properties::Limits;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::health::Level;
use wire::time::{Span, Timestamp};

/// Start of the wait, and the sample count in the first state after it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    since: Timestamp,
    samples: Option<u64>,
}

/// Counts as a fault: a declared fault, or an input that is not received.
#[derive(Debug, Clone)]
pub(super) struct Recovers {
    within: Span,
    gyro_timeout: Span,
    base_timeout: Span,
    trouble: bool,
    waiting: Option<Waiting>,
}

impl Recovers {
    pub(super) fn new(within: Span, limits: &Limits) -> Self {
        Self {
            within,
            gyro_timeout: limits.gyro_timeout,
            base_timeout: limits.base.map_or(Span::MAX, |base| base.timeout_at_rest),
            trouble: false,
            waiting: None,
        }
    }

    fn in_trouble(&self, senses: &Senses) -> bool {
        let missed = |heard: Option<Timestamp>, limit: Span| {
            heard.is_some_and(|heard| senses.now - heard > limit)
        };
        senses.faults > 0
            || missed(senses.gyro_heard, self.gyro_timeout)
            || missed(senses.base_heard, self.base_timeout)
    }

    fn end(&mut self, senses: &Senses, since: Timestamp, how: &str, judgement: &mut Judgement) {
        self.waiting = None;
        let took_s = (senses.now - since).as_secs_f64();
        let within_s = self.within.as_secs_f64();
        judgement.take(senses.now, below(took_s, within_s), || {
            format!("{how} {took_s:.2} s after the fault was over, expected within {within_s} s")
        });
    }

    fn wait(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let Some(waiting) = &mut self.waiting else { return };
        let since = waiting.since;
        if senses.health.level != Level::Ok {
            self.end(senses, since, "says that it has not recovered", judgement);
            return;
        }
        if let Fact::State(state) = fact {
            match waiting.samples {
                None => waiting.samples = Some(state.samples),
                Some(samples) if state.samples > samples => {
                    self.end(senses, since, "works again", judgement);
                    return;
                }
                Some(_) => {}
            }
        }
        if senses.now - since > self.within {
            self.end(senses, since, "calls itself well and counts no samples", judgement);
        }
    }
}

impl Judge for Recovers {
    fn hears(&self) -> &'static [Topic] {
        // A missing input is detected by the time that passes, which any of these topics shows.
        &[Topic::Truth, Topic::Gyro, Topic::Motion, Topic::State, Topic::Health, Topic::Faults]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let trouble = self.in_trouble(senses);
        if trouble {
            self.waiting = None;
        } else if self.trouble {
            self.waiting = Some(Waiting { since: senses.now, samples: None });
        }
        self.trouble = trouble;
        self.wait(senses, fact, judgement);
    }
}
