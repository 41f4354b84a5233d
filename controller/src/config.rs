//! Configuration of a controller for its robot. Every default cites its source.

use crate::mutant::Planted;
use serde::{Deserialize, Serialize};
use wire::base::Request;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};
use wire::time::Span;
use wire::units::{
    Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed, Temperature,
};

/// With the Kalman filter, the base goes on for this long on the odometry alone, and then stands until the gyro is back:
/// the odometry errs by distance, not by time. Assumption: pauses of a busy line are shorter.
pub(crate) const HOLD_AFTER: Span = Span::from_millis(300);
/// Longest silence of the gyro that the odometry may bridge. Assumption: a plug is back in by then.
pub(crate) const BRIDGE_MAX: Span = Span::from_secs(10);
/// Longest silence that the neighbours bridge better than the odometry: with the ramp of turns of 15 deg/s^2, a line
/// between two readings 0.25 s apart errs by at most 15/8 T^2 = 0.12 deg; two readings of the odometry, in steps of
/// 0.3 deg, err by as much rms.
pub(crate) const INTERPOLATED_MAX: Span = Span::from_millis(250);

/// The whole configuration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Config {
    /// The gyro.
    pub gyro: GyroConfig,
    /// The base; `None` on a rotary table.
    pub base: Option<BaseConfig>,
    /// The control loops.
    pub motion: MotionConfig,
    /// A deliberately planted mistake.
    #[cfg(feature = "mutants")]
    #[serde(skip)]
    pub mutant: Option<crate::Mutant>,
}

impl Config {
    /// A configuration without a planted mistake.
    pub const fn new(gyro: GyroConfig, base: Option<BaseConfig>, motion: MotionConfig) -> Self {
        Self {
            gyro,
            base,
            motion,
            #[cfg(feature = "mutants")]
            mutant: None,
        }
    }

    pub(crate) const fn planted(&self) -> Planted {
        #[cfg(feature = "mutants")]
        return Planted::new(self.mutant);
        #[cfg(not(feature = "mutants"))]
        Planted {}
    }
}

/// The clock that turns rates into angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntegrationClock {
    /// A sample lasts the nominal period: exact as long as the gyro's clock is.
    #[default]
    Samples,
    /// A sample lasts from the previous arrival to its own: exact if no sample is delayed.
    HostTime,
}

/// The gyro and the use of its samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GyroConfig {
    /// Format, mode, mounting.
    pub stream: GyroStream,
    /// The clock that turns rates into angles.
    pub clock: IntegrationClock,
    /// Silence beyond this is a fault. Assumption: ten periods of a 100 Hz stream.
    pub timeout: Span,
    /// Invalid data beyond this is a fault. Assumption: as long as silence may last.
    pub invalid_max: Span,
    /// Largest deviation from one of the ratio of gyro clock to host clock. Assumption: above the 0.2 % that
    /// temperature adds to a DSP-3000's clock, below the 3 % between units.
    pub clock_mismatch_max: f64,
    /// Largest standard deviation of the readings at rest. Assumption: three times the 0.014 deg/s
    /// that 5 deg/h/sqrt(Hz) (E-Core 2000) gives at 100 Hz, and one step of quantisation.
    pub rest_spread_max: AngularRate,
    /// Largest difference between the means of the two halves of a bias test. Assumption: four times
    /// the data sheet's drift of 0.005 deg/s.
    pub rest_drift_max: AngularRate,
    /// Largest credible bias. Assumption: 1,800 deg/h, a hundred times the data sheet's drift.
    pub bias_max: AngularRate,
}

/// Transport of the commands to the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transport {
    /// CAN frames as in `k2a.dbc`.
    Can,
    /// The Cybermotion-style ASCII-hex exchange.
    Serial,
}

/// The base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseConfig {
    /// Transport of its commands.
    pub transport: Transport,
    /// Silence beyond this while moving is a fault. Assumption: nine periods of the control loop.
    pub timeout_moving: Span,
    /// Silence beyond this at rest is a fault. Assumption: three polls.
    pub timeout_at_rest: Span,
    /// Time between two polls at rest, serial only. Assumption.
    pub poll_at_rest: Span,
    /// A serial exchange that takes longer is abandoned. Assumption: twice the longest exchange at
    /// 19200 baud.
    pub exchange_timeout: Span,
    /// Top speed: 0.78 m/s (Cybermotion K2A).
    pub speed_max: Speed,
    /// Top steering rate: 120 deg/s (Cybermotion K2A).
    pub steer_rate_max: AngularRate,
}

/// The control loops of the paper's sections 4.2.1 and 4.2.2. The paper names the loops, not their
/// gains: the gains are assumptions, chosen for a loop delay of two periods.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MotionConfig {
    /// Period of the loops: 27 ms, as in the K2A's original host program.
    pub period: Span,
    /// Delay from a measurement to its effect on the base, as allowed for in the braking curve. Assumption: two
    /// periods plus the delay of the line.
    pub loop_delay: Span,
    /// Ramp of prescribed speed: 0.4 m/s^2. Together with the ramp of the rate it gives the paper's 64 s lap.
    pub acceleration: Acceleration,
    /// Ramp of prescribed rate: 15 deg/s^2, likewise.
    pub angular_acceleration: AngularAcceleration,
    /// Position loop: speed per remaining metre, 1/s.
    pub position_gain: f64,
    /// Position loop: slowest speed before arrival.
    pub creep_speed: Speed,
    /// Position loop: tolerance for arrival. Half of the paper's +-2 mm.
    pub position_tolerance: Length,
    /// Orientation loop: rate per remaining radian, 1/s.
    pub orientation_gain: f64,
    /// Orientation loop: slowest rate before arrival.
    pub creep_rate: AngularRate,
    /// Orientation loop: tolerance for arrival. Half of the paper's +-0.1 deg.
    pub orientation_tolerance: Angle,
    /// Steering correction: rate per radian of heading error, 1/s.
    pub steering_gain: f64,
    /// Steering correction: largest rate.
    pub steering_rate_max: AngularRate,
    /// The base counts as at rest after this time without motion.
    pub settle: Span,
    /// Attempts at a pose download.
    pub pose_writes_max: u8,
    /// Time between two attempts, which also limits the wait for an answer.
    pub pose_write_retry: Span,
    /// The base's own acceleration limits, as a multiple of the prescribed ramps, so that the base can follow them.
    pub base_acceleration_margin: f64,
}

impl GyroConfig {
    /// The defaults for a gyro stream.
    pub const fn new(stream: GyroStream) -> Self {
        Self {
            stream,
            clock: IntegrationClock::Samples,
            timeout: Span::from_millis(100),
            invalid_max: Span::from_millis(100),
            clock_mismatch_max: 0.005,
            rest_spread_max: AngularRate::from_deg_per_s(0.05),
            rest_drift_max: AngularRate::from_deg_per_s(0.02),
            bias_max: AngularRate::from_deg_per_s(0.5),
        }
    }
}

impl Default for GyroConfig {
    fn default() -> Self {
        Self::new(GyroStream {
            format: GyroFormat::Navigator,
            mode: OutputMode::Rate,
            reversed: false,
        })
    }
}

impl BaseConfig {
    /// The defaults for a transport.
    pub const fn new(transport: Transport) -> Self {
        Self {
            transport,
            timeout_moving: Span::from_millis(250),
            timeout_at_rest: Span::from_millis(1_600),
            poll_at_rest: Span::from_millis(500),
            exchange_timeout: Span::from_millis(60),
            speed_max: Speed::from_m_per_s(0.78),
            steer_rate_max: AngularRate::from_deg_per_s(120.0),
        }
    }
}

impl MotionConfig {
    /// The base's own ramp, which it brakes by.
    pub(crate) fn base_acceleration(&self) -> Acceleration {
        self.acceleration * self.base_acceleration_margin
    }

    /// The ramps for the base.
    pub(crate) fn ramps(&self) -> Request {
        Request::SetAcceleration {
            drive: self.base_acceleration(),
            steer: self.angular_acceleration * self.base_acceleration_margin,
        }
    }
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self {
            period: Span::from_millis(27),
            loop_delay: Span::from_millis(80),
            acceleration: Acceleration::from_m_per_s2(0.4),
            angular_acceleration: AngularAcceleration::from_deg_per_s2(15.0),
            position_gain: 4.0,
            creep_speed: Speed::from_m_per_s(0.005),
            position_tolerance: Length::from_m(0.001),
            orientation_gain: 4.0,
            creep_rate: AngularRate::from_deg_per_s(0.3),
            orientation_tolerance: Angle::from_deg(0.05),
            steering_gain: 1.5,
            steering_rate_max: AngularRate::from_deg_per_s(10.0),
            settle: Span::from_millis(300),
            pose_writes_max: 5,
            pose_write_retry: Span::from_millis(700),
            base_acceleration_margin: 1.5,
        }
    }
}

/// Range of credible sensor temperatures.
pub(crate) const TEMPERATURE_MIN: Temperature = Temperature::from_celsius(-60.0);
/// See [`TEMPERATURE_MIN`].
pub(crate) const TEMPERATURE_MAX: Temperature = Temperature::from_celsius(125.0);
