//! A pose is written only while the base is at rest.
//!
//! No input of the controller shows an order that a CAN bus delivers after younger ones, before the base's next message
//! does: a pose that is written in between breaks this. The base refuses it, and it is written again.

use super::Judge;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::Judgement;
use wire::base::Request;
use wire::time::{Span, Timestamp};

/// Rest time for the full margin: the controller's own settling time.
const AT_REST: Span = Span::from_millis(300);

/// Judged at each write of a pose, by how long the base has truly been at rest.
#[derive(Debug, Clone, Default)]
pub(super) struct PoseWrittenAtRest {
    moved: Option<Timestamp>,
}

impl Judge for PoseWrittenAtRest {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Truth, Topic::Request]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        match fact {
            Fact::Truth if senses.is_moving() && !senses.is_astray() => {
                self.moved = Some(senses.now)
            }
            Fact::Request(Request::WritePose { .. }) => {
                let Some(truth) = senses.truth.filter(|_| !senses.is_astray()) else { return };
                let stood = self.moved.map_or(AT_REST, |moved| senses.now - moved);
                let margin = stood.as_secs_f64() / AT_REST.as_secs_f64();
                let margin = if truth.is_moving() { -1.0 } else { margin };
                judgement.take(senses.now, margin, || {
                    format!(
                        "a pose is written at {:.4} m/s and {:.3} deg/s, expected a base at rest",
                        truth.speed.m_per_s(),
                        truth.steer_rate.deg_per_s(),
                    )
                });
            }
            _ => {}
        }
    }
}
