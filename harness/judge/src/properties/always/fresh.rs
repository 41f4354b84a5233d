//! The controller commands no motion on a heading older than its limit, nor on a bridge that is not announced or too
//! long.

use super::Judge;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::mission::HeadingSource;
use wire::base::Request;
use wire::time::Span;

/// Judged at every velocity command while the gyro closes the loops and is not bridged.
#[derive(Debug, Clone)]
pub(super) struct FreshHeading {
    pub(super) age_max: Span,
}

impl Judge for FreshHeading {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Request]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let Fact::Request(Request::SetVelocity { drive, steer }) = fact else { return };
        let moves = drive.m_per_s() != 0.0 || steer.rad_per_s() != 0.0;
        if !moves || senses.source != HeadingSource::Gyro || senses.is_bridged() {
            return;
        }
        let limit_s = self.age_max.as_secs_f64();
        match senses.gyro_heard {
            None => judgement.take(senses.now, -1.0, || {
                "told to move before any good gyro sample was heard".to_owned()
            }),
            Some(heard) => {
                let age_s = (senses.now - heard).as_secs_f64();
                judgement.take(senses.now, below(age_s, limit_s), || {
                    format!(
                        "told to move on a heading {age_s:.3} s old, expected at most {limit_s} s"
                    )
                });
            }
        }
    }
}
