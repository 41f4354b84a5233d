//! The estimator beside the paper's way: fed with what arrives, asked for what is believed.

use super::{Controller, Task};
use crate::config::BRIDGE_MAX;
use crate::kalman::{Correction, Fault, Kalman, Step};
use crate::mission::{BiasTestResult, Estimator, HeadingSource, Uncertainty};
use crate::standstill::Rest;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length};

/// The filter and what it has been told.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimating {
    filter: Kalman,
    passed_s: f64,
    free_s: f64,
    heading: Angle,
    displacement: Length,
    /// Odometry less heading when a pose was set.
    odometry_zero: Angle,
    /// When gyro and base were last heard together.
    anchor: Option<Anchor>,
    /// Before a silence that is being bridged.
    before: Option<(Kalman, Anchor)>,
}

#[derive(Debug, Clone, Copy)]
struct Anchor {
    heading: Angle,
    odometry: Angle,
    displacement: Length,
}

impl Controller {
    /// Takes this estimator from now on.
    pub(super) fn set_estimator(&mut self, estimator: Estimator) {
        self.estimator_failed = false;
        self.estimating = match estimator {
            Estimator::Paper => None,
            Estimator::Kalman => {
                let period_s = self.config.gyro.stream.format.period().as_secs_f64();
                Some(Estimating {
                    filter: Kalman::new(self.noise(), period_s),
                    passed_s: 0.0,
                    free_s: 0.0,
                    heading: self.gyro.integrator().heading(),
                    displacement: self.reckoning.displacement(),
                    odometry_zero: Angle::ZERO,
                    anchor: None,
                    before: None,
                })
            }
        };
        self.gyro.integrator_mut().carry_across_stalls(estimator == Estimator::Kalman);
        self.estimate_from_here();
        self.update_bias();
    }

    /// Of one reading at rest: as the last bias test found it, and never less than half a count.
    fn noise(&self) -> AngularRate {
        let spread = match self.tested_bias {
            Some(_) => self.tested_spread,
            None => self.config.gyro.rest_spread_max,
        };
        spread.max(self.config.gyro.stream.format.rate_step() * 0.5)
    }

    /// A pose is set, or nobody has set one yet.
    pub(super) fn estimate_from_here(&mut self) {
        let heading = self.gyro.integrator().heading();
        let zero = self.reckoning.odometry_heading() - heading;
        if let Some(estimating) = &mut self.estimating {
            estimating.filter.place();
            estimating.heading = heading;
            estimating.odometry_zero = zero;
            (estimating.anchor, estimating.before) = (None, None);
        }
    }

    /// A bias test has told how noisy the readings are. What stands on no base is known to stand by the test alone.
    pub(super) fn estimate_with_test(&mut self, now: Timestamp, test: &BiasTestResult) {
        let noise = self.noise();
        let Some(estimating) = &mut self.estimating else { return };
        estimating.filter.hear_spread(noise);
        if self.base.is_some() {
            return;
        }
        self.estimate(now);
        if let Some(estimating) = &mut self.estimating {
            let came = estimating.filter.at_rest(test.mean, test.samples);
            self.take(came);
        }
    }

    pub(super) fn estimated_bias(&self) -> Option<AngularRate> {
        self.estimating.as_ref().map(|estimating| estimating.filter.bias())
    }

    pub(super) fn uncertainty(&self) -> Option<Uncertainty> {
        self.estimating.as_ref().map(|estimating| estimating.filter.uncertainty())
    }

    /// The base has spoken, or stands for certain: all that has passed goes into the filter.
    pub(super) fn estimate(&mut self, now: Timestamp) {
        if self.gyro.is_silent(now) {
            self.bridge(now);
            return;
        }
        let heading = self.gyro.integrator().heading();
        let displacement = self.reckoning.displacement();
        let odometry = self.reckoning.odometry_heading();
        let fresh = self.gyro.is_fresh(now);
        let Some(estimating) = &mut self.estimating else { return };
        let turned = heading - estimating.heading;
        let step = Step {
            now,
            passed_s: core::mem::take(&mut estimating.passed_s),
            free_s: core::mem::take(&mut estimating.free_s),
            turned,
            path: displacement - estimating.displacement,
            heading: estimating.heading + turned * 0.5,
        };
        (estimating.heading, estimating.displacement) = (heading, displacement);
        let came = estimating.filter.go_on(&step);
        self.take(came);
        let heading = self.gyro.integrator().heading();
        if let Some(estimating) = &mut self.estimating
            && fresh
        {
            estimating.anchor = Some(Anchor { heading, odometry, displacement });
        }
    }

    /// A standstill, or a piece of it: the gyro reads its bias, and the odometry is at rest.
    pub(super) fn estimate_at_rest(&mut self, now: Timestamp, rest: &Rest) {
        if self.estimating.is_none() {
            return;
        }
        self.estimate(now);
        let odometry = self.reckoning.odometry_heading();
        let Some(estimating) = &mut self.estimating else { return };
        let came = estimating.filter.at_rest(rest.piece, rest.piece_readings);
        self.take(came);
        let heading = self.gyro.integrator().heading();
        let Some(estimating) = &mut self.estimating else { return };
        let came = estimating.filter.odometry(odometry - estimating.odometry_zero - heading);
        self.take(came);
        self.update_bias();
    }

    /// Samples have come that last so long.
    pub(super) fn estimate_passed(estimating: &mut Option<Estimating>, passed: Span, held: bool) {
        if let Some(estimating) = estimating {
            estimating.passed_s += passed.as_secs_f64();
            estimating.free_s += if held { 0.0 } else { passed.as_secs_f64() };
        }
    }

    /// The gyro is silent, and the odometry stands in for it.
    pub(super) fn is_bridging(&self, now: Timestamp) -> bool {
        self.estimating.as_ref().is_some_and(|estimating| estimating.anchor.is_some())
            && self.source == HeadingSource::Gyro
            && !matches!(self.task, Task::BiasTest { .. })
            && self.gyro.is_silent(now)
            && !self.gyro.is_silent_for(now, BRIDGE_MAX)
            && now <= self.base_silent_at()
    }

    /// When a silence of the gyro that may be bridged is one no more.
    pub(super) fn gyro_lost_at(&self) -> Timestamp {
        if self.health.causes.bridging {
            self.gyro.silent_for_at(BRIDGE_MAX)
        } else {
            self.gyro.silent_at()
        }
    }

    fn bridge(&mut self, now: Timestamp) {
        if !self.is_bridging(now) {
            return;
        }
        let odometry = self.reckoning.odometry_heading();
        let displacement = self.reckoning.displacement();
        let Some(estimating) = &mut self.estimating else { return };
        let Some(anchor) = estimating.anchor else { return };
        let (before, anchor) = *estimating.before.get_or_insert((estimating.filter, anchor));
        let path = displacement - anchor.displacement;
        let turned = before.heading_of_odometry(odometry - anchor.odometry, path);
        estimating.filter = before;
        let came = estimating.filter.bridge(turned, path, anchor.heading + turned * 0.5);
        let heading = anchor.heading + turned;
        (estimating.heading, estimating.displacement) = (heading, displacement);
        self.gyro.integrator_mut().bridge_to(heading);
        self.reckoning.take_heading(heading);
        self.take(came);
    }

    /// The gyro is heard again. What was late and not lost tells more than the bridge did.
    pub(super) fn end_bridge(&mut self, now: Timestamp, stalled: bool, rate: AngularRate) {
        let since = self.base.as_ref().and_then(|base| base.motion()).map(|(heard, _)| heard);
        let Some(estimating) = &mut self.estimating else { return };
        let Some((before, anchor)) = estimating.before.take() else { return };
        if stalled {
            estimating.filter = before;
            estimating.heading = anchor.heading;
            return;
        }
        // From the base's last word to the gyro's first.
        let unseen = since.map_or(Span::ZERO, |since| now - since);
        let bias = estimating.filter.bias();
        let by = (rate - bias) * unseen;
        estimating.heading += by;
        let heading = self.gyro.integrator().heading() + by;
        self.gyro.integrator_mut().set_heading(heading);
    }

    fn take(&mut self, came: Result<Correction, Fault>) {
        match came {
            Ok(correction) => {
                let heading = self.gyro.integrator().heading() + correction.heading;
                self.gyro.integrator_mut().set_heading(heading);
                self.reckoning.correct(&correction);
                if let Some(estimating) = &mut self.estimating {
                    estimating.heading = heading;
                }
            }
            Err(fault) => {
                tracing::warn!(?fault, "the filter is not used any more");
                self.estimating = None;
                self.estimator_failed = true;
                self.gyro.integrator_mut().carry_across_stalls(false);
                self.update_bias();
            }
        }
    }
}
