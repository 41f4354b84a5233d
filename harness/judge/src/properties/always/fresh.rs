//! The controller commands no motion on a heading older than its limit, nor on a bridge that is not announced or too
//! long.

use super::Judge;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::mission::HeadingSource;
use wire::base::Request;
use wire::time::{Span, Timestamp};

/// Judged at every velocity command while the gyro closes the loops and is not bridged.
#[derive(Debug, Clone)]
pub(super) struct FreshHeading {
    age_max: Span,
    /// A command on a heading that was too old, and when it was heard, if ever: a bridge that is announced at the same moment
    /// allows it, as reports and commands go different ways.
    doubted: Option<(Timestamp, Option<Timestamp>)>,
}

impl FreshHeading {
    pub(super) const fn new(age_max: Span) -> Self {
        Self { age_max, doubted: None }
    }

    fn take(&self, at: Timestamp, heard: Option<Timestamp>, judgement: &mut Judgement) {
        let limit_s = self.age_max.as_secs_f64();
        let Some(heard) = heard else {
            return judgement.take(at, -1.0, || {
                "told to move before any good gyro sample was heard".to_owned()
            });
        };
        let age_s = (at - heard).as_secs_f64();
        judgement.take(at, below(age_s, limit_s), || {
            format!("told to move on a heading {age_s:.3} s old, expected at most {limit_s} s")
        });
    }
}

impl Judge for FreshHeading {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Request, Topic::Health, Topic::Truth]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let now = senses.now;
        if let Some((at, heard)) = self.doubted
            && (now > at || senses.is_bridged())
        {
            self.doubted = None;
            if now > at {
                self.take(at, heard, judgement);
            }
        }
        let Fact::Request(Request::SetVelocity { drive, steer }) = fact else { return };
        let moves = drive.m_per_s() != 0.0 || steer.rad_per_s() != 0.0;
        if !moves || senses.source != HeadingSource::Gyro || senses.is_bridged() {
            return;
        }
        let heard = senses.gyro_heard;
        match heard.is_some_and(|heard| now - heard <= self.age_max) {
            true => self.take(now, heard, judgement),
            false => self.doubted = Some((now, heard)),
        }
    }
}
