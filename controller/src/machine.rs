//! The controller as a whole: inputs in, missions through, requests and reports out.

use crate::base_driver::{BaseDriver, Outgoing};
use crate::bias_test::{BiasAverage, RunningMean};
use crate::config::Config;
use crate::dead_reckoning::DeadReckoning;
use crate::drive::{Drive, Sight, Wish};
use crate::gyro_input::GyroInput;
use crate::health::{Causes, Health};
use crate::mission::{
    AbortReason, Activity, BiasMethod, BiasTest, Command, HeadingSource, Mission, MissionId,
    MissionResult, Refusal, Report, State,
};
use crate::pose_download::{PoseDownload, Progress};
use heapless::Deque;
use wire::base::payload::{COUNTS_PER_DEG, COUNTS_PER_M, encode_request};
use wire::base::{Motion, Request};
use wire::can::CanFrame;
use wire::gyro::{GyroFormat, dsp3000_command};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Pose, Speed};

/// Reports that wait to be fetched; the oldest state gives way, and the loss shows in health.
pub const REPORTS_MAX: usize = 64;
/// State comes this often while nothing moves.
pub const STATE_PERIOD_AT_REST: Span = Span::from_secs(1);
/// Longest bias test that is accepted.
pub const BIAS_TEST_S_MAX: f64 = 3_600.0;
/// Longest path and largest turn of one mission: beyond them a number is a mistake.
pub const DISTANCE_M_MAX: f64 = 1_000.0;
/// See [`DISTANCE_M_MAX`].
pub const ANGLE_RAD_MAX: f64 = 1_000.0;
/// Slowest speed of a mission: one count of the wire. Below it the base would be told to stand.
pub const SPEED_MIN: Speed = Speed::from_m_per_s(1.0 / COUNTS_PER_M);
/// Slowest rate of a mission; see [`SPEED_MIN`].
pub const RATE_MIN: AngularRate = AngularRate::from_deg_per_s(1.0 / COUNTS_PER_DEG);

/// A port of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// The gyro's serial line.
    Gyro,
    /// The base's serial line or CAN bus.
    Base,
}

/// What arrives at a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input<'a> {
    /// Serial bytes.
    Bytes(&'a [u8]),
    /// A CAN frame.
    Frame(CanFrame),
}

/// What leaves a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Output {
    /// Serial bytes.
    Bytes(Port, Packet),
    /// A CAN frame, to the base.
    Frame(CanFrame),
}

#[derive(Debug, Clone)]
enum Task {
    Idle,
    BiasTest { id: MissionId, half: Timestamp, until: Timestamp, average: BiasAverage },
    Drive(Drive),
    PoseDownload(PoseDownload),
}

/// The code under test: one gyro, at most one base, one mission at a time.
#[derive(Debug, Clone)]
pub struct Controller {
    config: Config,
    gyro: GyroInput,
    base: Option<BaseDriver>,
    reckoning: DeadReckoning,
    source: HeadingSource,
    bias_method: BiasMethod,
    tested_bias: Option<AngularRate>,
    bias_test_failed: bool,
    pose_not_written: bool,
    reports_lost: bool,
    reference: Angle,
    task: Task,
    /// The base has been told to stop and has not come to rest since.
    stopping: bool,
    pose_write_counter: u8,
    raw_rate: RunningMean,
    /// The last mean of raw readings that was reported.
    last_raw_rate: AngularRate,
    reports: Deque<Report, REPORTS_MAX>,
    health: Health,
    gyro_command: Option<Packet>,
    tick_at: Timestamp,
    state_at: Timestamp,
    started: Timestamp,
}

impl Controller {
    /// A controller that starts `now`, having heard nothing.
    pub fn new(config: Config, now: Timestamp) -> Self {
        let gyro_command = (config.gyro.stream.format == GyroFormat::Dsp3000Ascii)
            .then(|| dsp3000_command::Command::Output(config.gyro.stream.mode).encode());
        Self {
            gyro: GyroInput::new(config.gyro),
            base: config.base.map(BaseDriver::new),
            config,
            reckoning: DeadReckoning::default(),
            source: HeadingSource::Gyro,
            bias_method: BiasMethod::StaticTest,
            tested_bias: None,
            bias_test_failed: false,
            pose_not_written: false,
            reports_lost: false,
            reference: Angle::ZERO,
            task: Task::Idle,
            stopping: false,
            pose_write_counter: 0,
            raw_rate: RunningMean::default(),
            last_raw_rate: AngularRate::ZERO,
            reports: Deque::new(),
            health: Health::default(),
            gyro_command,
            tick_at: Timestamp::MAX,
            state_at: now + STATE_PERIOD_AT_REST,
            started: now,
        }
    }

    /// Takes bytes or a frame that arrived `now`.
    pub fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        match (port, input) {
            (Port::Gyro, Input::Bytes(bytes)) => self.receive_gyro(now, bytes),
            (Port::Base, Input::Bytes(bytes)) => {
                let heard = self.base.as_mut().and_then(|base| base.receive_bytes(now, bytes));
                self.hear_motion(now, heard);
            }
            (Port::Base, Input::Frame(frame)) => {
                let heard = self.base.as_mut().and_then(|base| base.receive_frame(now, &frame));
                self.hear_motion(now, heard);
            }
            // A gyro on CAN is not among the formats.
            (Port::Gyro, Input::Frame(_)) => {}
        }
    }

    /// Does what is due `now`.
    pub fn wake(&mut self, now: Timestamp) {
        if let Some(base) = &mut self.base {
            base.wake(now);
        }
        self.watch_inputs(now);
        if let Task::BiasTest { until, .. } = self.task
            && now >= until
        {
            self.finish_bias_test(now);
        }
        if now >= self.tick_at {
            self.tick(now);
        }
        if now >= self.state_at {
            self.report_state(now);
            self.update_bias();
        }
        self.update_health(now);
    }

    /// When [`Self::wake`] has something to do, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        let mut at = self.state_at.min(self.tick_at);
        if !self.health.causes.gyro_silent {
            at = at.min(self.gyro.silent_at());
        }
        if let Task::BiasTest { until, .. } = self.task {
            at = at.min(until);
        }
        if let Some(base) = &self.base {
            at = at.min(base.next_wakeup());
            if !self.health.causes.base_silent {
                // One nanosecond late: the limit itself is still in time.
                at = at.min(self.base_silent_at() + Span::from_nanos(1));
            }
        }
        at
    }

    /// What goes out next.
    pub fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        if let Some(packet) = self.gyro_command.take() {
            return Some(Output::Bytes(Port::Gyro, packet));
        }
        self.base.as_mut()?.transmit(now).map(|outgoing| match outgoing {
            Outgoing::Frame(frame) => Output::Frame(frame),
            Outgoing::Bytes(packet) => Output::Bytes(Port::Base, packet),
        })
    }

    /// The next report, oldest first.
    pub fn report(&mut self) -> Option<Report> {
        self.reports.pop_front()
    }

    /// How far it can be believed, and why.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// Takes a mission; the answer is a report.
    pub fn command(&mut self, now: Timestamp, mission: Mission) {
        let id = mission.id;
        let answer = match mission.command {
            Command::BiasTest(order) => self.begin_bias_test(now, id, order),
            Command::Straight(order) => {
                let in_range = order.distance.m().abs() <= DISTANCE_M_MAX
                    && order.speed >= SPEED_MIN
                    && self.config.base.is_some_and(|base| order.speed <= base.speed_max);
                self.ready_to_move(now, in_range).map(|sight| {
                    let drive = Drive::straight(id, order, &self.config.motion, &sight);
                    self.begin_drive(now, drive);
                })
            }
            Command::Turn(order) => {
                let in_range = order.angle.rad().abs() <= ANGLE_RAD_MAX
                    && order.rate >= RATE_MIN
                    && self.config.base.is_some_and(|base| order.rate <= base.steer_rate_max);
                self.ready_to_move(now, in_range).map(|mut sight| {
                    self.reference += order.angle;
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
            Command::RequestState => {
                self.report_state(now);
                self.done(id, MissionResult::Applied);
                Ok(())
            }
            Command::Stop => {
                self.abort(AbortReason::Stopped);
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

    /// The heading is held while the base is known to stand and nothing is about to move it.
    fn update_hold(&mut self, now: Timestamp) {
        let about_to_move = matches!(self.task, Task::Drive(_)) || self.stopping;
        let held = self.base.is_some() && !about_to_move && !self.is_moving(now);
        self.gyro.integrator_mut().hold(held);
    }

    fn receive_gyro(&mut self, now: Timestamp, bytes: &[u8]) {
        let Self { gyro, raw_rate, task, .. } = self;
        gyro.receive(now, bytes, |reading, _| {
            raw_rate.add(reading.raw_rate.rad_per_s());
            if let Task::BiasTest { half, until, average, .. } = task
                && now <= *until
            {
                average.add(reading.raw_rate, reading.temperature, now < *half);
            }
        });
        let silent = self.health.causes.gyro_silent;
        if silent || self.health.level == crate::health::Level::Starting {
            self.update_health(now);
        }
    }

    fn hear_motion(&mut self, now: Timestamp, heard: Option<Motion>) {
        let Some(motion) = heard else { return };
        self.reckoning.odometry(&motion);
        let heading = self.heading();
        self.reckoning.advance(&motion, heading);
        if self.stopping && !motion.moving {
            // The next mission starts from where the base came to rest, not from where it was stopped.
            self.stopping = false;
            self.reference = heading;
        }
        if matches!(self.task, Task::PoseDownload(_)) {
            self.step_pose_download(now);
        }
        self.update_health(now);
    }

    /// By the heading source.
    fn heading(&self) -> Angle {
        match self.source {
            HeadingSource::Gyro => self.gyro.integrator().heading(),
            HeadingSource::Odometry => self.reckoning.odometry_heading(),
        }
    }

    fn sight(&self, now: Timestamp) -> Sight {
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
        }
    }

    /// The base is not known to be at rest.
    fn is_moving(&self, now: Timestamp) -> bool {
        match &self.base {
            None => self.mean_raw_rate().abs() > self.config.gyro.bias_max,
            Some(base) => match base.motion() {
                Some((_, motion)) => motion.moving || now > self.base_silent_at(),
                None => true,
            },
        }
    }

    /// Mean of the raw readings since the last state; that state's where there has been none since.
    fn mean_raw_rate(&self) -> AngularRate {
        if self.raw_rate.count() == 0 {
            return self.last_raw_rate;
        }
        AngularRate::from_rad_per_s(self.raw_rate.mean())
    }

    /// When the base's silence becomes a fault. Its messages come slowly while it stands, so a base that
    /// has been told to move is given the short time from that moment on.
    fn base_silent_at(&self) -> Timestamp {
        let (Some(base), Some(config)) = (&self.base, &self.config.base) else {
            return Timestamp::MAX;
        };
        let Some((heard, motion)) = base.motion() else {
            return self.started + config.timeout_at_rest;
        };
        match &self.task {
            Task::Drive(drive) if drive.is_commanding() => {
                heard.max(drive.commanding_since()) + config.timeout_moving
            }
            _ if motion.moving => heard + config.timeout_moving,
            _ => heard + config.timeout_at_rest,
        }
    }

    fn idle_at_rest(&self, now: Timestamp) -> Result<(), Refusal> {
        if !matches!(self.task, Task::Idle) {
            return Err(Refusal::Busy);
        }
        if self.is_moving(now) { Err(Refusal::Moving) } else { Ok(()) }
    }

    fn ready_to_move(&self, now: Timestamp, in_range: bool) -> Result<Sight, Refusal> {
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
            // One that was never heard is silent as well, though no fault before everything has started.
            if self.gyro.is_silent(now) || causes.gyro_fault {
                return Err(Refusal::NoGyro);
            }
            if causes.no_bias {
                return Err(Refusal::NoBias);
            }
        }
        self.idle_at_rest(now)?;
        Ok(self.sight(now))
    }

    fn begin_bias_test(
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
        self.idle_at_rest(now)?;
        let duration = Span::from_secs_f64(order.duration_s);
        self.task = Task::BiasTest {
            id,
            half: now + duration / 2,
            until: now + duration,
            average: BiasAverage::default(),
        };
        Ok(())
    }

    fn finish_bias_test(&mut self, now: Timestamp) {
        let Task::BiasTest { id, average, .. } = &self.task else { return };
        let (id, average) = (*id, *average);
        if !average.was_at_rest(&self.config.gyro) || self.is_moving(now) {
            self.abort(AbortReason::NotAtRest);
            return;
        }
        let calibration = self.gyro.integrator().calibration();
        let table = average.temperature().and_then(|t| calibration.table_bias(t));
        let result = average.result(table);
        self.tested_bias = Some(result.mean);
        self.bias_test_failed = false;
        self.gyro.forgive();
        self.task = Task::Idle;
        self.update_bias();
        self.done(id, MissionResult::BiasTest(result));
    }

    fn begin_drive(&mut self, now: Timestamp, drive: Drive) {
        let MotionRamps { drive: acceleration, steer } = self.base_ramps();
        if let Some(base) = &mut self.base {
            base.request(Request::SetAcceleration { drive: acceleration, steer });
        }
        self.task = Task::Drive(drive);
        self.tick_at = now;
    }

    fn base_ramps(&self) -> MotionRamps {
        let motion = &self.config.motion;
        MotionRamps {
            drive: motion.acceleration * motion.base_acceleration_margin,
            steer: motion.angular_acceleration * motion.base_acceleration_margin,
        }
    }

    fn begin_set_pose(&mut self, now: Timestamp, id: MissionId, pose: Pose) -> Result<(), Refusal> {
        let on_the_wire = Pose { heading: pose.heading.wrapped(), ..pose };
        let writable = encode_request(&Request::WritePose { pose: on_the_wire, counter: 0 });
        if !pose.is_finite() || (self.base.is_some() && writable.is_none()) {
            return Err(Refusal::OutOfRange);
        }
        self.idle_at_rest(now)?;
        self.gyro.integrator_mut().set_heading(pose.heading);
        self.reckoning.place(pose);
        self.reference = pose.heading;
        if self.base.is_none() {
            self.done(id, MissionResult::Applied);
        } else {
            self.begin_pose_download(now, id, pose, MissionResult::Applied);
        }
        Ok(())
    }

    fn begin_pose_download(
        &mut self,
        now: Timestamp,
        id: MissionId,
        pose: Pose,
        result: MissionResult,
    ) {
        let download = PoseDownload::new(id, pose, result, self.pose_write_counter, now);
        self.task = Task::PoseDownload(download);
        self.step_pose_download(now);
    }

    fn step_pose_download(&mut self, now: Timestamp) {
        let Task::PoseDownload(download) = &mut self.task else { return };
        let Some(base) = &mut self.base else { return };
        let Some((_, motion)) = base.motion() else { return };
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
                self.abort(AbortReason::PoseWriteRefused);
            }
        }
    }

    /// One period of the control loops.
    fn tick(&mut self, now: Timestamp) {
        // Periods keep their grid; a late wake-up does not shift those that follow.
        self.tick_at = (self.tick_at + self.config.motion.period).max(now);
        match &self.task {
            Task::Drive(_) => self.tick_drive(now),
            Task::PoseDownload(_) => self.step_pose_download(now),
            Task::Idle | Task::BiasTest { .. } if self.stopping => {
                if let Some(base) = &mut self.base {
                    base.request(Request::Stop);
                    base.poll(now);
                }
            }
            Task::Idle | Task::BiasTest { .. } => self.tick_at = Timestamp::MAX,
        }
    }

    fn tick_drive(&mut self, now: Timestamp) {
        let sight = self.sight(now);
        let Task::Drive(drive) = &mut self.task else { return };
        match drive.tick(&sight, &self.config.motion) {
            Wish::Rates { drive, steer } => {
                if let Some(base) = &mut self.base {
                    base.request(Request::SetVelocity { drive, steer });
                    base.poll(now);
                }
                self.report_state(now);
            }
            Wish::Finished(result) => {
                let (id, is_straight) = (drive.id, drive.is_straight());
                // Only a heading that the base does not have itself is worth writing.
                if is_straight && self.source == HeadingSource::Gyro {
                    self.begin_pose_download(now, id, sight.pose, result);
                } else {
                    self.finish(now, id, result);
                }
            }
            Wish::TimedOut => {
                self.abort(AbortReason::TimedOut);
                self.stop_base(now);
            }
        }
    }

    /// Looks for what forbids the running mission.
    fn watch_inputs(&mut self, now: Timestamp) {
        let needs_gyro = match &self.task {
            Task::Idle => return,
            Task::BiasTest { .. } => true,
            Task::Drive(_) | Task::PoseDownload(_) => self.source == HeadingSource::Gyro,
        };
        let moves = matches!(self.task, Task::Drive(_));
        let causes = self.causes(now);
        let motion = self.base.as_ref().and_then(BaseDriver::motion).map(|(_, motion)| motion);
        let reason = if needs_gyro && causes.gyro_silent {
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
        self.abort(reason);
        if moves {
            self.stop_base(now);
        }
    }

    /// The base stopped by itself while a mission drove it. It goes on saying so until it hears the
    /// next velocity, so that nothing it says before that is meant for this mission.
    fn has_command_timed_out(&self, now: Timestamp) -> bool {
        let (Task::Drive(drive), Some(config), Some(base)) =
            (&self.task, &self.config.base, &self.base)
        else {
            return false;
        };
        now > drive.commanding_since() + config.timeout_moving
            && base.motion().is_some_and(|(_, motion)| motion.command_timed_out)
    }

    fn abort(&mut self, reason: AbortReason) {
        let id = match &self.task {
            Task::Idle => return,
            Task::BiasTest { id, .. } => *id,
            Task::Drive(drive) => drive.id,
            Task::PoseDownload(download) => download.id,
        };
        self.bias_test_failed |= matches!(self.task, Task::BiasTest { .. });
        if matches!(self.task, Task::Drive(_)) {
            // What was to be reached is void: the next mission starts from where this one ended.
            self.reference = self.heading();
        }
        self.task = Task::Idle;
        self.push_report(Report::Aborted { id, reason });
    }

    /// Stops the base and goes on telling it until it says that it is at rest.
    fn stop_base(&mut self, now: Timestamp) {
        if let Some(base) = &mut self.base {
            base.request(Request::Stop);
            base.poll(now);
            self.stopping = true;
            self.tick_at = now + self.config.motion.period;
        }
    }

    fn finish(&mut self, now: Timestamp, id: MissionId, result: MissionResult) {
        self.task = Task::Idle;
        self.tick_at = Timestamp::MAX;
        self.report_state(now);
        self.done(id, result);
    }

    fn done(&mut self, id: MissionId, result: MissionResult) {
        self.push_report(Report::Done { id, result });
    }

    /// The bias in force follows the method.
    fn update_bias(&mut self) {
        if let Some(bias) = self.chosen_bias() {
            self.gyro.integrator_mut().set_bias(bias);
        }
    }

    fn chosen_bias(&self) -> Option<AngularRate> {
        match self.bias_method {
            BiasMethod::StaticTest => self.tested_bias,
            BiasMethod::TemperatureTable => {
                let integrator = self.gyro.integrator();
                integrator.temperature().and_then(|t| integrator.calibration().table_bias(t))
            }
            BiasMethod::None => Some(AngularRate::ZERO),
        }
    }

    fn causes(&self, now: Timestamp) -> Causes {
        let trouble = self.gyro.trouble();
        let motion = self.base.as_ref().and_then(BaseDriver::motion).map(|(_, motion)| motion);
        Causes {
            gyro_silent: !self.gyro.is_starting() && self.gyro.is_silent(now),
            gyro_fault: self.gyro.is_invalid(now),
            base_silent: self.base.is_some() && now > self.base_silent_at(),
            base_not_ready: motion.is_some_and(|motion| motion.emergency_stop || motion.fault),
            gyro_over_range: trouble.over_range,
            gyro_invalid: trouble.invalid,
            samples_lost: trouble.lost,
            clock_mismatch: trouble.clock_mismatch,
            no_bias: self.chosen_bias().is_none(),
            bias_test_failed: self.bias_test_failed,
            pose_not_written: self.pose_not_written,
            overflow: self.reports_lost
                || self.base.as_ref().is_some_and(|base| base.refused() > 0),
        }
    }

    fn update_health(&mut self, now: Timestamp) {
        self.update_hold(now);
        let starting = self.gyro.is_starting()
            || self.base.as_ref().is_some_and(|base| base.motion().is_none());
        let health = Health::new(starting, self.causes(now));
        if health != self.health {
            self.health = health;
            self.push_report(Report::Health(health));
        }
    }

    fn activity(&self) -> Activity {
        match &self.task {
            Task::Idle => Activity::Idle,
            Task::BiasTest { .. } => Activity::BiasTest,
            Task::Drive(drive) => drive.activity(),
            Task::PoseDownload(_) => Activity::PoseDownload,
        }
    }

    fn report_state(&mut self, now: Timestamp) {
        let heading = self.heading();
        let integrator = self.gyro.integrator();
        let straight = matches!(&self.task, Task::Drive(drive) if drive.is_straight());
        let state = State {
            activity: self.activity(),
            pose: self.reckoning.pose(heading),
            gyro_heading: integrator.heading(),
            odometry_heading: self.reckoning.odometry_heading(),
            displacement: self.reckoning.displacement(),
            heading_error: straight.then(|| self.reference - heading),
            raw_rate: AngularRate::from_rad_per_s(self.raw_rate.mean()),
            bias: integrator.bias(),
            temperature: integrator.temperature(),
            moving: self.is_moving(now),
            samples: integrator.samples(),
            samples_lost: integrator.samples_lost(),
            clock_ratio: integrator.clock_ratio(),
            health: self.health,
        };
        self.last_raw_rate = self.mean_raw_rate();
        self.raw_rate = RunningMean::default();
        self.state_at = now + STATE_PERIOD_AT_REST;
        self.push_report(Report::State(state));
    }

    /// The oldest state gives way to a new report; if there is none, the new report is lost.
    fn push_report(&mut self, report: Report) {
        if let Err(report) = self.reports.push_back(report) {
            self.reports_lost = true;
            let mut kept: Deque<Report, REPORTS_MAX> = Deque::new();
            let mut made_room = false;
            while let Some(waiting) = self.reports.pop_front() {
                if !made_room && matches!(waiting, Report::State(_)) {
                    made_room = true;
                } else {
                    // As many places as there were.
                    let _ = kept.push_back(waiting);
                }
            }
            self.reports = kept;
            let _ = self.reports.push_back(report);
        }
    }
}

struct MotionRamps {
    drive: wire::units::Acceleration,
    steer: wire::units::AngularAcceleration,
}
