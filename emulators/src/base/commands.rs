//! Execution of commands by a base, and their time-out.

use super::BaseEmulator;
use super::curvature::Harmonic;
use super::kinematics::Following;
use super::servo::{NOISE_HELD, Servo};
use super::track::{Slip, Track, TrackModel};
use crate::random::RandomStream;
use wire::base::PoseWriteResult;
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Pose, Speed};

const SECONDS_PER_HOUR: f64 = 3_600.0;

impl BaseEmulator {
    /// Advances to `now` and carries out a delayed stop on the way.
    pub(super) fn advance(&mut self, now: Timestamp) {
        if let Some((at, request)) = self.late_stop.take_if(|(at, _)| *at <= now) {
            self.drive_on(at);
            self.carry_out(at, request);
        }
        self.drive_on(now);
    }

    fn drive_on(&mut self, now: Timestamp) {
        while self.next_change() <= now {
            let at = self.next_change();
            let mut targets = self.kinematics.targets();
            if self.noise_due <= at {
                self.draw_noise(at);
            }
            if self.deadline == Some(at) {
                self.deadline = None;
                self.status.command_timed_out = true;
                targets = (0.0, 0.0);
            }
            self.ramp_to(at, targets, self.accelerations());
        }
        self.kinematics.advance(now);
    }

    /// Time of the next ramp end, command time-out or noise draw; [`Timestamp::MAX`] for never.
    pub(super) fn next_change(&self) -> Timestamp {
        let noise_due = if self.kinematics.is_moving() { self.noise_due } else { Timestamp::MAX };
        let deadline = self.deadline.unwrap_or(Timestamp::MAX);
        self.kinematics.phase_end().min(deadline).min(noise_due)
    }

    /// Draws the noise of both rates at `now`, for the next while.
    fn draw_noise(&mut self, now: Timestamp) {
        let p = &self.parameters;
        if p.drive_noise_m_per_s == 0.0 && p.steering_noise_deg_per_s == 0.0 {
            self.noise_due = Timestamp::MAX;
            return;
        }
        self.noise_due = now + NOISE_HELD;
        self.drive_noise.draw();
        self.steering_noise.draw();
        // Starts a phase here, with the current commands.
        self.start_phase(now, self.kinematics.targets(), self.accelerations());
        self.apply_track_model(now);
    }

    pub(super) fn set_velocity(&mut self, now: Timestamp, drive: Speed, steer: AngularRate) {
        self.status.command_timed_out = false;
        if self.status.emergency_stop || self.status.fault {
            return;
        }
        let speed_max = Speed::from_m_per_s(self.parameters.speed_max_m_per_s);
        let rate_max = AngularRate::from_deg_per_s(self.parameters.steer_rate_max_deg_per_s);
        // A command that is not a number must not move the base.
        let targets = if drive.is_finite() && steer.is_finite() {
            (drive.limited(speed_max).m_per_s(), steer.limited(rate_max).rad_per_s())
        } else {
            (0.0, 0.0)
        };
        let timeout = Span::from_secs_f64(self.parameters.command_timeout_s);
        let deadline = now + timeout;
        self.deadline = (targets != (0.0, 0.0) && deadline < Timestamp::MAX).then_some(deadline);
        if targets == self.kinematics.targets() {
            return;
        }
        if !self.kinematics.is_moving() {
            self.turn_scale.draw();
            self.leakage.draw();
            self.apply_track_model(now);
            self.draw_noise(now);
        }
        self.ramp_to(now, targets, self.accelerations());
    }

    pub(super) fn set_acceleration(
        &mut self,
        now: Timestamp,
        drive: Acceleration,
        steer: AngularAcceleration,
    ) {
        let (drive, steer) = (drive.m_per_s2(), steer.rad_per_s2());
        // The codec refuses other values; with them the base could never stop.
        if drive > 0.0 && steer > 0.0 {
            self.limits = (drive, steer);
            self.ramp_to(now, self.kinematics.targets(), self.accelerations());
        }
    }

    pub(super) fn write_pose(&mut self, now: Timestamp, pose: Pose, counter: u8) {
        self.status.pose_write_counter = counter;
        self.status.pose_write = if self.kinematics.is_moving() {
            PoseWriteResult::RefusedInMotion
        } else if !pose.is_finite() {
            PoseWriteResult::RefusedValue
        } else {
            let mut state = self.kinematics.state_at(now);
            state.reckoned = Track {
                x: pose.x.m(),
                y: pose.y.m(),
                body: pose.heading.rad() - state.reckoned.steer,
                steer: state.reckoned.steer,
            };
            self.steered_at_write = state.steered;
            self.kinematics.set_state(state);
            PoseWriteResult::Accepted
        };
        self.reports.motion_is_due(now);
    }

    /// Stops as hard as the hardware can while an emergency stop or a fault is active.
    pub(super) fn inhibit(&mut self, now: Timestamp) {
        if self.status.emergency_stop || self.status.fault {
            self.deadline = None;
            self.ramp_to(now, (0.0, 0.0), self.accelerations_max());
        }
        self.reports.motion_is_due(now);
        self.report(now);
    }

    pub(super) fn ramp_to(&mut self, now: Timestamp, targets: (f64, f64), limits: (f64, f64)) {
        let was_moving = self.kinematics.is_moving();
        self.start_phase(now, targets, limits);
        if was_moving != self.kinematics.is_moving() {
            self.reports.motion_is_due(now);
        }
    }

    pub(super) fn start_phase(&mut self, now: Timestamp, targets: (f64, f64), limits: (f64, f64)) {
        self.kinematics.start_phase(now, (targets.0, limits.0), (targets.1, limits.1));
    }

    fn accelerations_max(&self) -> (f64, f64) {
        (
            self.parameters.acceleration_max_m_per_s2,
            Angle::from_deg(self.parameters.steer_acceleration_max_deg_per_s2).rad(),
        )
    }

    pub(super) fn accelerations(&self) -> (f64, f64) {
        if self.status.emergency_stop || self.status.fault {
            return self.accelerations_max();
        }
        let max = self.accelerations_max();
        (self.limits.0.min(max.0), self.limits.1.min(max.1))
    }

    /// Sets the conversion of the odometer's rates to motion, from the parameters and the last draws.
    pub(super) fn apply_track_model(&mut self, now: Timestamp) {
        let p = &self.parameters;
        let turn_scale_error = p.turn_scale_error + p.turn_scale_spread * self.turn_scale.last;
        let leakage_deg_per_m =
            p.leakage_deg_per_m + p.leakage_spread_deg_per_m * self.leakage.last;
        let hours = (now - Timestamp::ZERO).as_secs_f64() / SECONDS_PER_HOUR;
        let model = TrackModel {
            path_scale: (1.0 + p.displacement_scale_error + p.tyre_growth_per_h * hours)
                * self.grip(),
            turn_scale: 1.0 + turn_scale_error,
            wheels: Harmonic::of(&p.wheels),
            leakage_rad_per_m: Angle::from_deg(leakage_deg_per_m).rad(),
            half_turn_asymmetry: p.turn_scale_asymmetry / 2.0,
            slip: Slip {
                driving: p.slip_driving_per_m_per_s2,
                braking: p.slip_braking_per_m_per_s2,
                free: p.slip_free_m_per_s2,
            },
        };
        let rad = |deg| Angle::from_deg(deg).rad();
        let following = Following {
            drive: Servo {
                slowest: p.drive_stiction_m_per_s,
                faster: p.drive_noise_m_per_s * self.drive_noise.last,
            },
            steer: Servo {
                slowest: rad(p.steering_stiction_deg_per_s),
                faster: rad(p.steering_noise_deg_per_s) * self.steering_noise.last,
            },
            play: rad(p.steering_play_deg),
        };
        self.kinematics.set_model(model, following);
    }
}

/// A standard normal number that is redrawn on an event, such as each start from rest.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    stream: RandomStream,
    last: f64,
}

impl Spread {
    pub(super) fn new(seed: u64, device: &str, purpose: &str) -> Self {
        Self { stream: RandomStream::new(seed, device, purpose), last: 0.0 }
    }

    fn draw(&mut self) {
        self.last = self.stream.standard_normal();
    }
}
