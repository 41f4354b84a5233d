//! After loss of the gyro or the base, the controller stops within a time and a distance.
//!
//! Both limits follow from the fastest motion since the input was last received, with reaction time and braking:
//! `t + v / a` and `v t + v^2 / 2 a`. Drive and steering both have the time of the slower to stop. An input is missed
//! since it was last received or since the base began to move, whichever is later, because a base at rest sends less
//! often. A gyro that is bridged, as announced by the controller and for no longer than permitted, is missed from the
//! end of the bridge.

use super::Judge;
use crate::properties::Limits;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::mission::HeadingSource;
use wire::time::Timestamp;

/// Motion of drive or steering since the input was last received, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Way {
    fastest: f64,
    went: f64,
}

impl Way {
    fn go(&mut self, rate: f64, passed_s: f64) {
        self.fastest = self.fastest.max(rate.abs());
        self.went += rate.abs() * passed_s;
    }

    fn time_s(self, reaction_s: f64, braking: f64) -> f64 {
        reaction_s + self.fastest / braking
    }

    /// Distance from the limit as a share of it. The limit is full speed for `limit_s` with braking at its end.
    fn margin(self, limit_s: f64, braking: f64) -> f64 {
        let limit = self.fastest * (limit_s - self.fastest / (2.0 * braking));
        if limit > 0.0 { below(self.went, limit) } else { 1.0 }
    }
}

/// One input, and the motion since it was last received.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Missed {
    name: &'static str,
    since: Timestamp,
    drive: Way,
    steer: Way,
}

impl Missed {
    const fn new(name: &'static str) -> Self {
        const STILL: Way = Way { fastest: 0.0, went: 0.0 };
        Self { name, since: Timestamp::ZERO, drive: STILL, steer: STILL }
    }

    fn heard(&mut self, now: Timestamp) {
        *self = Self { since: now, ..Self::new(self.name) };
    }
}

/// Judged at every truth.
#[derive(Debug, Clone)]
pub(super) struct StopsOnLoss {
    limits: Limits,
    gyro: Missed,
    base: Missed,
    last: Option<Timestamp>,
}

impl StopsOnLoss {
    pub(super) const fn new(limits: Limits) -> Self {
        Self { limits, gyro: Missed::new("gyro"), base: Missed::new("base"), last: None }
    }

    fn look(&mut self, senses: &Senses, judgement: &mut Judgement) {
        let Some(truth) = senses.truth else { return };
        let now = senses.now;
        let passed_s = self.last.replace(now).map_or(0.0, |last| (now - last).as_secs_f64());
        if !truth.is_moving() || senses.has_stray_ramps() {
            self.gyro.heard(now);
            self.base.heard(now);
            return;
        }
        for missed in [&mut self.gyro, &mut self.base] {
            missed.drive.go(truth.speed.m_per_s(), passed_s);
            missed.steer.go(truth.steer_rate.rad_per_s(), passed_s);
        }
        let by_gyro = senses.source == HeadingSource::Gyro;
        if senses.is_bridged() {
            self.gyro.heard(now);
        }
        let reaction_s = (self.limits.reaction_max + senses.order_late()).as_secs_f64();
        let braking = self.limits.braking_min.m_per_s2();
        let steer_braking = self.limits.steer_braking_min.rad_per_s2();
        for missed in [by_gyro.then_some(&self.gyro), Some(&self.base)].into_iter().flatten() {
            let time_s = (now - missed.since).as_secs_f64();
            let limit_s = (missed.drive.time_s(reaction_s, braking))
                .max(missed.steer.time_s(reaction_s, steer_braking));
            let margin = below(time_s, limit_s)
                .min(missed.drive.margin(limit_s, braking))
                .min(missed.steer.margin(limit_s, steer_braking));
            judgement.take(now, margin, || {
                format!(
                    "moves {time_s:.2} s after the {} was last heard, {:.3} m and {:.1} deg on, expected \
                     to stand within {limit_s:.2} s and what its brakes need",
                    missed.name,
                    missed.drive.went,
                    missed.steer.went.to_degrees(),
                )
            });
        }
    }
}

impl Judge for StopsOnLoss {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::Truth, Topic::Gyro, Topic::Motion]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        match fact {
            Fact::Truth => self.look(senses, judgement),
            Fact::Gyro if senses.gyro_heard == Some(senses.now) => self.gyro.heard(senses.now),
            Fact::Motion => self.base.heard(senses.now),
            _ => {}
        }
    }
}
