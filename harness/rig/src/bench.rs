//! The emulated devices of a run, with the facts about them that the controller and the engine need.

use controller::config::{BaseConfig, Config, GyroConfig, MotionConfig, Transport};
use emulators::absolute::AbsoluteMeasurement;
use emulators::base::BaseEmulator;
use emulators::device_file::{Devices, Mount};
use emulators::gyro::GyroEmulator;
use emulators::table::TableEmulator;
use plan::faults::{LineKind, Ride};
use plan::rig::ride;
use record::RecordKind;
use wire::device::Transmit;
use wire::gyro::GyroStream;
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate, Pose};

#[derive(Debug, Clone)]
pub enum Carrier {
    /// The turret of the robot.
    Base(Box<BaseEmulator>),
    Table(Box<TableEmulator>),
    /// Nothing but a rate that the caller sets.
    Turning(Turning),
}

/// Carrier of a gyro that rides on neither base nor table.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turning {
    since: Timestamp,
    from: Angle,
    rate: AngularRate,
}

impl Turning {
    /// Turns at this rate from `now` on.
    pub fn turn(&mut self, now: Timestamp, rate: AngularRate) {
        *self = Self { since: now, from: self.angle_at(now), rate };
    }

    fn angle_at(&self, at: Timestamp) -> Angle {
        self.from + Angle::from_rad(self.rate.rad_per_s() * (at - self.since).as_secs_f64())
    }
}

#[derive(Debug, Clone)]
pub struct Bench {
    pub gyro: GyroEmulator,
    pub carrier: Carrier,
    absolute: AbsoluteMeasurement,
    devices: Devices,
    #[cfg(feature = "mutants")]
    mutant: Option<controller::Mutant>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BenchFacts {
    /// Standard uncertainty of a position by the absolute measurement, m.
    pub absolute_position_u_m: f64,
    /// Standard uncertainty of a heading by the absolute measurement, deg.
    pub absolute_heading_u_deg: f64,
    /// Standard uncertainty of the table's angle at rest, deg.
    pub table_u_deg: f64,
    /// Angle by which one motor step turns the table.
    pub table_step: Angle,
}

/// An external view of the base at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// True pose of the base; its heading is not wrapped.
    pub truth: Pose,
    /// Pose by the base's own odometry, decoded as a host would.
    pub odometry: Pose,
}

/// How the base is connected; `None` on a table.
pub fn base_transport(devices: &Devices) -> Option<Transport> {
    match ride(devices) {
        Ride::Base(LineKind::Can) => Some(Transport::Can),
        Ride::Base(LineKind::Serial) => Some(Transport::Serial),
        Ride::Table => None,
    }
}

impl Bench {
    /// Creates the devices, each with its own random numbers from `seed`.
    pub fn new(devices: Devices, seed: u64) -> Self {
        let (stream, parameters) = devices.gyro.clone();
        let carrier = match (devices.mount, &devices.base, &devices.table) {
            (Mount::Base, Some((transport, parameters)), _) => Carrier::Base(Box::new(
                BaseEmulator::new(parameters.clone(), *transport, seed, "base"),
            )),
            (_, _, table) => {
                let parameters = table.clone().unwrap_or_default();
                Carrier::Table(Box::new(TableEmulator::new(parameters)))
            }
        };
        Self {
            gyro: GyroEmulator::new(parameters, stream, seed, "gyro"),
            carrier,
            absolute: AbsoluteMeasurement::new(devices.absolute.clone(), seed, "absolute"),
            devices,
            #[cfg(feature = "mutants")]
            mutant: None,
        }
    }

    /// Gives the controller on this bench a deliberate mistake.
    #[cfg(feature = "mutants")]
    pub fn with_mutant(self, mutant: Option<controller::Mutant>) -> Self {
        Self { mutant, ..self }
    }

    pub const fn gyro_stream(&self) -> GyroStream {
        self.devices.gyro.0
    }

    /// How the base is connected; `None` on a table.
    pub fn base_transport(&self) -> Option<Transport> {
        base_transport(&self.devices)
    }

    pub fn controller_config(&self) -> Config {
        let gyro = GyroConfig::new(self.gyro_stream());
        let base = self.base_transport().map(BaseConfig::new);
        let config = Config::new(gyro, base, MotionConfig::default());
        #[cfg(feature = "mutants")]
        let config = Config { mutant: self.mutant, ..config };
        config
    }

    pub fn facts(&self) -> BenchFacts {
        let table = self.devices.table.clone().unwrap_or_default();
        BenchFacts {
            absolute_position_u_m: self.absolute.position_uncertainty().m(),
            absolute_heading_u_deg: self.absolute.heading_uncertainty().deg(),
            // Half a step either way, uniform.
            table_u_deg: table.step_deg / 12f64.sqrt(),
            table_step: Angle::from_deg(table.step_deg),
        }
    }

    /// Measures the pose of the base; `None` on a table.
    pub fn measure_absolute(&mut self, now: Timestamp) -> Option<Pose> {
        match &mut self.carrier {
            Carrier::Base(base) => {
                base.wake(now);
                Some(self.absolute.measure(base.truth_at(now).pose))
            }
            Carrier::Table(_) | Carrier::Turning(_) => None,
        }
    }

    /// True pose of the base and its odometry; `None` on a table.
    pub fn look(&self, now: Timestamp) -> Option<Look> {
        let base = self.base()?;
        Some(Look { truth: base.truth_at(now).pose, odometry: base.odometry_at(now) })
    }

    /// True pose of the base; `None` on a table.
    pub fn true_pose(&self, now: Timestamp) -> Option<Pose> {
        Some(self.base()?.truth_at(now).pose)
    }

    fn base(&self) -> Option<&BaseEmulator> {
        match &self.carrier {
            Carrier::Base(base) => Some(base),
            Carrier::Table(_) | Carrier::Turning(_) => None,
        }
    }

    /// Carries the robot to a pose. The gyro does not sense the move: the pose that the controller receives sets its
    /// heading anew.
    ///
    /// # Errors
    /// When there is no robot, or when it is moving.
    pub fn place(&mut self, now: Timestamp, pose: Pose) -> Result<(), &'static str> {
        self.carrier.place(now, pose)?;
        self.gyro.carrier_placed(self.carrier.heading_at(now));
        Ok(())
    }

    /// Sets a parameter of a device.
    ///
    /// # Errors
    /// When there is no such device or parameter, or when the value is out of its domain.
    pub fn set_parameter(
        &mut self,
        now: Timestamp,
        device: &str,
        parameter: &str,
        value: f64,
    ) -> Result<(), String> {
        let result = match (device, &mut self.carrier) {
            ("gyro", _) => self.gyro.set_parameter(parameter, value),
            ("absolute", _) => self.absolute.set_parameter(parameter, value),
            ("base", Carrier::Base(base)) => base.set_parameter(now, parameter, value),
            ("table", Carrier::Table(table)) => table.set_parameter(now, parameter, value),
            _ => return Err(format!("this bench has no device \"{device}\"")),
        };
        result.map_err(|error| format!("failed to set {device}.{parameter}: {error}"))
    }

    pub fn truth(&mut self, now: Timestamp) -> RecordKind {
        let gyro = self.gyro.truth();
        let pose = match &mut self.carrier {
            Carrier::Base(base) => {
                base.wake(now);
                base.truth_at(now).pose
            }
            carrier => Pose { heading: carrier.heading_at(now), ..Pose::default() },
        };
        RecordKind::Truth {
            pose,
            bias_rad_per_s: gyro.bias.rad_per_s(),
            coil_celsius: gyro.coil_temperature.celsius(),
        }
    }
}

impl Carrier {
    pub fn next_wakeup(&self) -> Timestamp {
        match self {
            Self::Base(base) => base.next_wakeup(),
            Self::Table(table) => table.next_wakeup(),
            Self::Turning(_) => None,
        }
        .unwrap_or(Timestamp::MAX)
    }

    pub fn wake(&mut self, now: Timestamp) {
        match self {
            Self::Base(base) => base.wake(now),
            Self::Table(table) => table.wake(now),
            Self::Turning(_) => {}
        }
    }

    /// True heading of the carrier, not wrapped.
    pub fn heading_at(&self, now: Timestamp) -> Angle {
        match self {
            Self::Base(base) => base.turret_heading_at(now),
            Self::Table(table) => table.angle_at(now),
            Self::Turning(turning) => turning.angle_at(now),
        }
    }

    /// Current of the motors that move with the gyro. The table's motor stays apart, behind its gear.
    pub(crate) fn motor_current_at(&self, now: Timestamp) -> f64 {
        match self {
            Self::Base(base) => base.motor_current_at(now),
            Self::Table(_) | Self::Turning(_) => 0.0,
        }
    }

    pub fn transmit(&mut self) -> Option<Transmit> {
        match self {
            Self::Base(base) => base.transmit(),
            Self::Table(table) => table.transmit().map(Transmit::Bytes),
            Self::Turning(_) => None,
        }
    }

    /// Carries the robot to a pose; [`Bench::place`] also moves the gyro.
    fn place(&mut self, now: Timestamp, pose: Pose) -> Result<(), &'static str> {
        match self {
            Self::Base(base) => {
                if base.place(now, pose) {
                    Ok(())
                } else {
                    Err("the robot moves and cannot be carried")
                }
            }
            Self::Table(_) | Self::Turning(_) => {
                Err("this bench has no robot that could be carried")
            }
        }
    }
}
