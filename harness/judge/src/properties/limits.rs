//! Limits for properties that do not state their own.

use controller::config::{BaseConfig, Config};
use wire::gyro::GyroStream;
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed};

/// Time from the last input received until the brakes act. Assumption: the two exchanges of 60 ms for which the
/// controller sends velocities to a base that it does not hear, and the emulated base's command time-out of 0.5 s, which
/// stops it after the last one. The time that this one is on its way is left out: on a bus that delays it, no input shows
/// by how much, and the base may stand later by that.
pub const REACTION_MAX: Span = Span::from_millis(620);
/// Longest silence of the gyro during which a base may move if the controller announces that the odometry bridges it:
/// after that the base's own errors, not yet measured (1 % of 90 deg), may turn the heading by one degree.
pub const BRIDGED_MAX: Span = Span::from_secs(5);
/// Highest acceleration, as a multiple of the prescribed ramps. Assumption: the base follows its steps with 1.5 times
/// the ramp; more than twice the ramp is undesirable.
pub const RAMPS_MAX: f64 = 2.0;
/// Highest ratio of true to commanded speed. Assumption: 1 % scale error and 1 % path error are typical of this class
/// of robot; more than 5 % is a fault.
pub const TRUE_OVER_COMMANDED_MAX: f64 = 1.05;
/// Time from the end of a fault until everything works again. Assumption: three states at rest, one per second, and the
/// two states that show counted samples.
pub const RECOVERY_MAX: Span = Span::from_secs(5);
/// Permitted heading error of a lap: +-1.2 deg (the paper's Fig. 7).
pub const HEADING_BAND: Angle = Angle::from_deg(1.2);
/// Permitted position error of a lap of 16 m: 0.1 m, the side of the square that contains all returns but one (the
/// paper's Fig. 8).
pub const POSITION_BAND: Length = Length::from_m(0.1);
/// Permitted difference of true and commanded length of a straight; same source.
pub const DISTANCE_BAND: Length = POSITION_BAND;

/// The values of bench and controller that properties need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The gyro's stream format, to decode the controller's input.
    pub gyro: GyroStream,
    /// The controller's time-out: a gyro that is silent for longer is lost.
    pub gyro_timeout: Span,
    /// Connection and capabilities of the base; `None` on a table.
    pub base: Option<BaseConfig>,
    /// See [`Always::FreshHeading`](plan::Always::FreshHeading): the controller's time-out plus, on the serial line,
    /// one exchange that the command waits for.
    pub heading_age_max: Span,
    /// See [`REACTION_MAX`].
    pub reaction_max: Span,
    /// The prescribed ramp.
    pub braking_min: Acceleration,
    /// The prescribed ramp of turns.
    pub steer_braking_min: AngularAcceleration,
    /// The base's top speed.
    pub speed_max: Speed,
    /// The base's top steering rate.
    pub steer_rate_max: AngularRate,
    /// See [`RAMPS_MAX`].
    pub acceleration_max: Acceleration,
    /// See [`RAMPS_MAX`].
    pub steer_acceleration_max: AngularAcceleration,
    /// See [`RECOVERY_MAX`].
    pub recovery_max: Span,
    /// See [`HEADING_BAND`].
    pub heading_band: Angle,
    /// See [`POSITION_BAND`].
    pub position_band: Length,
    /// See [`DISTANCE_BAND`].
    pub distance_band: Length,
}

impl Limits {
    /// The limits of a controller with this configuration.
    pub fn of(config: &Config) -> Self {
        let motion = &config.motion;
        let exchange = config.base.map_or(Span::ZERO, |base| base.exchange_timeout);
        let top = config.base.unwrap_or(BaseConfig::new(controller::config::Transport::Can));
        Self {
            gyro: config.gyro.stream,
            gyro_timeout: config.gyro.timeout,
            base: config.base,
            heading_age_max: config.gyro.timeout.max(config.gyro.invalid_max) + exchange,
            reaction_max: REACTION_MAX,
            braking_min: motion.acceleration,
            steer_braking_min: motion.angular_acceleration,
            speed_max: top.speed_max,
            steer_rate_max: top.steer_rate_max,
            acceleration_max: motion.acceleration * RAMPS_MAX,
            steer_acceleration_max: motion.angular_acceleration * RAMPS_MAX,
            recovery_max: RECOVERY_MAX,
            heading_band: HEADING_BAND,
            position_band: POSITION_BAND,
            distance_band: DISTANCE_BAND,
        }
    }
}
