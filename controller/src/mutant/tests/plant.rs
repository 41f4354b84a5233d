//! An ideal base on CAN with an ideal gyro on it, in steps of one gyro sample.

use super::Mutant;
use crate::config::{BaseConfig, Config, GyroConfig, MotionConfig, Transport};
use crate::health::Level;
use crate::mission::{BiasTest, Command, Mission, MissionId, Report};
use crate::{Controller, Input, Output, Port};
use std::boxed::Box;
use std::vec::Vec;
use wire::base::{Motion, PoseWriteResult, Reply, Request, can_link};
use wire::gyro::navigator::SEQUENCE_MODULUS;
use wire::gyro::{GyroEncoder, GyroOutput, GyroSample, GyroStatus, Sequence};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length};

const STEP: Span = Span::from_millis(10);
/// Gyro samples for each motion message.
const SAMPLES_PER_MOTION: u32 = 2;
/// m/s^2 and rad/s^2
const RAMPS: (f64, f64) = (0.6, 0.4);
/// Longer than any mission of these tests.
const ANSWER_LIMIT: Span = Span::from_secs(120);

/// Modifies a sample; the number is the count of samples before it.
pub(super) type Spoil = Box<dyn FnMut(&mut GyroSample, u32)>;

pub(super) struct Plant {
    controller: Controller,
    pub(super) gyro_speaks: bool,
    /// Each sample arrives twice.
    pub(super) gyro_stutters: bool,
    /// rad/s
    pub(super) gyro_range: f64,
    pub(super) spoil: Spoil,
    pub(super) base_speaks: bool,
    /// Time that each request is on its way to the base.
    pub(super) requests_late: Span,
    /// The odometer stays at its value from when it began to stand still.
    pub(super) odometer_stands: bool,
    /// rad
    pub(super) heading: f64,
    /// m/s
    pub(super) drive: f64,
    pub(super) written_in_motion: u32,
    /// How often the ramps were sent.
    pub(super) ramps_sent: u32,
    /// The last request that arrived.
    pub(super) last: Option<Request>,
    /// m
    displacement: f64,
    steer: f64,
    targets: (f64, f64),
    motion: Motion,
    on_their_way: Vec<(Timestamp, Request)>,
    encoder: GyroEncoder,
    samples: u32,
    now: Timestamp,
    next_id: MissionId,
    answers: Vec<(MissionId, Report)>,
    believed: Angle,
    said_to_stand: bool,
}

impl Plant {
    /// A plant with all inputs present and the bias known.
    pub(super) fn ready(mutant: Option<Mutant>) -> Self {
        let gyro = GyroConfig::default();
        let base = BaseConfig::new(Transport::Can);
        let mut config = Config::new(gyro, Some(base), MotionConfig::default());
        config.mutant = mutant;
        let mut plant = Self {
            controller: Controller::new(config, Timestamp::ZERO),
            gyro_speaks: true,
            gyro_stutters: false,
            gyro_range: f64::INFINITY,
            spoil: Box::new(|_, _| {}),
            base_speaks: true,
            requests_late: Span::ZERO,
            on_their_way: Vec::new(),
            odometer_stands: false,
            displacement: 0.0,
            heading: 0.0,
            drive: 0.0,
            written_in_motion: 0,
            ramps_sent: 0,
            last: None,
            steer: 0.0,
            targets: (0.0, 0.0),
            motion: Motion::default(),
            encoder: GyroEncoder::new(gyro.stream),
            samples: 0,
            now: Timestamp::ZERO,
            next_id: 1,
            answers: Vec::new(),
            believed: Angle::ZERO,
            said_to_stand: false,
        };
        plant.run(Span::from_secs(1));
        plant.command(Command::BiasTest(BiasTest { duration_s: 1.0 }));
        plant
    }

    pub(super) fn begin(&mut self, command: Command) -> MissionId {
        let id = self.next_id;
        self.next_id += 1;
        self.controller.command(self.now, Mission { id, command });
        self.transmit();
        id
    }

    /// Starts a mission and runs until its answer.
    pub(super) fn command(&mut self, command: Command) -> Report {
        let id = self.begin(command);
        let until = self.now + ANSWER_LIMIT;
        loop {
            if let Some((_, report)) = self.answers.iter().find(|(answered, _)| *answered == id) {
                return *report;
            }
            assert!(self.now < until, "mission {id} was never answered");
            self.step();
        }
    }

    /// True if the controller's health is `ok`.
    pub(super) fn is_well(&self) -> bool {
        self.controller.health().level == Level::Ok
    }

    /// True if the controller commands the base to turn or drive.
    pub(super) fn is_told_to_move(&self) -> bool {
        self.targets != (0.0, 0.0)
    }

    /// True if a state of now calls the base at rest.
    pub(super) fn is_said_to_stand(&mut self) -> bool {
        self.command(Command::RequestState);
        self.said_to_stand
    }

    /// Estimated minus true heading, rad.
    pub(super) fn heading_error(&mut self) -> f64 {
        self.command(Command::RequestState);
        self.believed.rad() - self.heading
    }

    pub(super) fn run(&mut self, span: Span) {
        let until = self.now + span;
        while self.now < until {
            self.step();
        }
    }

    fn step(&mut self) {
        let end = self.now + STEP;
        while self.controller.next_wakeup() < end {
            self.now = self.now.max(self.controller.next_wakeup());
            self.controller.wake(self.now);
            self.transmit();
        }
        self.now = end;
        let step_s = STEP.as_secs_f64();
        let ramp = |rate: f64, target: f64, limit: f64| {
            rate + (target - rate).clamp(-limit * step_s, limit * step_s)
        };
        self.drive = ramp(self.drive, self.targets.0, RAMPS.0);
        self.steer = ramp(self.steer, self.targets.1, RAMPS.1);
        self.heading += self.steer * step_s;
        self.displacement += self.drive * step_s;
        if !self.odometer_stands {
            self.motion.displacement = Length::from_m(self.displacement);
        }
        self.speak();
        self.transmit();
    }

    fn is_moving(&self) -> bool {
        self.drive != 0.0 || self.steer != 0.0
    }

    fn speak(&mut self) {
        self.samples += 1;
        let rate = self.steer.clamp(-self.gyro_range, self.gyro_range);
        let value = (self.samples % u32::from(SEQUENCE_MODULUS)) as u8;
        let mut sample = GyroSample {
            output: GyroOutput::Rate(AngularRate::from_rad_per_s(rate)),
            valid: true,
            status: GyroStatus { over_range: rate != self.steer, ..GyroStatus::default() },
            temperature: None,
            sequence: Some(Sequence { value, modulus: SEQUENCE_MODULUS }),
        };
        (self.spoil)(&mut sample, self.samples);
        let packet = self.encoder.encode(&sample);
        let times = u32::from(self.gyro_speaks) * (1 + u32::from(self.gyro_stutters));
        for _ in 0..times {
            self.controller.receive(self.now, Port::Gyro, Input::Bytes(packet.as_slice()));
        }
        if self.base_speaks && self.samples.is_multiple_of(SAMPLES_PER_MOTION) {
            self.motion.heading = Angle::from_rad(self.heading).wrapped();
            self.motion.moving = self.is_moving();
            self.motion.sequence = self.motion.sequence.wrapping_add(1);
            let frame = can_link::reply_frame(&Reply::Motion(self.motion));
            self.controller.receive(self.now, Port::Base, Input::Frame(frame));
        }
    }

    fn transmit(&mut self) {
        while let Some(output) = self.controller.transmit(self.now) {
            let Output::Frame(frame) = output else { continue };
            let arrives = self.now + self.requests_late;
            self.on_their_way.extend(can_link::parse_request(&frame).map(|it| (arrives, it)));
        }
        while self.on_their_way.first().is_some_and(|(at, _)| *at <= self.now) {
            let request = self.on_their_way.remove(0).1;
            self.last = Some(request);
            match request {
                Request::SetVelocity { drive, steer } => {
                    self.targets = (drive.m_per_s(), steer.rad_per_s());
                }
                Request::SetAcceleration { .. } => self.ramps_sent += 1,
                Request::Stop => self.targets = (0.0, 0.0),
                Request::WritePose { counter, .. } => {
                    let moving = self.is_moving();
                    self.written_in_motion += u32::from(moving);
                    self.motion.pose_write_counter = counter;
                    self.motion.pose_write = if moving {
                        PoseWriteResult::RefusedInMotion
                    } else {
                        PoseWriteResult::Accepted
                    };
                }
                _ => {}
            }
        }
        while let Some(report) = self.controller.report() {
            if let Report::State(state) = report {
                self.believed = state.gyro_heading;
                self.said_to_stand = !state.moving;
            }
            if let Report::Done { id, .. }
            | Report::Refused { id, .. }
            | Report::Aborted { id, .. } = report
            {
                self.answers.push((id, report));
            }
        }
    }
}
