//! Limits that hold where a property does not state its own.

use controller::config::{BaseConfig, Config};
use wire::gyro::GyroStream;
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed};

/// From the last thing heard until the brakes bite. Assumption: the emulated base's command time-out of
/// 0.5 s, which stops it when nothing reaches it any more, one exchange of 60 ms on the serial line, and as
/// much again for a motion message that was under way.
pub const REACTION_MAX: Span = Span::from_millis(620);
/// Fastest speeding up, as a multiple of the prescribed ramps. Assumption: the base follows its steps with
/// 1.5 times the ramp; beyond twice nobody wants it.
pub const RAMPS_MAX: f64 = 2.0;
/// True speed over commanded speed, at most. Assumption: 1 % of scale error and 1 % of path error are this
/// class of robot; more than 5 % is a fault.
pub const TRUE_OVER_COMMANDED_MAX: f64 = 1.05;
/// From the end of a fault until all works again. Assumption: three states at rest, which come every
/// second, and the two that it takes to see samples counted.
pub const RECOVERY_MAX: Span = Span::from_secs(5);
/// Heading that a lap may lose: +-1.2 deg (the paper's Fig. 7).
pub const HEADING_BAND: Angle = Angle::from_deg(1.2);
/// Path that a lap of 16 m may lose: 0.1 m, the side of the square that all returns but one lie in (the
/// paper's Fig. 8).
pub const POSITION_BAND: Length = Length::from_m(0.1);
/// True less ordered length of a straight: likewise.
pub const DISTANCE_BAND: Length = POSITION_BAND;

/// What bench and controller are, as far as properties need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The gyro's stream, to read what the controller hears.
    pub gyro: GyroStream,
    /// A gyro that is silent longer is lost: the controller's own time-out.
    pub gyro_timeout: Span,
    /// How the base is joined and what it can do; none on a table.
    pub base: Option<BaseConfig>,
    /// See [`Always::FreshHeading`](plan::Always::FreshHeading): the controller's time-out and, on
    /// the serial line, one exchange that the command waits for.
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
    /// Those of a controller that is configured like this.
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
