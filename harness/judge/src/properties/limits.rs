//! Limits for properties that do not state their own.

use controller::config::{BaseConfig, Config, Transport};
use wire::base::Request;
use wire::base::serial_link::{Host, SETTINGS};
use wire::gyro::GyroStream;
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed};

/// Time from the last input received until the brakes act. Assumption: the two exchanges of 60 ms for which the
/// controller sends velocities to a base that it does not hear, and the emulated base's command time-out of 0.5 s, which
/// stops it after the last one. That one takes its time on a serial line, which comes on top. What a bus delays it by is left
/// out: no input shows by how much, and the base may stand later by that.
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
    /// See [`REACTION_MAX`]; on a serial line, with the time of an order.
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
        let top = config.base.unwrap_or(BaseConfig::new(Transport::Can));
        Self {
            gyro: config.gyro.stream,
            gyro_timeout: config.gyro.timeout,
            base: config.base,
            heading_age_max: config.gyro.timeout.max(config.gyro.invalid_max) + exchange,
            reaction_max: REACTION_MAX + order_time(top.transport),
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

/// Time that a velocity takes on the line to the base: 20 characters of a serial line. Half a millisecond on CAN is left out.
fn order_time(transport: Transport) -> Span {
    let (drive, steer) = Default::default();
    let order = match transport {
        Transport::Serial => Host::default().start(&Request::SetVelocity { drive, steer }),
        Transport::Can => None,
    };
    SETTINGS.time_for(order.map_or(0, |order| order.len()))
}

#[cfg(test)]
mod tests {
    use super::{BaseConfig, Config, Limits, Span, Transport};
    use controller::config::{GyroConfig, MotionConfig};

    #[test]
    fn an_order_takes_its_time_on_a_serial_line() {
        let reaction = |transport| {
            let base = Some(BaseConfig::new(transport));
            let config = Config::new(GyroConfig::default(), base, MotionConfig::default());
            Limits::of(&config).reaction_max
        };
        assert_eq!(reaction(Transport::Can), Span::from_millis(620));
        // 20 characters of 10 bits at 19200 baud.
        let more = reaction(Transport::Serial) - reaction(Transport::Can);
        assert!((more.as_secs_f64() - 200.0 / 19_200.0).abs() < 1e-6, "{more:?}");
    }
}
