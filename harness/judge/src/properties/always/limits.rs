//! Commanded and true speeds, and the accelerations that the base is ordered to, stay within their limits.
//!
//! What noise, play or stiction of its drives add to these accelerations is no order of the controller.

use super::Judge;
use crate::properties::seen::Truth;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use crate::properties::{Limits, TRUE_OVER_COMMANDED_MAX};
use wire::base::Request;
use wire::time::{Span, Timestamp};
use wire::units::{AngularRate, Speed};

/// Changes of speed are averaged over this time.
const WINDOW: Span = Span::from_millis(50);

/// Judged at each velocity command and at every truth. Only speeding up is limited, since emergency braking
/// may be hard.
#[derive(Debug, Clone)]
pub(super) struct WithinLimits {
    pub(super) limits: Limits,
    pub(super) before: Option<(Timestamp, (Speed, AngularRate))>,
}

impl WithinLimits {
    fn rates(
        &self,
        now: Timestamp,
        judgement: &mut Judgement,
        (whose, share): (&str, f64),
        (speed, rate): (Speed, AngularRate),
    ) {
        let (v, v_max) = (speed.abs().m_per_s(), self.limits.speed_max.m_per_s() * share);
        judgement.take(now, below(v, v_max), || {
            format!("{whose} speed {v:.3} m/s, expected at most {v_max:.3} m/s")
        });
        let (w, w_max) = (rate.abs().deg_per_s(), self.limits.steer_rate_max.deg_per_s() * share);
        judgement.take(now, below(w, w_max), || {
            format!("{whose} rate {w:.2} deg/s, expected at most {w_max:.2} deg/s")
        });
    }

    fn changes(&mut self, now: Timestamp, truth: Truth, judgement: &mut Judgement) {
        let (speed, rate) = truth.followed;
        let Some((at, before)) = self.before else {
            self.before = Some((now, truth.followed));
            return;
        };
        let passed = now - at;
        if passed < WINDOW {
            return;
        }
        self.before = Some((now, truth.followed));
        let a = (speed.abs() - before.0.abs()) / passed;
        let a_max = self.limits.acceleration_max;
        judgement.take(now, below(a.m_per_s2(), a_max.m_per_s2()), || {
            let (a, a_max) = (a.m_per_s2(), a_max.m_per_s2());
            format!("speeds up by {a:.3} m/s^2, expected at most {a_max:.3} m/s^2")
        });
        let b = (rate.abs() - before.1.abs()) / passed;
        let b_max = self.limits.steer_acceleration_max;
        judgement.take(now, below(b.rad_per_s2(), b_max.rad_per_s2()), || {
            let (b, b_max) = (b.deg_per_s2(), b_max.deg_per_s2());
            format!("steers up by {b:.2} deg/s^2, expected at most {b_max:.2} deg/s^2")
        });
    }
}

impl Judge for WithinLimits {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Request, Topic::Truth]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let now = senses.now;
        match (fact, senses.truth) {
            (Fact::Request(Request::SetVelocity { drive, steer }), _) => {
                self.rates(now, judgement, ("commanded", 1.0), (*drive, *steer));
            }
            (Fact::Truth, _) if senses.is_astray() => self.before = None,
            (Fact::Truth, Some(truth)) => {
                let by = ("true", TRUE_OVER_COMMANDED_MAX);
                self.rates(now, judgement, by, (truth.speed, truth.steer_rate));
                if senses.has_stray_ramps() {
                    self.before = None;
                } else {
                    self.changes(now, truth, judgement);
                }
            }
            _ => {}
        }
    }
}
