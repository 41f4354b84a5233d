//! `hil emulate`: emulated devices on ports, in real time, for any controller.

mod setup;

use super::failure::Failure;
use crate::choices;
use clap::{Args, Subcommand};
use record::outcome::Outcome;
use std::path::PathBuf;
use wire::gyro::{GyroFormat, OutputMode};

const PORTS: &str = "\
Ports:
  pty  pty:LINK                  a new pty; LINK leads to its other side
  /dev/ttyUSB0  serial:usb:0403:6001
                                 a serial port, at the other end of which your program is
  can:vcan0                      a CAN interface
  slcan-pty  slcan-pty:LINK      an emulated CAN adapter on a pty
  slcan:/dev/ttyACM0             a CAN adapter that is plugged in here

The standard input takes requests, a JSON line each, answered on the standard output:
  {\"id\":1,\"set\":{\"bias_deg_per_h\":30}}   {\"get\":\"truth\"}   {\"fault\":\"disconnect\"}   {\"list\":true}
docs/emulators.md has all of them.

Exit status:
  0  ended by Ctrl-C or a request to terminate
  2  bad input: arguments or a device file
  3  a port cannot be opened, or was lost for good";

/// Emulates devices on ports, in real time, for your own controller.
///
/// Prints a JSON line for each port when all are open, then runs until Ctrl-C or a request to
/// terminate, and ends with a line of counters. A device without a device file is ideal.
#[derive(Debug, Args)]
#[command(after_help = PORTS)]
pub(super) struct EmulateArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// A custom device, from its description (`hil new` creates one).
    Device {
        /// The description: a path.
        #[arg(value_name = "DESCRIPTION")]
        description: String,
        /// CAN interface, the same as --port can:INTERFACE.
        #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["pty", "port"])]
        can: Option<String>,
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        run: RunArguments,
    },
    /// All emulated devices of a rig; the other nodes on its lines are yours.
    Rig {
        /// The rig: a name (see `hil list rigs`) or a path.
        #[arg(value_name = "RIG")]
        rig: String,
        /// Port of a line, such as can0=can:vcan0; a line without a port stays inside `hil`.
        #[arg(long = "line", value_name = "LINE=PORT", required = true)]
        lines: Vec<String>,
        #[command(flatten)]
        run: RunArguments,
    },
    /// A gyro of the paper alone; the request rate_deg_per_s turns it.
    Gyro {
        /// Stream format. [default: that of the device file, else navigator]
        #[arg(long, value_parser = choices::gyro_format())]
        stream: Option<GyroFormat>,
        /// Output mode. [default: that of the device file, else rate]
        #[arg(long, value_parser = choices::output_mode())]
        mode: Option<OutputMode>,
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// The mobile base of the paper, on CAN or a serial line.
    Base {
        /// CAN interface, the same as --port can:INTERFACE.
        #[arg(long, value_name = "INTERFACE", conflicts_with_all = ["pty", "port"])]
        can: Option<String>,
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// The rotary table of the paper.
    Table {
        #[command(flatten)]
        port: PortArguments,
        #[command(flatten)]
        common: CommonArguments,
    },
    /// A whole bench of the paper: the gyro feels the motion of its carrier.
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
    /// A pty, which is the default; LINK, if given, leads to its other side.
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
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Debug, Args)]
struct RunArguments {
    /// Also take requests on this socket.
    #[arg(long, value_name = "unix:PATH", value_parser = socket)]
    control: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn socket(text: &str) -> Result<PathBuf, String> {
    match text.strip_prefix("unix:") {
        Some(path) if !path.is_empty() => Ok(path.into()),
        _ => Err("expected unix:PATH".to_owned()),
    }
}

impl EmulateArguments {
    pub(super) fn execute(&self, screen: &super::Screen) -> Result<Outcome, Failure> {
        let mut warn = |what: &str| screen.note(what);
        live::emulation::run(&self.setup()?, std::io::stdout(), &mut warn)?;
        Ok(Outcome::Passed)
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
