//! Missions: acceptance, the steps of each, and their ends.

use super::{
    ANGLE_RAD_MAX, BIAS_TEST_S_MAX, Controller, DISTANCE_M_MAX, RATE_MIN, SPEED_MIN, Task,
};
use crate::bias_test::BiasAverage;
use crate::drive::{Drive, Sight, Wish};
use crate::mission::{
    AbortReason, BiasMethod, BiasTest, Command, HeadingSource, Mission, MissionId, MissionResult,
    Refusal, Report,
};
use crate::mutant::Mutant;
use crate::pose_download::{PoseDownload, Progress};
use wire::base::Request;
use wire::base::payload::encode_request;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Pose};

impl Controller {
    /// Takes a mission; a report answers it.
    pub fn command(&mut self, now: Timestamp, mut mission: Mission) {
        let now = self.awake(now);
        let id = mission.id;
        self.misread(&mut mission.command);
        let answer = match mission.command {
            Command::BiasTest(order) => self.begin_bias_test(now, id, order),
            Command::Straight(order) => {
                let in_range = order.distance.m().abs() <= DISTANCE_M_MAX
                    && order.speed >= SPEED_MIN
                    && self.config.base.is_some_and(|base| order.speed <= base.speed_max);
                self.ready_to_move(now, in_range).map(|sight| {
                    let motion = self.tuned();
                    let drive = Drive::straight(id, order, &motion, &sight);
                    self.begin_drive(now, drive);
                })
            }
            Command::Turn(order) => {
                let in_range = order.angle.rad().abs() <= ANGLE_RAD_MAX
                    && order.rate >= RATE_MIN
                    && self.config.base.is_some_and(|base| order.rate <= base.steer_rate_max);
                self.ready_to_move(now, in_range).map(|mut sight| {
                    self.reference += order.angle;
                    if self.config.planted().is(Mutant::WrapAt360) {
                        let turns = libm::floor(self.reference / Angle::TURN);
                        self.reference -= Angle::TURN * turns;
                    }
                    sight.reference = self.reference;
                    let drive = Drive::turn(id, order, self.source, &self.config.motion, &sight);
                    self.begin_drive(now, drive);
                })
            }
            Command::SetPose(pose) => self.begin_set_pose(now, id, pose),
            Command::SetHeadingSource(source) => self.idle_at_rest(now).map(|()| {
                self.source = source;
                self.reckoning.take_heading(self.heading());
                self.reference = self.heading();
                self.done(id, MissionResult::Applied);
            }),
            Command::SetBiasMethod(method) => {
                self.bias_method = method;
                self.update_bias();
                self.done(id, MissionResult::Applied);
                Ok(())
            }
            Command::SetCalibration(calibration) => {
                let usable = calibration.is_usable();
                self.idle_at_rest(now)
                    .and(if usable { Ok(()) } else { Err(Refusal::OutOfRange) })
                    .map(|()| {
                        self.gyro.integrator_mut().set_calibration(calibration);
                        self.update_bias();
                        self.done(id, MissionResult::Applied);
                    })
            }
            Command::SetEstimator(estimator) => self.idle_at_rest(now).map(|()| {
                self.set_estimator(estimator);
                self.done(id, MissionResult::Applied);
            }),
            Command::RequestState => {
                self.report_state(now);
                self.done(id, MissionResult::Applied);
                Ok(())
            }
            Command::Stop => {
                self.abort(now, AbortReason::Stopped);
                self.stop_base(now);
                self.done(id, MissionResult::Applied);
                Ok(())
            }
        };
        if let Err(reason) = answer {
            self.push_report(Report::Refused { id, reason });
        }
        self.update_health(now);
    }

    pub(super) fn plants(&self, mutant: Mutant) -> bool {
        self.config.planted().is(mutant)
    }

    pub(super) fn idle_at_rest(&self, now: Timestamp) -> Result<(), Refusal> {
        if !matches!(self.task, Task::Idle) {
            return Err(Refusal::Busy);
        }
        if self.is_moving(now) { Err(Refusal::Moving) } else { Ok(()) }
    }

    pub(super) fn ready_to_move(&self, now: Timestamp, in_range: bool) -> Result<Sight, Refusal> {
        if !in_range {
            return Err(Refusal::OutOfRange);
        }
        if !matches!(self.task, Task::Idle) {
            return Err(Refusal::Busy);
        }
        let causes = self.causes(now);
        if self.base.as_ref().is_none_or(|base| base.motion().is_none()) || causes.base_silent {
            return Err(Refusal::NoBase);
        }
        if causes.base_not_ready {
            return Err(Refusal::BaseNotReady);
        }
        if self.source == HeadingSource::Gyro {
            // A gyro that never sent counts as silent too, although that is no fault during the start.
            if (self.gyro.is_silent(now) && !causes.bridging) || causes.gyro_fault {
                return Err(Refusal::NoGyro);
            }
            if causes.no_bias {
                return Err(Refusal::NoBias);
            }
        }
        self.idle_at_rest(now)?;
        Ok(self.sight(now))
    }

    pub(super) fn begin_bias_test(
        &mut self,
        now: Timestamp,
        id: MissionId,
        order: BiasTest,
    ) -> Result<(), Refusal> {
        if !(order.duration_s > 0.0 && order.duration_s <= BIAS_TEST_S_MAX) {
            return Err(Refusal::OutOfRange);
        }
        if self.gyro.is_silent(now) || self.gyro.is_invalid(now) {
            return Err(Refusal::NoGyro);
        }
        if self.config.planted().is(Mutant::BiasTestWhileMoving) {
            if !matches!(self.task, Task::Idle) {
                return Err(Refusal::Busy);
            }
        } else {
            self.idle_at_rest(now)?;
        }
        let duration = Span::from_secs_f64(order.duration_s);
        self.gyro.begin_rest();
        self.task = Task::BiasTest {
            id,
            half: now + duration / 2,
            until: now + duration,
            average: BiasAverage::default(),
        };
        Ok(())
    }

    pub(super) fn finish_bias_test(&mut self, now: Timestamp) {
        let Task::BiasTest { id, average, .. } = &self.task else { return };
        let (id, average) = (*id, *average);
        let at_rest = average.was_at_rest(&self.config.gyro) && !self.is_moving(now);
        if !at_rest && !self.config.planted().is(Mutant::BiasTestWhileMoving) {
            self.abort(now, AbortReason::NotAtRest);
            return;
        }
        if !self.gyro.learn_noise() {
            self.abort(now, AbortReason::GyroFault);
            return;
        }
        let calibration = self.gyro.integrator().calibration();
        let table = average.temperature().and_then(|t| calibration.table_bias(t));
        let result = average.result(table);
        self.tested_bias = Some(result.mean);
        self.tested_spread = result.spread;
        self.bias_test_failed = false;
        self.bias_moved = false;
        self.estimate_with_test(now, &result);
        if self.config.planted().is(Mutant::BiasTestForgives) {
            self.gyro.forgive();
        }
        self.task = Task::Idle;
        self.update_bias();
        self.done(id, MissionResult::BiasTest(result));
    }

    pub(super) fn begin_drive(&mut self, now: Timestamp, mut drive: Drive) {
        drive.plant(self.config.planted());
        self.headings.begin();
        self.broken_off = None;
        self.has_driven = true;
        self.turned_by_bias |= self.bias_moved;
        // The base stands, or this mission would have been refused: a stop commanded at rest is over and must not
        // change this mission's reference.
        self.stopping = false;
        if let Some(base) = &mut self.base {
            base.request(self.config.motion.ramps());
        }
        self.task = Task::Drive(drive);
        self.tick_at = now;
    }

    pub(super) fn begin_set_pose(
        &mut self,
        now: Timestamp,
        id: MissionId,
        pose: Pose,
    ) -> Result<(), Refusal> {
        let on_the_wire = Pose { heading: pose.heading.wrapped(), ..pose };
        let writable = encode_request(&Request::WritePose { pose: on_the_wire, counter: 0 });
        if !pose.is_finite() || (self.base.is_some() && writable.is_none()) {
            return Err(Refusal::OutOfRange);
        }
        self.idle_at_rest(now)?;
        self.gyro.integrator_mut().set_heading(pose.heading);
        self.reckoning.place(pose);
        self.gyro.forgive();
        (self.odometry_doubtful, self.broken_off) = (false, None);
        self.moved_at_rest = false;
        (self.has_driven, self.turned_by_bias) = (false, false);
        self.headings_disagree = false;
        // One that watches has begun anew; one that was chosen is asked for anew.
        self.estimator_failed &= self.estimating.is_none();
        self.headings.begin();
        self.reference = pose.heading;
        self.estimate_from_here();
        if self.base.is_none() {
            self.done(id, MissionResult::Applied);
        } else {
            self.begin_pose_download(now, id, pose, MissionResult::Applied, None);
        }
        Ok(())
    }

    pub(super) fn begin_pose_download(
        &mut self,
        now: Timestamp,
        id: MissionId,
        pose: Pose,
        result: MissionResult,
        drive: Option<Drive>,
    ) {
        let pose = if self.plants(Mutant::WrongPoseDownloaded) { Pose::default() } else { pose };
        let download = PoseDownload::new(id, pose, result, self.pose_write_counter, now);
        self.task = Task::PoseDownload(download, drive);
        self.step_pose_download(now);
    }

    pub(super) fn step_pose_download(&mut self, now: Timestamp) {
        let Task::PoseDownload(download, drive) = &mut self.task else { return };
        let Some(base) = &mut self.base else { return };
        let Some((_, motion)) = base.motion() else { return };
        if motion.moving
            && download.is_under_way()
            && let Some(drive) = drive.take()
        {
            // An order that came late moves the base: the pose no longer holds, and the drive goes on to its end.
            self.task = Task::Drive(drive);
            self.tick_at = now;
            return;
        }
        match download.step(now, &motion, &self.config.motion) {
            Progress::Write(request) => {
                self.pose_write_counter = download.counter();
                self.tick_at = now + self.config.motion.period;
                base.request(request);
                base.poll(now);
            }
            Progress::Waiting => {
                base.poll(now);
                self.tick_at = download.retry_at().min(now + self.config.motion.period);
            }
            Progress::Written(attempts) => {
                let (id, mut result) = (download.id, download.result);
                if let MissionResult::Straight(straight) = &mut result {
                    straight.pose_writes = attempts;
                }
                self.pose_not_written = false;
                self.finish(now, id, result);
            }
            Progress::Refused => {
                self.pose_not_written = true;
                self.abort(now, AbortReason::PoseWriteRefused);
            }
        }
    }

    pub(super) fn tick_drive(&mut self, now: Timestamp) {
        let by_gyro = self.source == HeadingSource::Gyro;
        let is_held = self.gyro.integrator().is_held() && !self.gyro.has_waited();
        let is_current = self.gyro.is_current() || is_held;
        if by_gyro && !is_current && !self.is_bridging(now) {
            return;
        }
        let sight = self.sight(now);
        let Task::Drive(drive) = &mut self.task else { return };
        match drive.tick(&sight, &self.config.motion) {
            Wish::Rates { drive, steer } => {
                if let Some(base) = &mut self.base {
                    if !base.ordered().is_followed() {
                        base.request_again(self.config.motion.ramps());
                    }
                    base.request(Request::SetVelocity { drive, steer });
                    base.poll(now);
                }
                self.report_state(now);
            }
            Wish::Finished(result) => {
                let (id, ended) = (drive.id, *drive);
                let looks = !self.config.planted().blinds_second_looks();
                self.odometry_doubtful |= looks && !drive.could_be_there(&sight);
                self.headings_disagree |= looks
                    && !self.headings.agree_at_rest(sight.gyro_heading, sight.odometry_heading)
                    && !self.plants(Mutant::HeadingsNotCompared);
                // Must precede the report of completion.
                self.update_health(now);
                // Only a heading that the base does not already have is worth writing.
                if self.source == HeadingSource::Gyro
                    && (ended.is_straight() || !self.plants(Mutant::TurnNotWritten))
                {
                    self.begin_pose_download(now, id, sight.pose, result, Some(ended));
                } else {
                    self.finish(now, id, result);
                }
            }
            Wish::TimedOut => {
                self.abort(now, AbortReason::TimedOut);
                self.stop_base(now);
            }
        }
    }

    pub(super) fn abort(&mut self, now: Timestamp, reason: AbortReason) {
        let id = match &self.task {
            Task::Idle => return,
            Task::BiasTest { id, .. } => *id,
            Task::Drive(drive) => drive.id,
            Task::PoseDownload(download, _) => download.id,
        };
        self.bias_test_failed |= matches!(self.task, Task::BiasTest { .. });
        if let Task::Drive(drive) = self.task {
            // The target is void: the next mission starts from where this one ended.
            self.reference = self.heading();
            self.broken_off = Some(drive.broken_off(now, &self.config.motion));
        }
        self.task = Task::Idle;
        self.push_report(Report::Aborted { id, reason });
    }

    /// Stops the base and repeats the command until the base reports that it is at rest.
    pub(super) fn stop_base(&mut self, now: Timestamp) {
        if let Some(base) = &mut self.base {
            base.request(Request::Stop);
            base.poll(now);
            self.stopping = true;
            self.tick_at = now + self.config.motion.period;
        }
    }

    pub(super) fn finish(&mut self, now: Timestamp, id: MissionId, result: MissionResult) {
        self.task = Task::Idle;
        self.tick_at = Timestamp::MAX;
        self.report_state(now);
        self.done(id, result);
    }

    pub(super) fn done(&mut self, id: MissionId, result: MissionResult) {
        self.push_report(Report::Done { id, result });
    }

    /// Sets the bias in force according to the method.
    pub(super) fn update_bias(&mut self) {
        if let Some(bias) = self.chosen_bias() {
            self.gyro.integrator_mut().set_bias(bias);
        }
    }

    pub(super) fn chosen_bias(&self) -> Option<AngularRate> {
        let method = match self.plants(Mutant::BiasMethodIgnored) {
            true => BiasMethod::StaticTest,
            false => self.bias_method,
        };
        match method {
            BiasMethod::StaticTest => {
                self.tested_bias.map(|tested| self.estimated_bias().unwrap_or(tested))
            }
            BiasMethod::TemperatureTable => {
                let integrator = self.gyro.integrator();
                integrator.temperature().and_then(|t| integrator.calibration().table_bias(t))
            }
            BiasMethod::None => Some(AngularRate::ZERO),
        }
    }
}
