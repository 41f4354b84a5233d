//! A K2A-style synchro-drive base: takes commands, moves, reports its own odometry.
//!
//! All wheels steer and drive together; a turret turns with them. Its heading, body heading plus steering angle, is
//! the direction of travel and the input of a gyro on the turret. The odometer counts path and steering angle; the
//! truth differs by scale errors and by the rotation of the body ([`curvature`]).
//!
//! Rates ramp to the commanded ones under the accelerations in force: the host's, or the hardware's if lower. Drive
//! and steering follow the ramps like servos, with noise, stiction and play (`servo.rs`). Between commands, ramp ends
//! and other changes, motion is a closed form of time, or pieces of 20 ms on a fixed grid while the base steers and
//! drives at once. It therefore does not depend on how often the state is read.
//!
//! # Odometry against truth on a closed lap
//!
//! A lap that closes by odometry turns the odometer by 360 deg. With a turn scale error e the steering
//! truly turns 360 (1 + e) deg, and leakage k0 adds k0 times the path, counter-clockwise for k0 > 0
//! whichever way the lap goes. With E = |odometry| - |true|, as in the paper's Eq. 1,
//!
//! E_cw = -360 e + k0 s,  E_ccw = -360 e - k0 s.
//!
//! The paper's -2 and -6 deg over s = 16 m give e = 4/360 = 1.1 % and k0 = 2 deg / 16 m = 0.125 deg/m.

mod commands;
pub mod curvature;
mod direction;
mod fault;
mod kinematics;
mod parameters;
mod ramp;
mod reports;
mod servo;
#[cfg(test)]
mod tests;
mod track;

pub use fault::BaseFault;
pub use parameters::{BaseParameters, Wheel};
pub use reports::{MOTION_PERIOD_AT_REST, MOTION_PERIOD_IN_MOTION, OUTPUTS_MAX, POSE_PERIOD};
use wire::device::Transmit;

use crate::fault::Switches;
use crate::parameters::{ParameterError, Parameters as _};
use commands::Spread;
use fault::Kept;
use kinematics::{Kinematics, State};
use reports::Reports;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use track::TrackModel;
use wire::base::serial_link::{Device, DeviceEvent, write_answer};
use wire::base::{Message, Motion, Reply, Request, can_link};
use wire::can::CanFrame;
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

/// How a base is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Transport {
    /// Classic CAN; the base reports of its own accord.
    Can,
    /// A serial line; the base answers.
    Serial,
}

/// True state of a base at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseTruth {
    /// The centre on the floor, and the turret's heading (unwrapped).
    pub pose: Pose,
    /// Heading of the body (unwrapped): zero until an effect turns it.
    pub body_heading: Angle,
    /// Steering angle relative to the body (unwrapped).
    pub steering_angle: Angle,
    /// Speed along the wheels' direction.
    pub speed: Speed,
    /// The speed at which the wheels turn: the same, unless they slip.
    pub wheels: Speed,
    /// Rate of the steering relative to the body.
    pub steer_rate: AngularRate,
    /// What drive and steering follow, with noise, stiction and play, or exactly.
    pub followed: (Speed, AngularRate),
}

/// An emulated base.
#[derive(Debug, Clone)]
pub struct BaseEmulator {
    parameters: BaseParameters,
    kinematics: Kinematics,
    /// Limits set by the host: drive in m/s^2, steering in rad/s^2.
    limits: (f64, f64),
    /// Time-out of the velocity command; `None` if there is nothing to stop.
    deadline: Option<Timestamp>,
    status: Motion,
    /// The odometer's heading at the last pose write, in rad.
    steered_at_write: f64,
    turn_scale: Spread,
    leakage: Spread,
    drive_noise: Spread,
    steering_noise: Spread,
    /// Time of the next noise draw for both rates.
    noise_due: Timestamp,
    device: Device,
    frames_ignored: u64,
    reports: Reports,
    faults: Switches<Kept>,
    /// A delayed stop and its time.
    late_stop: Option<(Timestamp, Request)>,
    /// What it reported last.
    said: VecDeque<Motion>,
}

/// Number of remembered reports: of ten seconds in motion.
const SAID_MAX: usize = 512;

impl BaseEmulator {
    /// The base `name` in a run with `seed`, at rest at the origin, heading along the x axis.
    pub fn new(parameters: BaseParameters, transport: Transport, seed: u64, name: &str) -> Self {
        let limits = (
            parameters.acceleration_m_per_s2,
            Angle::from_deg(parameters.steer_acceleration_deg_per_s2).rad(),
        );
        let mut base = Self {
            kinematics: Kinematics::new(TrackModel::PERFECT),
            parameters,
            limits,
            deadline: None,
            status: Motion::default(),
            steered_at_write: 0.0,
            turn_scale: Spread::new(seed, name, "base turn scale"),
            leakage: Spread::new(seed, name, "base leakage"),
            drive_noise: Spread::new(seed, name, "base drive noise"),
            steering_noise: Spread::new(seed, name, "base steering noise"),
            noise_due: Timestamp::MAX,
            device: Device::default(),
            frames_ignored: 0,
            reports: Reports::new(transport),
            faults: Switches::default(),
            late_stop: None,
            said: VecDeque::new(),
        };
        base.apply_track_model(Timestamp::ZERO);
        base
    }

    /// Takes a frame from the bus. Other frames than requests are counted and ignored.
    pub fn receive_frame(&mut self, now: Timestamp, frame: &CanFrame) {
        match can_link::parse_request(frame) {
            Some(request) => self.request(now, request),
            None => self.frames_ignored = self.frames_ignored.saturating_add(1),
        }
    }

    /// Takes bytes from the serial line, in pieces of any length.
    pub fn receive_bytes(&mut self, now: Timestamp, bytes: &[u8]) {
        let mut device = std::mem::take(&mut self.device);
        device.feed(bytes, |event| match event {
            DeviceEvent::Write { request, answer } => {
                self.request(now, request);
                self.reports.answer(write_answer(answer));
            }
            DeviceEvent::Read(read) => {
                self.advance(now);
                let reply = match read.message() {
                    Message::Pose => Reply::Pose(self.reported_pose(now)),
                    _ => Reply::Motion(self.reported_motion(now)),
                };
                if let Some(packet) = read.packet(&reply) {
                    self.reports.answer(packet);
                }
            }
            DeviceEvent::Refused(_) => {}
        });
        self.device = device;
    }

    /// Advances to `now` and, on CAN, sends the reports that are due.
    pub fn wake(&mut self, now: Timestamp) {
        self.advance(now);
        self.report(now);
    }

    /// The next output, if any; after each receive and wake, call until it returns `None`.
    pub fn transmit(&mut self) -> Option<Transmit> {
        self.reports.transmit()
    }

    /// Time of the next [`wake`](Self::wake): `None` for a serial base at rest.
    pub fn next_wakeup(&self) -> Option<Timestamp> {
        let late_stop = self.late_stop.map_or(Timestamp::MAX, |(at, _)| at);
        let next = self.next_change().min(self.reports.next_due()).min(late_stop);
        (next < Timestamp::MAX).then_some(next)
    }

    /// Carries out a request, on either transport.
    pub fn request(&mut self, now: Timestamp, request: Request) {
        self.advance(now);
        let at_once =
            if self.faults.is_empty() { Some(request) } else { self.through_faults(now, request) };
        if let Some(request) = at_once {
            self.carry_out(now, request);
        }
        self.report(now);
    }

    fn carry_out(&mut self, now: Timestamp, request: Request) {
        match request {
            Request::SetVelocity { drive, steer } => self.set_velocity(now, drive, steer),
            Request::SetAcceleration { drive, steer } => {
                self.set_acceleration(now, drive, steer);
            }
            Request::WritePose { pose, counter } => self.write_pose(now, pose, counter),
            Request::Stop => {
                self.deadline = None;
                self.ramp_to(now, (0.0, 0.0), self.accelerations());
            }
            // Only the serial line can read, and it answers by itself.
            Request::ReadMotion | Request::ReadPose => {}
        }
    }

    /// Presses or releases the emergency stop: the base stops as hard as it can, and takes no velocity while it is
    /// pressed.
    pub fn set_emergency_stop(&mut self, now: Timestamp, pressed: bool) {
        self.advance(now);
        self.status.emergency_stop = pressed;
        self.inhibit(now);
    }

    /// Sets or clears a drive fault: like the emergency stop, with another flag.
    pub fn set_fault(&mut self, now: Timestamp, fault: bool) {
        self.advance(now);
        self.status.fault = fault;
        self.inhibit(now);
    }

    /// Puts the base, at rest, elsewhere, as if carried: centre and turret's heading. Its odometry does not notice. In
    /// motion, does nothing and returns `false`.
    pub fn place(&mut self, now: Timestamp, pose: Pose) -> bool {
        self.advance(now);
        if self.kinematics.is_moving() || !pose.is_finite() {
            return false;
        }
        let mut state = self.kinematics.state_at(now);
        state.truth.x = pose.x.m();
        state.truth.y = pose.y.m();
        state.truth.body = pose.heading.rad() - state.truth.steer;
        self.kinematics.set_state(state);
        true
    }

    /// Sets the parameter `name` from `now` on. Wheels are named as in `wheels.0.toe_deg`.
    pub fn set_parameter(
        &mut self,
        now: Timestamp,
        name: &str,
        value: f64,
    ) -> Result<(), ParameterError> {
        self.advance(now);
        self.parameters.set(name, value)?;
        let targets = self.kinematics.targets();
        self.start_phase(now, targets, self.accelerations());
        self.apply_track_model(now);
        Ok(())
    }

    /// The current parameters.
    pub const fn parameters(&self) -> &BaseParameters {
        &self.parameters
    }

    /// The true state at `now`, not before the last call with a time.
    pub fn truth_at(&self, now: Timestamp) -> BaseTruth {
        let truth = self.kinematics.truth_at(now);
        let (drive, steer) = self.kinematics.rates_at(now);
        let [to_drive, to_steer] = self.kinematics.commanded_at(now);
        let model = self.kinematics.model_now();
        let (speed, grip) = (drive * model.path_scale, self.grip());
        let wheels = if grip > 0.0 { speed / grip } else { drive };
        BaseTruth {
            pose: truth.pose(),
            body_heading: Angle::from_rad(truth.body),
            steering_angle: Angle::from_rad(truth.steer),
            speed: Speed::from_m_per_s(speed),
            wheels: Speed::from_m_per_s(wheels),
            steer_rate: AngularRate::from_rad_per_s(steer * model.turn_scale),
            followed: (Speed::from_m_per_s(to_drive), AngularRate::from_rad_per_s(to_steer)),
        }
    }

    /// Current of the motors at `now`, ampere: the input of a magnetic sensor on the base.
    pub fn motor_current_at(&self, now: Timestamp) -> f64 {
        let (drive, steer) = self.kinematics.rates_at(now);
        let p = &self.parameters;
        let acceleration = self.kinematics.acceleration();
        let driving = drive != 0.0 || acceleration != 0.0;
        let mut ampere = p.motor_ampere_per_m_per_s2 * acceleration.abs();
        ampere += if driving { p.motor_ampere_rolling } else { 0.0 };
        ampere + if steer != 0.0 { p.motor_ampere_steering } else { 0.0 }
    }

    /// The turret's true heading at `now` (unwrapped): the input of a gyro on the base.
    #[inline]
    pub fn turret_heading_at(&self, now: Timestamp) -> Angle {
        Angle::from_rad(self.kinematics.heading_at(now))
    }

    /// The counters of the serial line's end.
    pub const fn serial_counters(&self) -> wire::base::serial_link::DeviceCounters {
        self.device.counters()
    }

    /// Number of frames that were not requests.
    pub const fn frames_ignored(&self) -> u64 {
        self.frames_ignored
    }

    /// Outputs lost because more than [`OUTPUTS_MAX`] were waiting.
    pub const fn outputs_dropped(&self) -> u64 {
        self.reports.dropped()
    }

    fn report(&mut self, now: Timestamp) {
        if self.reports.motion_due(now) {
            let motion = self.reported_motion(now);
            self.reports.send_motion(now, motion);
        }
        if self.reports.pose_due(now) {
            let pose = self.reported_pose(now);
            self.reports.send_pose(now, pose);
        }
    }

    fn reported_motion(&mut self, now: Timestamp) -> Motion {
        let (displacement, steered) = self.kinematics.odometers_at(now);
        self.status.displacement = Length::from_m(displacement);
        self.status.heading = Angle::from_rad(self.stepped(steered)).wrapped();
        self.status.moving = self.kinematics.is_moving();
        let motion = self.status;
        self.status.sequence = motion.sequence.wrapping_add(1);
        let said = if self.faults.is_empty() { motion } else { self.motion_through_faults(motion) };
        if self.said.len() == SAID_MAX {
            self.said.pop_front();
        }
        self.said.push_back(said);
        said
    }

    /// True if it sent this not long ago: a message that says something else was changed on its way.
    pub fn has_said(&self, motion: &Motion) -> bool {
        let is_it = |said: &&Motion| {
            let reply = Reply::Motion(Motion { sequence: motion.sequence, ..**said });
            can_link::parse_reply(&can_link::reply_frame(&reply)) == Some(Reply::Motion(*motion))
        };
        self.said.iter().rev().any(|said| is_it(&said))
    }

    /// The pose by the base's own odometry at `now`, as transmitted; not before the last call with a time. Faults of
    /// its reports are not included.
    pub fn odometry_at(&self, now: Timestamp) -> Pose {
        let pose = self.reckoned_pose(now);
        match can_link::parse_reply(&can_link::reply_frame(&Reply::Pose(pose))) {
            Some(Reply::Pose(read)) => read,
            _ => pose,
        }
    }

    fn reported_pose(&mut self, now: Timestamp) -> Pose {
        let pose = self.reckoned_pose(now);
        if self.faults.is_empty() { pose } else { self.pose_through_faults(pose) }
    }

    fn reckoned_pose(&self, now: Timestamp) -> Pose {
        let State { reckoned, steered, .. } = self.kinematics.state_at(now);
        // The written heading keeps its resolution; only the rotation since then has steps.
        let since_write = steered - self.steered_at_write;
        let heading = reckoned.heading() - since_write + self.stepped(since_write);
        Pose { heading: Angle::from_rad(heading).wrapped(), ..reckoned.pose() }
    }

    fn stepped(&self, angle: f64) -> f64 {
        let step = Angle::from_deg(self.parameters.heading_step_deg).rad();
        if step > 0.0 { libm::round(angle / step) * step } else { angle }
    }
}
