//! The filter: takes the inputs, and corrects heading, position and bias if a mission chose it.
//!
//! Otherwise the paper's method leads, and the filter corrects nothing. It runs beside, because it learns what a single
//! comparison cannot know: the odometry's errors from earlier drives, and the bias from many short standstills. It shows
//! leaps of the bias that an unknown base could hide, and by how much a bias that moved has turned the heading.

use super::{Controller, Task};
use crate::base_driver::BaseDriver;
use crate::bias_test::RunningMean;
use crate::config::BRIDGE_MAX;
use crate::kalman::{Correction, Fault, Kalman, Step};
use crate::mission::{BiasTestResult, Estimator, HeadingSource, Uncertainty};
use crate::mutant::Mutant;
use crate::standstill::Rest;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length};

/// The paper's heading is wrong if the filter puts it this far off after a lap: the band of its gyro (Fig. 5).
const HEADING_OFF_MAX: Angle = Angle::from_deg(1.0);
/// Longest lap: the paper's takes 64 s, without the standstills between its motions. Assumption. Over a longer time, such as
/// hours on a table, a good gyro's heading may drift as much further.
const LAP_S: f64 = 100.0;

/// Longest step of a filter that corrects nothing, in time and path. Assumption: soon enough beside comparisons over one to
/// two seconds (`heading_watch.rs`).
const WATCH_STEP_S: f64 = 1.0;
const WATCH_STEP: Length = Length::from_m(0.5);
/// Such a filter takes pieces of a standstill together, up to this share of it. Assumption.
const WATCH_SHARE: u32 = 4;

/// The filter and its inputs so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimating {
    filter: Kalman,
    /// What it estimates is used.
    leads: bool,
    /// Its heading minus the integrated one; zero if it leads.
    aside: Angle,
    /// Time over which that has grown, s.
    aside_s: f64,
    passed_s: f64,
    free_s: f64,
    gaps_s4: f64,
    /// Readings at rest that the filter has not taken yet.
    rest: RunningMean,
    heading: Angle,
    displacement: Length,
    /// Odometry minus heading when a pose was set.
    odometry_zero: Angle,
    /// State when gyro and base were last both up to date.
    anchor: Option<Anchor>,
    /// State before a silence that is being bridged.
    before: Option<(Kalman, Anchor)>,
}

#[derive(Debug, Clone, Copy)]
struct Anchor {
    heading: Angle,
    odometry: Angle,
    displacement: Length,
}

impl Controller {
    /// Selects the estimator.
    pub(super) fn set_estimator(&mut self, estimator: Estimator) {
        self.estimator_failed = false;
        self.begin_estimating(estimator == Estimator::Kalman);
    }

    /// Starts the filter, with nothing learnt.
    fn begin_estimating(&mut self, leads: bool) {
        let period_s = self.config.gyro.stream.format.period().as_secs_f64();
        self.estimating = Some(Estimating {
            filter: Kalman::new(self.noise(), period_s),
            leads,
            aside: Angle::ZERO,
            aside_s: 0.0,
            passed_s: 0.0,
            free_s: 0.0,
            gaps_s4: 0.0,
            rest: RunningMean::default(),
            heading: self.gyro.integrator().heading(),
            displacement: self.reckoning.displacement(),
            odometry_zero: Angle::ZERO,
            anchor: None,
            before: None,
        });
        self.gyro.integrator_mut().carry_across_stalls(leads);
        self.estimate_from_here();
        self.update_bias();
    }

    /// The filter, if a mission chose it.
    fn leading(&self) -> Option<&Estimating> {
        self.estimating.as_ref().filter(|estimating| estimating.leads)
    }

    /// Noise of one reading at rest: from the last bias test, at least half a count.
    fn noise(&self) -> AngularRate {
        let spread = match self.tested_bias {
            Some(_) => self.tested_spread,
            None => self.config.gyro.rest_spread_max,
        };
        spread.max(self.config.gyro.stream.format.facts().rate_step * 0.5)
    }

    /// Restarts the estimate when a pose is set, or before any pose.
    pub(super) fn estimate_from_here(&mut self) {
        let heading = self.gyro.integrator().heading();
        let zero = self.reckoning.odometry_heading() - heading;
        if let Some(estimating) = &mut self.estimating {
            estimating.filter.place();
            estimating.heading = heading;
            (estimating.aside, estimating.aside_s) = (Angle::ZERO, 0.0);
            estimating.odometry_zero = zero;
            (estimating.anchor, estimating.before) = (None, None);
        }
    }

    /// Takes the noise of the readings from a bias test. Without a base, only the test shows that the gyro stands.
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
        self.leading().map(|estimating| estimating.filter.bias())
    }

    pub(super) fn uncertainty(&self) -> Option<Uncertainty> {
        self.leading().map(|estimating| estimating.filter.uncertainty())
    }

    /// Advances the filter after a motion message. One that corrects nothing takes several together, as a step costs more
    /// than all else that the controller does with a message.
    pub(super) fn estimate_in_motion(&mut self, now: Timestamp) {
        let displacement = self.reckoning.displacement();
        let is_due = |one: &Estimating| {
            one.leads
                || one.passed_s >= WATCH_STEP_S
                || (displacement - one.displacement).abs() > WATCH_STEP
        };
        if self.gyro.is_silent(now) || self.estimating.as_ref().is_some_and(is_due) {
            self.estimate(now);
        }
    }

    /// Advances the filter to now, after motion messages or at a certain standstill.
    pub(super) fn estimate(&mut self, now: Timestamp) {
        if self.gyro.is_silent(now) {
            match self.leading() {
                Some(_) => self.bridge(now),
                // Already reported; the rotation during the silence is unknown.
                None => self.estimate_from_here(),
            }
            return;
        }
        let integrated = self.gyro.integrator().heading();
        let displacement = self.reckoning.displacement();
        let odometry = self.reckoning.odometry_heading();
        let fresh = self.gyro.is_fresh(now);
        let bias = self.gyro.integrator().bias();
        let Some(estimating) = &mut self.estimating else { return };
        let heading = integrated + estimating.aside;
        let turned = heading - estimating.heading;
        let free_s = core::mem::take(&mut estimating.free_s);
        estimating.aside_s += free_s;
        let step = Step {
            now,
            passed_s: core::mem::take(&mut estimating.passed_s),
            free_s,
            gaps_s4: core::mem::take(&mut estimating.gaps_s4),
            turned,
            bias,
            path: displacement - estimating.displacement,
            heading: estimating.heading + turned * 0.5,
        };
        (estimating.heading, estimating.displacement) = (heading, displacement);
        let came = estimating.filter.go_on(&step);
        self.take(came);
        self.look_aside();
        let heading = self.gyro.integrator().heading();
        if let Some(estimating) = &mut self.estimating
            && fresh
        {
            estimating.anchor = Some(Anchor { heading, odometry, displacement });
        }
    }

    /// Updates at a standstill or a piece of it: the gyro reads its bias, and the odometry is at rest.
    pub(super) fn estimate_at_rest(&mut self, now: Timestamp, rest: &Rest) {
        let Some(estimating) = &mut self.estimating else { return };
        if rest.readings == rest.piece.count() {
            estimating.rest = RunningMean::default();
        }
        estimating.rest.join(&rest.piece);
        let many = estimating.rest.count() * WATCH_SHARE >= rest.readings;
        if !many && !estimating.leads && estimating.passed_s < WATCH_STEP_S {
            return;
        }
        let piece = core::mem::take(&mut estimating.rest);
        self.estimate(now);
        let odometry = self.reckoning.odometry_heading();
        let Some(estimating) = &mut self.estimating else { return };
        let mean = AngularRate::from_rad_per_s(piece.mean());
        let came = estimating.filter.at_rest(mean, piece.count());
        let off = (rest.mean - self.gyro.integrator().bias()).abs();
        // The bias of a test may drift further than the filter's own, which follows it.
        let drift_max = self.config.gyro.rest_drift_max;
        let may_drift = !estimating.leads && off <= drift_max;
        let mut moved = self.take(came);
        if let Some(estimating) = &mut self.estimating
            && moved
            && may_drift
        {
            estimating.filter.bias_may_have_moved(drift_max);
            let came = estimating.filter.at_rest(mean, piece.count());
            self.take(came);
            moved = false;
        }
        self.hear_of_moved_bias(moved);
        let integrated = self.gyro.integrator().heading();
        let Some(estimating) = &mut self.estimating else { return };
        let heading = integrated + estimating.aside;
        let came = estimating.filter.odometry(odometry - estimating.odometry_zero - heading);
        let planted = self.config.planted();
        self.headings_disagree |= self.take(came)
            && !planted.is(Mutant::HeadingsNotCompared)
            && !planted.blinds_second_looks();
        self.look_aside();
        self.update_bias();
    }

    /// Compares the paper's heading with the filter's.
    fn look_aside(&mut self) {
        let may_be = |one: &Estimating| HEADING_OFF_MAX * (one.aside_s / LAP_S).max(1.0);
        let off = |one: &Estimating| one.aside.abs() > may_be(one);
        self.turned_by_bias |= self.watches_bias() && self.estimating.as_ref().is_some_and(off);
    }

    /// Adds the duration of new samples.
    pub(super) fn estimate_passed(
        estimating: &mut Option<Estimating>,
        passed: Span,
        lost: u16,
        held: bool,
    ) {
        if let Some(estimating) = estimating {
            let passed_s = passed.as_secs_f64();
            estimating.passed_s += passed_s;
            estimating.free_s += if held { 0.0 } else { passed_s };
            if lost > 0 && !held {
                estimating.gaps_s4 += libm::pow(passed_s, 4.0);
            }
        }
    }

    /// True while the gyro is silent and the odometry replaces it. If the last sample had waited for a stalled host, its
    /// age is unknown, and so is the length of the silence: nothing bridges it.
    pub(super) fn is_bridging(&self, now: Timestamp) -> bool {
        self.leading().is_some_and(|estimating| estimating.anchor.is_some())
            && self.source == HeadingSource::Gyro
            && !matches!(self.task, Task::BiasTest { .. })
            && self.gyro.is_silent(now)
            && !self.gyro.has_waited()
            && !self.gyro.is_silent_for(now, BRIDGE_MAX)
            && now <= self.base_silent_at()
    }

    /// End of the longest silence of the gyro that is tolerated now.
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

    /// Ends the bridge when samples arrive again. Samples that were delayed, not lost, are better than the bridge.
    pub(super) fn end_bridge(&mut self, now: Timestamp, stalled: bool, rate: AngularRate) {
        let motion = self.base.as_ref().and_then(BaseDriver::motion);
        let since = motion.filter(|(_, motion)| motion.moving).map(|(heard, _)| heard);
        let Some(estimating) = &mut self.estimating else { return };
        let Some((before, anchor)) = estimating.before.take() else { return };
        if stalled {
            estimating.filter = before;
            estimating.heading = anchor.heading;
            return;
        }
        // From the last motion message to the first sample. A base that stands says so less often.
        let unseen = since.map_or(Span::ZERO, |since| now - since);
        let bias = estimating.filter.bias();
        let by = (rate - bias) * unseen;
        estimating.heading += by;
        let heading = self.gyro.integrator().heading() + by;
        self.gyro.integrator_mut().set_heading(heading);
    }

    /// Returns true if the measurement came from something that has changed.
    fn take(&mut self, came: Result<Correction, Fault>) -> bool {
        let is_foreign = came.is_ok_and(|correction| correction.is_foreign);
        match (came, &mut self.estimating) {
            (Ok(correction), Some(estimating)) if !estimating.leads => {
                estimating.aside += correction.heading;
                estimating.heading += correction.heading;
            }
            (Err(fault), Some(Estimating { leads: false, .. })) => {
                tracing::debug!(?fault, "the filter that watches begins anew");
                // What it knew of the heading since a pose was set is lost. A heading that was held has turned by nothing.
                self.estimator_failed |= self.has_driven && self.watches_bias();
                self.begin_estimating(false);
            }
            (Ok(correction), estimating) => {
                let heading = self.gyro.integrator().heading() + correction.heading;
                self.gyro.integrator_mut().set_heading(heading);
                self.reckoning.correct(&correction);
                if let Some(estimating) = estimating {
                    estimating.heading = heading;
                }
            }
            (Err(fault), _) => {
                tracing::warn!(?fault, "the filter is not used any more");
                self.estimating = None;
                self.estimator_failed = true;
                self.gyro.integrator_mut().carry_across_stalls(false);
                self.update_bias();
            }
        }
        is_foreign
    }
}
