//! The command line.

use crate::listen::ListenPlace;
use clap::Parser;
use controller::config::{
    BaseConfig, Config, GyroConfig, IntegrationClock, MotionConfig, Transport,
};
use hil::choices::{self, one_of};
use ports::PortSpec;
use ports::slcan::USUAL;
use ports::spec::{BAUD, SerialDevice, SerialOptions, SerialSpec};
use std::str::FromStr;
use wire::base::serial_link;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};
use wire::serial::SerialSettings;

const AFTER_HELP: &str = "\
Missions are read from stdin and reports written to stdout, one JSON line each:

  {\"id\":1,\"command\":{\"bias_test\":{\"duration_s\":20.0}}}
  {\"id\":2,\"command\":{\"straight\":{\"distance_m\":4.0,\"speed_m_per_s\":0.4}}}
  {\"id\":3,\"command\":{\"turn\":{\"angle_rad\":1.5708,\"rate_rad_per_s\":0.5236}}}
  {\"id\":4,\"command\":\"stop\"}

The log goes to stderr; RUST_LOG sets its level. When stdin closes, and on SIGTERM, SIGINT and SIGHUP,
the base is brought to rest before the process ends. With --listen the same lines go over a socket.

Exit status: 0 ended as asked, 1 the base was not known to be at rest at the end, 2 bad arguments,
3 a port could not be opened or did not come back, 4 the system gave no threads or timers.";

/// Controller of a synchro-drive robot with a fibre-optic gyro.
#[derive(Debug, Parser)]
#[command(name = "k2a-controller", version, after_help = AFTER_HELP)]
pub(crate) struct Arguments {
    /// Serial port of the gyro; without a baud rate, that of the stream
    #[arg(long, value_name = "PORT[:BAUD]")]
    gyro: SerialPort,
    /// Format of the gyro's stream
    #[arg(long, value_parser = choices::gyro_format(), default_value = "navigator")]
    stream: GyroFormat,
    /// What the gyro puts out; other than `rate` with the DSP-3000 only
    #[arg(long, value_parser = choices::output_mode(), default_value = "rate")]
    mode: OutputMode,
    /// The gyro counts clockwise as positive, or is mounted upside down
    #[arg(long)]
    reversed: bool,
    /// What turns rates into angles: the nominal sample period, or the time between arrivals
    #[arg(long, value_parser = one_of([
        ("samples", "Every sample lasts the nominal period", IntegrationClock::Samples),
        ("host-time", "A sample lasts from the arrival before to its own", IntegrationClock::HostTime),
    ]), default_value = "samples")]
    integrate_by: IntegrationClock,
    /// The base: `serial:PORT[:BAUD]` (19200 baud), `can:INTERFACE`, `slcan:PORT[:BAUD]` (a CAN adapter; bus
    /// at 500 kbit/s), or `none` on a rotary table
    #[arg(long, value_name = "BASE", default_value = "none")]
    base: Base,
    /// Take missions there, not from stdin, of one client after the other: `unix:PATH` or
    /// `tcp:ADDRESS:PORT`. Each begins with a controller as new; a client that leaves has the base stopped.
    /// Nobody is asked who he is: on TCP, listen on 127.0.0.1 or where you trust everybody
    #[arg(long, value_name = "PLACE")]
    listen: Option<ListenPlace>,
}

/// A serial port as given on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
struct SerialPort {
    path: String,
    baud: Option<u32>,
}

impl FromStr for SerialPort {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Paths may contain colons (/dev/serial/by-path/...): only a number is a baud rate.
        let digits =
            |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let (path, baud) = match text.rsplit_once(':') {
            Some((path, number)) if digits(number) => {
                let baud =
                    number.parse().ok().filter(|baud| BAUD.contains(baud)).ok_or_else(|| {
                        format!(
                            "{number} is no baud rate between {} and {}",
                            BAUD.start(),
                            BAUD.end()
                        )
                    })?;
                (path, Some(baud))
            }
            _ => (text, None),
        };
        if path.is_empty() {
            return Err("the port has no name".to_owned());
        }
        Ok(Self { path: path.to_owned(), baud })
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Base(Option<PortPlace>);

impl FromStr for Base {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let place = match text.split_once(':') {
            None if text == "none" => return Ok(Self(None)),
            Some(("serial", port)) => PortPlace::serial(port.parse()?, serial_link::SETTINGS),
            Some(("slcan", port)) => PortPlace::slcan(port.parse()?),
            Some(("can", "")) => return Err("the CAN interface has no name".to_owned()),
            Some(("can", interface)) => PortPlace::can(interface.to_owned()),
            _ => {
                return Err(
                    "expected serial:PORT[:BAUD], can:INTERFACE, slcan:PORT[:BAUD] or none"
                        .to_owned(),
                );
            }
        };
        Ok(Self(Some(place)))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PortPlace {
    /// Its path, or the name of the interface.
    pub(crate) name: String,
    pub(crate) spec: PortSpec,
    /// Of a serial line.
    pub(crate) settings: SerialSettings,
}

impl PortPlace {
    fn serial(port: SerialPort, usual: SerialSettings) -> Self {
        let settings = SerialSettings { baud: port.baud.unwrap_or(usual.baud), ..usual };
        Self { spec: PortSpec::Serial(port.at(None)), name: port.path, settings }
    }

    fn can(interface: String) -> Self {
        let spec = PortSpec::Can { interface: interface.clone() };
        Self { spec, name: interface, settings: USUAL }
    }

    /// A CAN adapter on a serial port.
    fn slcan(port: SerialPort) -> Self {
        let settings = SerialSettings { baud: port.baud.unwrap_or(USUAL.baud), ..USUAL };
        let serial = port.at(Some(settings.baud));
        Self { spec: PortSpec::Slcan { serial, bitrate: None }, name: port.path, settings }
    }
}

impl SerialPort {
    fn at(&self, baud: Option<u32>) -> SerialSpec {
        let options = SerialOptions { baud, ..SerialOptions::default() };
        SerialSpec { device: SerialDevice::Path(self.path.clone()), options }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Setup {
    pub(crate) config: Config,
    pub(crate) gyro: PortPlace,
    pub(crate) base: Option<PortPlace>,
    /// Source of missions, if not stdin.
    pub(crate) listen: Option<ListenPlace>,
}

impl Arguments {
    /// Returns the setup; an error is one sentence.
    pub(crate) fn setup(self) -> Result<Setup, String> {
        let (format, mode) = (self.stream, self.mode);
        if !format.carries(mode) {
            return Err("--mode: this stream carries rates only; use --mode rate".to_owned());
        }
        let Base(base) = self.base;
        let transport = base.as_ref().map(|place| match place.spec.carries_frames() {
            true => Transport::Can,
            false => Transport::Serial,
        });
        let stream = GyroStream { format, mode, reversed: self.reversed };
        let gyro = GyroConfig { clock: self.integrate_by, ..GyroConfig::new(stream) };
        let config = Config::new(gyro, transport.map(BaseConfig::new), MotionConfig::default());
        let gyro = PortPlace::serial(self.gyro, format.serial());
        Ok(Setup { config, gyro, base, listen: self.listen })
    }
}

#[cfg(test)]
mod tests {
    use super::{Arguments, Setup};
    use clap::{CommandFactory as _, Parser as _};
    use controller::config::{IntegrationClock, Transport};
    use wire::gyro::{GyroFormat, OutputMode};

    fn setup(line: &str) -> Result<Setup, String> {
        let words = ["k2a-controller"].into_iter().chain(line.split_whitespace());
        Arguments::try_parse_from(words).map_err(|cause| cause.to_string())?.setup()
    }

    #[test]
    fn the_declaration_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_port_alone_takes_the_rate_of_its_stream() {
        let setup = setup("--gyro /dev/ttyUSB0").unwrap();
        assert_eq!((setup.gyro.name.as_str(), setup.gyro.settings.baud), ("/dev/ttyUSB0", 9_600));
        assert_eq!(setup.config.gyro.stream.format, GyroFormat::Navigator);
        assert_eq!((setup.base, setup.config.base), (None, None));
    }

    #[test]
    fn everything_can_be_said() {
        let line = "--gyro /dev/serial/by-path/pci-0:1.0-port0:57600 --stream dsp3000-ascii \
                    --mode increment --reversed --integrate-by host-time --base serial:/dev/ttyS1:38400";
        let setup = setup(line).unwrap();
        assert_eq!(setup.gyro.name, "/dev/serial/by-path/pci-0:1.0-port0");
        assert_eq!(setup.gyro.settings.baud, 57_600);
        let gyro = setup.config.gyro;
        assert_eq!((gyro.stream.mode, gyro.stream.reversed), (OutputMode::Increment, true));
        assert_eq!(gyro.clock, IntegrationClock::HostTime);
        let base = setup.base.unwrap();
        assert_eq!(
            (base.spec.to_string().as_str(), base.settings.baud),
            ("serial:/dev/ttyS1", 38_400)
        );
        assert_eq!(setup.config.base.unwrap().transport, Transport::Serial);
    }

    #[test]
    fn a_colon_in_a_path_is_not_a_rate() {
        let setup = setup("--gyro /dev/serial/by-path/usb-0:1:1.0 --base can:can0").unwrap();
        assert_eq!(setup.gyro.name, "/dev/serial/by-path/usb-0:1:1.0");
        assert_eq!(setup.base.unwrap().spec.to_string(), "can:can0");
    }

    #[test]
    fn a_bus_may_be_behind_an_adapter() {
        let setup = setup("--gyro /dev/x --base slcan:/dev/ttyACM0").unwrap();
        let adapter = setup.base.unwrap();
        assert_eq!((adapter.name.as_str(), adapter.settings.baud), ("/dev/ttyACM0", 115_200));
        assert_eq!(adapter.spec.to_string(), "slcan:/dev/ttyACM0?baud=115200");
        assert_eq!(setup.config.base.unwrap().transport, Transport::Can);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (line, says) in [
            ("", "--gyro"),
            ("--gyro :9600", "no name"),
            ("--gyro /dev/x:1", "baud"),
            ("--gyro /dev/x:99999999999", "baud"),
            ("--gyro /dev/x --base usb:1", "serial:PORT"),
            ("--gyro /dev/x --base can:", "no name"),
            ("--gyro /dev/x --base serial:", "no name"),
            ("--gyro /dev/x --stream morse", "morse"),
            ("--gyro /dev/x --mode increment", "rates only"),
        ] {
            let cause = setup(line).unwrap_err();
            assert!(cause.contains(says), "{line}: {cause}");
        }
    }
}
