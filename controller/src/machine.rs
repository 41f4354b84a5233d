//! The complete controller: inputs, missions, requests and reports.
//!
//! * `tasks`: acceptance of missions and the steps of each.
//! * `supervision`: monitoring during and between missions. `reporting`: the reports.

mod estimating;
mod misread;
mod reporting;
mod supervision;
mod tasks;

use crate::base_driver::{BaseDriver, Outgoing};
use crate::bias_test::{BiasAverage, RunningMean};
use crate::config::Config;
use crate::dead_reckoning::DeadReckoning;
use crate::drive::Drive;
use crate::follow_watch::{CountWatch, FollowWatch};
use crate::gyro_input::GyroInput;
use crate::heading::Reading;
use crate::heading_watch::{HeadingWatch, Heard};
use crate::health::{Health, Level};
use crate::mission::{BiasMethod, Estimator, HeadingSource, MissionId, Report};
use crate::mutant::Mutant;
use crate::own_time::OwnTime;
use crate::pose_download::PoseDownload;
use crate::standstill::{Rest, Standstill};
use estimating::Estimating;
use heapless::Deque;
use wire::base::payload::{COUNTS_PER_DEG, COUNTS_PER_M};
use wire::base::{Motion, Request};
use wire::can::CanFrame;
use wire::gyro::{GyroDecoder, dsp3000_command};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Speed};

/// Capacity of the report queue; a full queue drops the oldest state, and the loss shows in health.
pub const REPORTS_MAX: usize = 64;
/// Period of state reports while nothing moves.
pub const STATE_PERIOD_AT_REST: Span = Span::from_secs(1);
/// Longest accepted bias test.
pub const BIAS_TEST_S_MAX: f64 = 3_600.0;
/// Longest path and largest turn of one mission: a larger number is a mistake.
pub const DISTANCE_M_MAX: f64 = 1_000.0;
/// See [`DISTANCE_M_MAX`].
pub const ANGLE_RAD_MAX: f64 = 1_000.0;
/// Slowest speed of a mission: one count on the wire. Below it the command would be a stop.
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

/// Input of a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input<'a> {
    /// Serial bytes.
    Bytes(&'a [u8]),
    /// A CAN frame.
    Frame(CanFrame),
}

/// Output of a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Output {
    /// Serial bytes.
    Bytes(Port, Packet),
    /// A CAN frame, to the base.
    Frame(CanFrame),
}

/// What the controller does; a pose is downloaded with the drive that it ends.
#[derive(Debug, Clone)]
enum Task {
    Idle,
    BiasTest { id: MissionId, half: Timestamp, until: Timestamp, average: BiasAverage },
    Drive(Drive),
    PoseDownload(PoseDownload, Option<Drive>),
}

/// Summary of the samples that arrived at once.
#[derive(Debug, Default)]
struct GyroNews {
    /// The base was pushed.
    pushed: bool,
    /// A piece of a standstill.
    rest: Option<Rest>,
    /// The first reading after a silence.
    returned: Option<Reading>,
}

/// The code under test: one gyro, at most one base, one mission at a time. Times are those of the host's clock; if
/// that is set back, the controller's own time continues.
#[derive(Debug, Clone)]
pub struct Controller {
    time: OwnTime,
    config: Config,
    decoder: GyroDecoder,
    gyro: GyroInput,
    base: Option<BaseDriver>,
    reckoning: DeadReckoning,
    source: HeadingSource,
    bias_method: BiasMethod,
    tested_bias: Option<AngularRate>,
    /// Spread of the readings of that test.
    tested_spread: AngularRate,
    bias_test_failed: bool,
    bias_moved: bool,
    /// The base drove since a pose was last set, and with a bias that had moved.
    has_driven: bool,
    turned_by_bias: bool,
    moved_at_rest: bool,
    headings: HeadingWatch,
    headings_disagree: bool,
    /// The base stands and no command will move it.
    stands: bool,
    standstill: Standstill,
    estimating: Option<Estimating>,
    estimator_failed: bool,
    pose_not_written: bool,
    odometry_doubtful: bool,
    /// The path of a drive that was broken off, until the base stands.
    broken_off: Option<FollowWatch>,
    counts: CountWatch,
    /// The base fell silent while it moved, and has not been heard to stand since.
    is_unfollowed: bool,
    reports_lost: bool,
    reference: Angle,
    task: Task,
    /// The base was commanded to stop and has not come to rest yet.
    stopping: bool,
    pose_write_counter: u8,
    raw_rate: RunningMean,
    /// The last reported mean of raw readings.
    last_raw_rate: AngularRate,
    reports: Deque<Report, REPORTS_MAX>,
    health: Health,
    gyro_command: Option<Packet>,
    tick_at: Timestamp,
    state_at: Timestamp,
    started: Timestamp,
}

impl Controller {
    /// A controller that starts at `now`, without any input yet.
    pub fn new(config: Config, now: Timestamp) -> Self {
        let mut stream = config.gyro.stream;
        stream.reversed &= !config.planted().is(Mutant::SignIgnored);
        let takes_commands = stream.format.facts().takes_commands;
        let gyro_command =
            takes_commands.then(|| dsp3000_command::Command::Output(stream.mode).encode());
        let mut gyro = GyroInput::new(config.gyro, config.base.is_some());
        gyro.plant(config.planted());
        let mut time = OwnTime::new(config.planted());
        let now = time.hear(now);
        let mut controller = Self {
            time,
            decoder: GyroDecoder::new(stream),
            gyro,
            base: config.base.map(|base| BaseDriver::new(base, config.planted())),
            config,
            reckoning: DeadReckoning::default(),
            source: HeadingSource::Gyro,
            bias_method: BiasMethod::StaticTest,
            tested_bias: None,
            tested_spread: AngularRate::ZERO,
            bias_test_failed: false,
            bias_moved: false,
            has_driven: false,
            turned_by_bias: false,
            moved_at_rest: false,
            headings: HeadingWatch::default(),
            headings_disagree: false,
            stands: false,
            standstill: Standstill::default(),
            estimating: None,
            estimator_failed: false,
            pose_not_written: false,
            odometry_doubtful: false,
            broken_off: None,
            counts: CountWatch::default(),
            is_unfollowed: false,
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
        };
        controller.set_estimator(Estimator::Paper);
        controller
    }

    /// Takes bytes or a frame that arrived at `now`.
    pub fn receive(&mut self, now: Timestamp, port: Port, input: Input<'_>) {
        let now = self.awake(now);
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
            // No gyro format uses CAN.
            (Port::Gyro, Input::Frame(_)) => {}
        }
    }

    /// Does the work due at `now`.
    pub fn wake(&mut self, now: Timestamp) {
        let now = self.awake(now);
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

    /// Time at which [`Self::wake`] has work, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        self.time.told(self.due_at())
    }

    fn due_at(&self) -> Timestamp {
        let mut at = self.state_at.min(self.tick_at);
        // A silence that does not show in health has been noticed all the same.
        let hides = self.plants(Mutant::HealthSilent);
        if !self.health.causes.gyro_silent && !hides {
            at = at.min(self.gyro_lost_at());
        }
        if let Task::BiasTest { until, .. } = self.task {
            at = at.min(until);
        }
        if let Some(base) = &self.base {
            at = at.min(base.next_wakeup());
            if !self.health.causes.base_silent && !hides {
                // One nanosecond later: a message exactly at the limit is still in time.
                at = at.min(self.base_silent_at() + Span::from_nanos(1));
            }
        }
        at
    }

    /// The next output.
    pub fn transmit(&mut self, now: Timestamp) -> Option<Output> {
        // Does not advance the controller's time, so the caller may ask at any moment.
        let now = self.time.at(now);
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

    /// True if neither [`Self::transmit`] nor [`Self::report`] can have output at `now`.
    #[inline]
    pub fn has_nothing_to_say(&self, now: Timestamp) -> bool {
        let now = self.time.at(now);
        self.gyro_command.is_none()
            && self.reports.is_empty()
            && self.base.as_ref().is_none_or(|base| base.has_nothing_to_send(now))
    }

    /// The trust level and its reasons.
    pub const fn health(&self) -> Health {
        self.health
    }

    fn receive_gyro(&mut self, now: Timestamp, bytes: &[u8]) {
        let held = self.gyro.integrator().is_held();
        let period = self.config.gyro.stream.format.period();
        let mut news = GyroNews::default();
        self.decoder.feed(bytes, |sample| {
            let Some(reading) = self.gyro.take(now, &sample) else { return };
            self.raw_rate.add(reading.raw_rate.rad_per_s());
            news.pushed |= reading.pushed;
            let passed = period * (1 + i64::from(reading.lost));
            Self::estimate_passed(&mut self.estimating, passed, reading.lost, held);
            if reading.after_silence || reading.pushed {
                self.standstill.is_broken_off();
            } else if self.stands
                && let Some(rest) = self.standstill.reading(now, reading.raw_rate)
            {
                news.rest = Some(rest);
            }
            if let Task::BiasTest { half, until, average, .. } = &mut self.task
                && now <= *until
            {
                average.add(reading.raw_rate, reading.temperature, now < *half);
            }
            if reading.after_silence || reading.stalled {
                news.returned = Some(reading);
            }
        });
        self.gyro.took();
        let GyroNews { pushed, rest, returned } = news;
        if let Some(reading) = returned {
            self.end_bridge(now, reading.stalled, reading.raw_rate);
        }
        self.look_at_rest(now, rest);
        // Before a bias is known, the whole reading may be bias.
        let blind = self.config.planted().blinds_second_looks();
        let pushed = pushed && self.tested_bias.is_some() && !self.moved_at_rest && !blind;
        self.moved_at_rest |= pushed;
        if self.health.causes.gyro_silent || pushed || self.health.level == Level::Starting {
            self.update_health(now);
        }
    }

    fn hear_motion(&mut self, now: Timestamp, heard: Option<Motion>) {
        let Some(mut motion) = heard else { return };
        if self.plants(Mutant::ShortInch) {
            motion.displacement = motion.displacement * (25.0 / 25.4);
        }
        if self.base.as_ref().is_some_and(BaseDriver::counts_anew) {
            self.reckoning.count_anew(&motion);
            self.odometry_doubtful = true;
        }
        self.reckoning.odometry(&motion);
        let heading = self.heading();
        let heading = if self.plants(Mutant::MirroredReckoning) { -heading } else { heading };
        self.reckoning.advance(&motion, heading);
        self.look_at_motion(now, &motion);
        self.estimate_in_motion(now);
        if self.stopping && self.base.as_ref().is_none_or(|base| !base.may_move()) {
            // The next mission starts from where the base came to rest, not from where the stop was commanded.
            self.stopping = false;
            self.reference = heading;
        }
        if matches!(self.task, Task::PoseDownload(..)) {
            self.step_pose_download(now);
        }
        self.update_health(now);
    }

    /// Runs one period of the control loops.
    fn tick(&mut self, now: Timestamp) {
        // Periods keep their grid; a late wake-up does not shift the following ones.
        self.tick_at = (self.tick_at + self.config.motion.period).max(now);
        match &self.task {
            Task::Drive(_) => self.tick_drive(now),
            Task::PoseDownload(..) => self.step_pose_download(now),
            Task::Idle | Task::BiasTest { .. } if self.stopping => {
                if let Some(base) = &mut self.base {
                    base.request(Request::Stop);
                    if base.may_move() {
                        base.request_again(self.config.motion.ramps());
                    }
                    base.poll(now);
                }
            }
            Task::Idle | Task::BiasTest { .. } => self.tick_at = Timestamp::MAX,
        }
    }
}
