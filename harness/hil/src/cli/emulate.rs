//! `hil emulate`: emulated devices on ports, in real time, for anybody's controller.

use super::failure::Failure;
use clap::{Args, Subcommand, ValueEnum};
use record::outcome::Outcome;
use std::path::PathBuf;

const PORTS: &str = "\
Ports:
  pty  pty:LINK                  a pty that is made here; LINK leads to its other side
  /dev/ttyUSB0  serial:usb:0403:6001
                                 a serial port, at the other end of which the controller is
  can:vcan0                      a CAN interface (base)
  slcan-pty  slcan-pty:LINK      a CAN adapter that is played here, on a pty (base)
  slcan:/dev/ttyACM0             a CAN adapter that is used from here (base)

The standard input takes requests, a JSON line each, answered on the standard output:
  {\"id\":1,\"set\":{\"bias_deg_per_h\":30}}   {\"get\":\"truth\"}   {\"fault\":\"silent\",\"for_s\":2}   {\"list\":true}
docs/emulators.md has all of them.

Exit status:
  0  ended by Ctrl-C or a request to terminate
  2  bad input: arguments or a device file
  3  a port cannot be opened, or was lost for good";

/// Emulates devices on ports, in real time, for anybody's controller.
///
/// Prints a JSON line for each port when all are open, then runs until Ctrl-C or a request to terminate,
/// and ends with a line of counters. A device that no device file describes is an ideal one.
#[derive(Debug, Args)]
#[command(after_help = PORTS)]
pub(super) struct EmulateArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// A gyro alone; the request rate_deg_per_s turns it.
    Gyro {
        /// Stream format; without it that of the device file, else navigator.
        #[arg(long, value_enum)]
        stream: Option<Stream>,
        /// Output mode; without it that of the device file, else rate.
        #[arg(long, value_enum)]
        mode: Option<Mode>,
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// A mobile base, on CAN or a serial line.
    Base {
        /// CAN interface, the same as --port can:INTERFACE.
        #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["pty", "port"])]
        can: Option<String>,
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// A rotary table.
    Table {
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// A device of your own, by its description (`hil new` makes one).
    Device {
        /// The description: a path.
        #[arg(value_name = "DESCRIPTION")]
        description: String,
        /// CAN interface, the same as --port can:INTERFACE.
        #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["pty", "port"])]
        can: Option<String>,
        #[command(flatten)]
        port: PortArguments,
        /// Take requests on a socket, too.
        #[arg(long, value_name = "unix:PATH", value_parser = socket)]
        control: Option<PathBuf>,
        /// Seed of all random numbers.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// A whole bench, whose gyro feels the motion of what carries it by the device file.
    #[command(group(clap::ArgGroup::new("ports").required(true).multiple(true)))]
    Bench {
        /// Port of the gyro.
        #[arg(long, value_name = "PORT", group = "ports")]
        gyro: Option<String>,
        /// Port of the base.
        #[arg(long, value_name = "PORT", group = "ports")]
        base: Option<String>,
        /// Port of the table.
        #[arg(long, value_name = "PORT", group = "ports")]
        table: Option<String>,
        #[command(flatten)]
        common: CommonArguments,
    },
}

#[derive(Debug, Args)]
struct PortArguments {
    /// A pty, with a link to its other side where one is named; the usual.
    #[arg(long, value_name = "LINK", num_args = 0..=1, conflicts_with = "port")]
    pty: Option<Option<String>>,
    /// Any port, as `hil emulate --help` lists them.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
}

#[derive(Debug, Args)]
struct CommonArguments {
    /// Device file that describes the devices: a name (see `hil list devices`) or a path.
    #[arg(long, value_name = "FILE")]
    devices: Option<String>,
    /// Take requests on a socket, too.
    #[arg(long, value_name = "unix:PATH", value_parser = socket)]
    control: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Stream {
    Navigator,
    Ecore2000,
    Dsp3000Ascii,
    Dsp3000Binary,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Mode {
    Rate,
    Increment,
    Integrated,
}

fn socket(text: &str) -> Result<PathBuf, String> {
    match text.strip_prefix("unix:") {
        Some(path) if !path.is_empty() => Ok(path.into()),
        _ => Err("expected unix:PATH".to_owned()),
    }
}

impl EmulateArguments {
    pub(super) fn execute(&self, screen: &super::Screen) -> Result<Outcome, Failure> {
        use std::io::Write as _;
        let mut out = std::io::stdout();
        let mut say = |line: &str| writeln!(out, "{line}").and_then(|()| out.flush());
        let mut warn = |what: &str| screen.note(what);
        match self.what()? {
            setup::Emulated::Bench(setup) => harness::emulation::run(&setup, &mut say, &mut warn)?,
            setup::Emulated::Device(setup) => {
                harness::emulation::run_device(&setup, &mut say, &mut warn)?
            }
        }
        Ok(Outcome::Passed)
    }
}

mod setup {
    use super::{CommonArguments, EmulateArguments, Mode, PortArguments, Stream, What};
    use crate::cli::failure::Failure;
    use described::{Description, Medium};
    use emulators::base::{BaseParameters, Transport};
    use emulators::device_file::Devices;
    use emulators::gyro::GyroParameters;
    use harness::emulation::{DeviceSetup, Parts, Role, Setup};
    use harness::run::{PrepareError, load_description};
    use harness::world::bench::load_devices;
    use plan::library::Library;
    use ports::PortSpec;
    use std::collections::BTreeMap;
    use std::sync::Arc;
    use wire::gyro::{GyroFormat, GyroStream, OutputMode};

    /// What is to be emulated.
    pub(super) enum Emulated {
        Bench(Box<Setup>),
        Device(DeviceSetup),
    }

    impl EmulateArguments {
        pub(super) fn what(&self) -> Result<Emulated, Failure> {
            let setup = match &self.what {
                What::Device { description, can, port, control, seed } => {
                    let (description, port) = device(description, can.as_deref(), port)?;
                    let (control, seed) = (control.clone(), *seed);
                    let setup = DeviceSetup { description, port, control, seed };
                    return Ok(Emulated::Device(setup));
                }
                What::Gyro { stream, mode, port, common } => {
                    let described = devices(common)?.map(|devices| devices.gyro);
                    let parts =
                        Parts { gyro: Some(gyro(described, *stream, *mode)?), ..Parts::default() };
                    common.with(parts, [(Role::Gyro, port.spec()?)].into())
                }
                What::Base { can, port, common } => {
                    let spec = match can {
                        Some(interface) => parse(&format!("can:{interface}"))?,
                        None => port.spec()?,
                    };
                    let described = match devices(common)? {
                        Some(devices) => section(devices.base, Role::Base)?.1,
                        None => BaseParameters::default(),
                    };
                    let base = Some((transport(&spec), described));
                    let parts = Parts { base, ..Parts::default() };
                    common.with(parts, [(Role::Base, spec)].into())
                }
                What::Table { port, common } => {
                    let table = match devices(common)? {
                        Some(devices) => section(devices.table, Role::Table)?,
                        None => Default::default(),
                    };
                    let parts = Parts { table: Some(table), ..Parts::default() };
                    common.with(parts, [(Role::Table, port.spec()?)].into())
                }
                What::Bench { gyro, base, table, common } => {
                    bench([(Role::Gyro, gyro), (Role::Base, base), (Role::Table, table)], common)
                }
            };
            Ok(Emulated::Bench(Box::new(setup?)))
        }
    }

    /// The device of that description, and where it is.
    fn device(
        description: &str,
        can: Option<&str>,
        port: &PortArguments,
    ) -> Result<(Arc<Description>, PortSpec), Failure> {
        let library = Library::beside(description);
        let description = load_description(&library, description).map_err(PrepareError::from)?;
        let medium = description.layout().medium();
        let port = match (can, medium) {
            (Some(interface), _) => parse(&format!("can:{interface}"))?,
            // Frames do not cross a pty as they are: an adapter is played there.
            (None, Medium::Can) if port.port.is_none() => {
                PortSpec::SlcanPty { link: port.pty.clone().flatten().map(Into::into) }
            }
            (None, _) => port.spec()?,
        };
        if port.carries_frames() != (medium == Medium::Can) {
            let name = &description.name;
            return Err(Failure::arguments(
                format!("failed to put {name} on {port}: its layout is of another medium"),
                "messages of a DBC need a CAN port: can:INTERFACE, slcan-pty; bytes a serial one: pty, /dev/ttyUSB0",
            ));
        }
        Ok((Arc::new(description), port))
    }

    fn bench(
        named: [(Role, &Option<String>); 3],
        common: &CommonArguments,
    ) -> Result<Setup, Failure> {
        let devices = devices(common)?.ok_or_else(|| {
            Failure::arguments(
                "a bench needs a device file, which says what carries the gyro",
                "add --devices, such as --devices paper; `hil list devices` lists those that ship",
            )
        })?;
        let mut ports = BTreeMap::new();
        for (role, text) in named {
            if let Some(text) = text {
                ports.insert(role, parse(text)?);
            }
        }
        let mut base = devices.base;
        match (ports.get(&Role::Base), &mut base) {
            // The transport is what the port carries: the same devices serve any.
            (Some(spec), Some((by, _))) => *by = transport(spec),
            (Some(_), None) => return Err(missing(Role::Base)),
            (None, _) => {}
        }
        if ports.contains_key(&Role::Table) && devices.table.is_none() {
            return Err(missing(Role::Table));
        }
        let parts = Parts {
            gyro: Some(devices.gyro),
            base,
            table: devices.table,
            mount: Some(devices.mount),
        };
        common.with(parts, ports)
    }

    impl CommonArguments {
        fn with(&self, parts: Parts, ports: BTreeMap<Role, PortSpec>) -> Result<Setup, Failure> {
            for (role, spec) in &ports {
                if *role != Role::Base && spec.carries_frames() {
                    return Err(Failure::arguments(
                        format!("failed to put the {role} on {spec}: it is on a serial line"),
                        "name a pty or a serial port: pty, /dev/ttyUSB0",
                    ));
                }
            }
            Ok(Setup { parts, ports, control: self.control.clone(), seed: self.seed })
        }
    }

    impl PortArguments {
        fn spec(&self) -> Result<PortSpec, Failure> {
            match (&self.port, &self.pty) {
                (Some(text), _) => parse(text),
                (None, Some(Some(link))) => Ok(PortSpec::Pty { link: Some(link.into()) }),
                (None, Some(None) | None) => Ok(PortSpec::Pty { link: None }),
            }
        }
    }

    fn parse(text: &str) -> Result<PortSpec, Failure> {
        text.parse().map_err(|error: ports::spec::SpecError| {
            Failure::arguments(error.to_string(), "`hil emulate --help` lists the ports")
        })
    }

    const fn transport(spec: &PortSpec) -> Transport {
        if spec.carries_frames() { Transport::Can } else { Transport::Serial }
    }

    fn devices(common: &CommonArguments) -> Result<Option<Devices>, Failure> {
        let Some(name) = &common.devices else { return Ok(None) };
        Ok(Some(load_devices(&Library::beside(name), name)?))
    }

    fn section<T>(section: Option<T>, role: Role) -> Result<T, Failure> {
        section.ok_or_else(|| missing(role))
    }

    fn missing(role: Role) -> Failure {
        Failure::arguments(
            format!("the device file has no {role}"),
            format!("add a section [{role}] to it, or choose another"),
        )
    }

    fn gyro(
        described: Option<(GyroStream, GyroParameters)>,
        stream: Option<Stream>,
        mode: Option<Mode>,
    ) -> Result<(GyroStream, GyroParameters), Failure> {
        let ideal =
            GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };
        let (mut set_up, parameters) = described.unwrap_or((ideal, GyroParameters::default()));
        if let Some(stream) = stream {
            set_up.format = match stream {
                Stream::Navigator => GyroFormat::Navigator,
                Stream::Ecore2000 => GyroFormat::Ecore2000,
                Stream::Dsp3000Ascii => GyroFormat::Dsp3000Ascii,
                Stream::Dsp3000Binary => GyroFormat::Dsp3000Binary,
            };
        }
        match mode {
            Some(Mode::Rate) => set_up.mode = OutputMode::Rate,
            Some(Mode::Increment) => set_up.mode = OutputMode::Increment,
            Some(Mode::Integrated) => set_up.mode = OutputMode::Integrated,
            None if !set_up.format.carries(set_up.mode) => set_up.mode = OutputMode::Rate,
            None => {}
        }
        if set_up.format.carries(set_up.mode) {
            return Ok((set_up, parameters));
        }
        Err(Failure::arguments(
            "this stream carries rates only",
            "leave --mode out, or choose --stream dsp3000-ascii or dsp3000-binary",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::socket;
    use std::path::PathBuf;

    #[test]
    fn a_socket_is_named_as_such() {
        assert_eq!(socket("unix:./ctl.sock"), Ok(PathBuf::from("./ctl.sock")));
        assert!(socket("./ctl.sock").is_err() && socket("unix:").is_err());
    }
}
