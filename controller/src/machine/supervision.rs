//! Monitoring during and between missions: inputs, rest, health.

use super::{Controller, Heard, Task};
use crate::base_driver::BaseDriver;
use crate::config::HOLD_AFTER;
use crate::drive::Sight;
use crate::follow_watch::FollowWatch;
use crate::health::{Causes, Health};
use crate::mission::{AbortReason, BiasMethod, HeadingSource, Report};
use crate::mutant::Mutant;
use crate::standstill::Rest;
use wire::base::Motion;
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate};

impl Controller {
    /// The own time of an input or a wake-up at `told` of the host's clock. A host that called later than it was asked to
    /// stalled: what arrives next may be as old as the stall was long.
    #[inline]
    pub(super) fn awake(&mut self, told: Timestamp) -> Timestamp {
        let before = self.time.last();
        let now = self.time.hear(told);
        let late = self.config.gyro.timeout / 2;
        if now - before > late && now - self.due_at() > late {
            self.gyro.hear_of_stall(now);
        }
        now
    }

    /// Holds the heading while the base stands and no command will move it.
    pub(super) fn update_hold(&mut self, now: Timestamp) {
        let about_to_move = matches!(self.task, Task::Drive(_)) || self.stopping;
        let held = self.base.is_some() && !about_to_move && !self.is_moving(now);
        let held = held && !self.plants(Mutant::HeadingNotHeld);
        self.gyro.integrator_mut().hold(held);
    }

    /// Compares the base's reported motion with the commands and with the gyro.
    pub(super) fn look_at_motion(&mut self, now: Timestamp, motion: &Motion) {
        if self.config.planted().blinds_second_looks() {
            return;
        }
        // A drive that was not broken off ends with the write of a pose, whose answer shows that all orders have arrived.
        let broken_off = !matches!(self.task, Task::Drive(_));
        if broken_off && self.base.as_ref().is_some_and(|base| base.ordered().was_not_followed()) {
            self.odometry_doubtful = true;
        }
        let lags = !self.config.planted().is(Mutant::LaggingOdometerBelieved);
        if !self.base.as_ref().is_some_and(BaseDriver::may_move)
            && let Some(drive) = self.broken_off.take()
        {
            // A base that stopped by itself went no further.
            let stopped = motion.command_timed_out || motion.emergency_stop || motion.fault;
            self.odometry_doubtful |=
                lags && !stopped && drive.fell_short(self.reckoning.displacement());
        }
        let (displacement, heading) =
            (self.reckoning.displacement(), self.reckoning.odometry_heading());
        let follows = match &self.task {
            Task::Drive(drive) => Some(drive.follows()),
            _ => self.broken_off.as_ref(),
        };
        if motion.moving && follows.is_some_and(FollowWatch::drives) {
            self.odometry_doubtful |=
                self.counts.counts_nothing(now, displacement, heading) && lags;
        } else {
            self.counts.rests();
        }
        if let Task::Drive(drive) = &self.task
            && !drive.follows().could_be_on_the_way(now, displacement, heading)
            && lags
        {
            // Reported, but no reason to stop: a line that loses commands has the same effect.
            self.odometry_doubtful = true;
        }
        let rate = match motion.moving {
            true => self.gyro.integrator().rate(),
            false => AngularRate::ZERO,
        };
        let heard = Heard {
            gyro: self.gyro.integrator().heading(),
            odometry: self.reckoning.odometry_heading(),
            displacement: motion.displacement,
            rate,
        };
        if self.gyro.is_silent(now) {
            // Already reported; the rotation during the silence is unknown.
            self.headings.begin();
        }
        let differ = self.headings.differs(now, heard)
            || (!motion.moving && !self.headings.agree_at_rest(heard.gyro, heard.odometry));
        self.headings_disagree |= differ && !self.config.planted().is(Mutant::HeadingsNotCompared);
    }

    /// Tracks the start and end of a standstill.
    fn update_standstill(&mut self, now: Timestamp) {
        let commanding = matches!(&self.task, Task::Drive(drive) if drive.is_commanding());
        let moving = self.is_moving(now);
        let stands = self.base.is_some() && !moving && !commanding;
        if self.stands && moving {
            self.standstill.is_broken_off();
        } else if self.stands && !stands {
            let rest = self.standstill.ends(now);
            self.look_at_rest(now, rest);
        } else if stands && !self.stands && !matches!(self.task, Task::BiasTest { .. }) {
            self.gyro.begin_rest();
        }
        self.stands = stands;
    }

    /// Checks the bias at a standstill, where the gyro reads it.
    pub(super) fn look_at_rest(&mut self, now: Timestamp, rest: Option<Rest>) {
        let Some(rest) = rest else { return };
        let bias = self.gyro.integrator().bias();
        self.look_for_moved_bias(&rest, bias);
        self.estimate_at_rest(now, &rest);
    }

    fn look_for_moved_bias(&mut self, rest: &Rest, bias: AngularRate) {
        let drift_max = self.config.gyro.rest_drift_max;
        let moved = rest.moved(bias, self.tested_spread, drift_max);
        self.hear_of_moved_bias(moved || self.gyro.was_stuck_in_test());
    }

    /// Remembers a bias that is no longer the tested one, and the heading that it may have turned since.
    pub(super) fn hear_of_moved_bias(&mut self, moved: bool) {
        let moved = moved && !self.bias_moved && self.watches_bias();
        self.bias_moved |= moved;
        self.turned_by_bias |= moved && self.has_driven;
    }

    /// True if the bias in force is that of a test.
    pub(super) fn watches_bias(&self) -> bool {
        let planted = self.config.planted();
        self.tested_bias.is_some()
            && self.bias_method == BiasMethod::StaticTest
            && !planted.is(Mutant::MovedBiasIgnored)
            && !planted.blinds_second_looks()
    }

    /// True unless the base is known to be at rest.
    pub(super) fn is_moving(&self, now: Timestamp) -> bool {
        match &self.base {
            None => self.mean_raw_rate().abs() > self.config.gyro.bias_max,
            Some(base) => base.may_move() || now > self.base_silent_at(),
        }
    }

    /// Heading by the selected source.
    pub(super) fn heading(&self) -> Angle {
        match self.source {
            HeadingSource::Gyro => self.gyro.integrator().heading(),
            HeadingSource::Odometry => self.reckoning.odometry_heading(),
        }
    }

    /// What the loops see.
    pub(super) fn sight(&self, now: Timestamp) -> Sight {
        let heading = self.heading();
        Sight {
            now,
            heading,
            gyro_heading: self.gyro.integrator().heading(),
            odometry_heading: self.reckoning.odometry_heading(),
            displacement: self.reckoning.displacement(),
            moving: self.is_moving(now),
            reference: self.reference,
            pose: self.reckoning.pose(heading),
            hold: self.is_bridging(now) && self.gyro.is_silent_for(now, HOLD_AFTER),
        }
    }

    /// Mean of the raw readings since the last state; without new readings, that state's mean.
    pub(super) fn mean_raw_rate(&self) -> AngularRate {
        if self.raw_rate.count() == 0 {
            return self.last_raw_rate;
        }
        AngularRate::from_rad_per_s(self.raw_rate.mean())
    }

    /// Time at which the base's silence becomes a fault. A stationary base sends slowly, so the short time-out starts
    /// at the command to move.
    pub(super) fn base_silent_at(&self) -> Timestamp {
        let (Some(base), Some(config)) = (&self.base, &self.config.base) else {
            return Timestamp::MAX;
        };
        let Some((heard, _)) = base.motion() else {
            return self.started + config.timeout_at_rest;
        };
        match &self.task {
            Task::Drive(drive) if drive.is_commanding() => {
                let planted = self.config.planted().is(Mutant::WatchdogOffByTen);
                let scale = if planted { 10 } else { 1 };
                heard.max(drive.commanding_since()) + config.timeout_moving * scale
            }
            _ if base.may_move() => {
                base.ordered().since().map_or(heard, |at| at.max(heard)) + config.timeout_moving
            }
            _ => heard + config.timeout_at_rest,
        }
    }

    /// Aborts the running mission if an input forbids it.
    pub(super) fn watch_inputs(&mut self, now: Timestamp) {
        let needs_gyro = match &self.task {
            Task::Idle => return,
            Task::BiasTest { .. } => true,
            Task::Drive(_) | Task::PoseDownload(..) => self.source == HeadingSource::Gyro,
        };
        let moves = matches!(self.task, Task::Drive(_));
        let causes = self.causes(now);
        let motion = self.base.as_ref().and_then(BaseDriver::motion).map(|(_, motion)| motion);
        let stale_is_fine = self.config.planted().is(Mutant::StaleHeading);
        let reason = if needs_gyro && causes.gyro_silent && !stale_is_fine {
            AbortReason::GyroSilent
        } else if needs_gyro && (causes.gyro_fault || (moves && causes.gyro_over_range)) {
            AbortReason::GyroFault
        } else if causes.base_silent {
            AbortReason::BaseSilent
        } else if motion.is_some_and(|motion| motion.emergency_stop) {
            AbortReason::EmergencyStop
        } else if motion.is_some_and(|motion| motion.fault) {
            AbortReason::BaseFault
        } else if self.has_command_timed_out(now) {
            AbortReason::BaseCommandTimeout
        } else {
            return;
        };
        self.abort(now, reason);
        if moves {
            self.stop_base(now);
        }
    }

    /// True if the base stopped by itself during a mission. The base reports this until it receives the next velocity,
    /// so reports before that do not concern this mission.
    pub(super) fn has_command_timed_out(&self, now: Timestamp) -> bool {
        let (Task::Drive(drive), Some(config), Some(base)) =
            (&self.task, &self.config.base, &self.base)
        else {
            return false;
        };
        now > drive.commanding_since() + config.timeout_moving
            && base.motion().is_some_and(|(_, motion)| motion.command_timed_out)
    }

    pub(super) fn causes(&self, now: Timestamp) -> Causes {
        let trouble = self.gyro.trouble();
        let bridging = self.is_bridging(now);
        let motion = self.base.as_ref().and_then(BaseDriver::motion).map(|(_, motion)| motion);
        Causes {
            gyro_silent: !self.gyro.is_starting() && self.gyro.is_silent(now) && !bridging,
            gyro_fault: self.gyro.is_invalid(now) && (self.gyro.is_stuck() || !bridging),
            base_silent: self.base.is_some() && now > self.base_silent_at(),
            base_not_ready: motion.is_some_and(|motion| motion.emergency_stop || motion.fault),
            gyro_over_range: trouble.over_range,
            gyro_invalid: trouble.invalid,
            samples_lost: trouble.lost,
            odometry_doubtful: self.odometry_doubtful || self.is_unfollowed,
            headings_disagree: self.headings_disagree,
            moved_at_rest: self.moved_at_rest,
            bias_moved: self.bias_moved || self.turned_by_bias,
            temperature_doubtful: trouble.temperature,
            clock_mismatch: trouble.clock_mismatch,
            no_bias: self.chosen_bias().is_none(),
            bias_test_failed: self.bias_test_failed,
            pose_not_written: self.pose_not_written,
            bridging,
            estimator_failed: self.estimator_failed,
            overflow: self.reports_lost
                || self.base.as_ref().is_some_and(|base| base.refused() > 0),
        }
    }

    /// A base that was lost while it moved: what it says next may be as old as that, until it stands and has had all orders.
    fn lose_sight(&mut self, now: Timestamp) {
        let waits = |base: &BaseDriver| base.ordered().waits_for_answer();
        let moved = self.base.as_ref().is_some_and(|base| {
            base.motion().is_some()
                && (base.may_move() || waits(base))
                && !self.config.planted().blinds_second_looks()
        });
        let lost = self.base.as_ref().is_some_and(waits) || now > self.base_silent_at();
        self.is_unfollowed = moved && (self.is_unfollowed || lost);
    }

    pub(super) fn update_health(&mut self, now: Timestamp) {
        self.update_hold(now);
        self.update_standstill(now);
        let starting = self.gyro.is_starting()
            || self.base.as_ref().is_some_and(|base| base.motion().is_none());
        self.lose_sight(now);
        let causes = self.causes(now);
        let causes = if self.plants(Mutant::HealthSilent) { Causes::default() } else { causes };
        let health = Health::new(starting, causes);
        if health != self.health {
            self.health = health;
            self.push_report(Report::Health(health));
        }
    }
}
