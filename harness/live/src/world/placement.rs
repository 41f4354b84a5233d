//! Assigns ports to the roles of a run, from a bench file and the needs of the plan's devices.

use controller::config::Transport;
use described::Medium;
use plan::bench_file::{BenchFile, Foreign, PortText, ROLES, Role};
use ports::PortSpec;
use ports::spec::{SerialDevice, SerialOptions, SerialSpec};
use rig::operator::RealRoles;
use std::path::{Path, PathBuf};

/// Player of a role, with its port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Player {
    /// An emulated device, reached through this port.
    Emulated(PortSpec),
    Real(PortSpec),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Placement {
    pub gyro: Player,
    /// `None` on a table.
    pub base: Option<Player>,
    /// A table on a port; an emulated table without one is commanded within the harness.
    pub table: Option<Player>,
}

/// Why a bench does not fit the plan.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PlacementError {
    /// The bench is one of another rig.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Foreign(#[from] Foreign),
    /// An invalid port of a role or a line.
    #[error("failed to read the port \"{port}\" of the {whose}")]
    #[diagnostic(help("`hil doctor` lists what there is; {example}"))]
    Port { port: String, whose: String, example: String, source: Box<ports::spec::SpecError> },
    /// The base of the plan is on the other kind of line.
    #[error(
        "failed to put the base on {port}: the plan's device file has it on {transport}, and this \
         carries {carried}"
    )]
    #[diagnostic(help(
        "give [base] another port, or run a plan whose device file has `transport = \"{other}\"`"
    ))]
    BaseTransport {
        port: String,
        transport: &'static str,
        carried: &'static str,
        /// Transport that the device file would need.
        other: &'static str,
    },
    /// The user's own device is on the other kind of line.
    #[error("failed to put the device on {port}: its layout needs a port for {wanted}")]
    #[diagnostic(help(
        "give [device] another port: `can:INTERFACE`, or a serial line such as /dev/ttyUSB0"
    ))]
    DeviceMedium { port: String, wanted: &'static str },
    /// CAN FD on an adapter, which carries classic frames.
    #[error(
        "failed to put the device on {port}: its line is CAN FD, and SLCAN carries classic frames"
    )]
    #[diagnostic(help(
        "CAN FD needs an interface of the kernel, set up with `fd on`, or a vcan: give the device or the line \
         the port `can:INTERFACE` in the bench file, or add --bus vcan"
    ))]
    NoFd { port: String },
    /// Other nodes beside a real base, or beside a table at a port.
    #[error(
        "failed to place the rig: the {role} at {port} has its line for itself, and other nodes are in the rig"
    )]
    #[diagnostic(help(
        "leave [{role}] out of the bench file: it is emulated then, beside the other nodes"
    ))]
    RobotAndNodes { role: &'static str, port: String },
    #[error("failed to tell the {first} from the {second}: both are on {port}")]
    #[diagnostic(help("a serial line leads to one device; give [{second}] a port of its own"))]
    SharedPort { port: String, first: &'static str, second: &'static str },
    /// An emulated table on a port whose other end the plan cannot open.
    #[error(
        "failed to put the emulated table on {port}: the plan commands it, and the other end of that port is \
         out of sight"
    )]
    #[diagnostic(help(
        "give it a pty, of which the plan takes the other end: [table] port = \"pty\"; or leave `emulated` \
         out, where the table is real"
    ))]
    EmulatedTable { port: String },
}

impl Placement {
    /// Places the roles of `bench` for a plan whose base is on `base`. An emulated role without a port goes to a pty,
    /// and on CAN to `can`.
    ///
    /// # Errors
    /// When the ports do not fit the plan or each other.
    pub fn new(
        bench: &BenchFile,
        base: Option<Transport>,
        can: &PortSpec,
    ) -> Result<Self, PlacementError> {
        shared(bench, base.is_some())?;
        let table = match bench.role("table") {
            Role::Emulated(None) => None,
            Role::Real(port) => Some(Player::Real(spec("table", &port)?)),
            Role::Emulated(Some(port)) if port.medium().is_made_here() => {
                Some(Player::Emulated(spec("table", &port)?))
            }
            Role::Emulated(Some(port)) => {
                return Err(PlacementError::EmulatedTable { port: port.to_string() });
            }
        };
        let base = match base {
            None => None,
            Some(transport) => Some(place_base(bench, transport, can)?),
        };
        Ok(Self {
            gyro: player("gyro", &bench.role("gyro"), &PortSpec::Pty { link: None })?,
            base,
            table,
        })
    }

    /// Whether other nodes can be on its lines.
    ///
    /// # Errors
    /// When the base is real or the table is at a port: the harness does not carry the traffic there.
    pub fn beside_nodes(&self) -> Result<(), PlacementError> {
        let alone =
            |role, port: &PortSpec| PlacementError::RobotAndNodes { role, port: port.to_string() };
        match (&self.base, &self.table) {
            (Some(Player::Real(port)), _) => Err(alone("base", port)),
            (_, Some(table)) => Err(alone("table", table.spec())),
            _ => Ok(()),
        }
    }

    /// Roles that real devices play.
    pub fn real_roles(&self) -> RealRoles {
        let is_real = |player: &Player| !player.is_emulated();
        RealRoles {
            gyro: is_real(&self.gyro),
            base: self.base.as_ref().is_some_and(is_real),
            table: self.table.as_ref().is_some_and(is_real),
            device: false,
        }
    }

    /// Player of a role; `None` if no device plays it.
    pub(super) fn player(&self, role: &str) -> Option<&Player> {
        match role {
            "gyro" => Some(&self.gyro),
            "base" => self.base.as_ref(),
            "table" => self.table.as_ref(),
            _ => None,
        }
    }

    /// Kinds of the ports, in a word for the summary.
    pub fn bus(&self) -> String {
        let base = self.base.as_ref().map(Player::spec);
        let mut kinds: Vec<&str> = Vec::new();
        let table = self.table.as_ref().map(Player::spec);
        for spec in [Some(self.gyro.spec()), base, table].into_iter().flatten() {
            let kind = spec.kind();
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        kinds.join("+")
    }
}

impl Player {
    pub const fn spec(&self) -> &PortSpec {
        match self {
            Self::Emulated(spec) | Self::Real(spec) => spec,
        }
    }

    pub const fn is_emulated(&self) -> bool {
        matches!(self, Self::Emulated(_))
    }
}

/// The far side of a port that is created or used here, as the device under test would open it.
pub(crate) fn far_spec(spec: &PortSpec, path: &str) -> PortSpec {
    let options = SerialOptions::default();
    let serial = SerialSpec { device: SerialDevice::Path(path.to_owned()), options };
    match spec {
        PortSpec::Can { .. } => spec.clone(),
        PortSpec::Slcan { bitrate, .. } => PortSpec::Slcan { serial, bitrate: *bitrate },
        PortSpec::SlcanPty { .. } => PortSpec::Slcan { serial, bitrate: None },
        PortSpec::Pty { .. } | PortSpec::Serial(_) => PortSpec::Serial(serial),
    }
}

/// Reads the port of a line of a rig.
///
/// # Errors
/// When the port is invalid.
pub fn line_port(line: &str, port: &PortText) -> Result<PortSpec, PlacementError> {
    let example = || format!("[line.{line}] port = \"can:can0\"");
    read(port, || (format!("line `{line}`"), example()))
}

fn spec(role: &'static str, port: &PortText) -> Result<PortSpec, PlacementError> {
    read(port, || (role.to_owned(), format!("[{role}] port = \"/dev/ttyUSB0\"")))
}

/// The port; in an error, `of` says whose it is, with an example.
fn read(port: &PortText, of: impl Fn() -> (String, String)) -> Result<PortSpec, PlacementError> {
    port.as_str().parse().map_err(|source| {
        let (whose, example) = of();
        let (port, source) = (port.to_string(), Box::new(source));
        PlacementError::Port { port, whose, example, source }
    })
}

pub fn player(
    role: &'static str,
    played: &Role,
    usual: &PortSpec,
) -> Result<Player, PlacementError> {
    Ok(match played {
        Role::Emulated(None) => Player::Emulated(usual.clone()),
        Role::Emulated(Some(port)) => Player::Emulated(spec(role, port)?),
        Role::Real(port) => Player::Real(spec(role, port)?),
    })
}

fn place_base(
    bench: &BenchFile,
    transport: Transport,
    can: &PortSpec,
) -> Result<Player, PlacementError> {
    let usual = match transport {
        Transport::Can => can.clone(),
        Transport::Serial => PortSpec::Pty { link: None },
    };
    let player = player("base", &bench.role("base"), &usual)?;
    let unfit = |transport, carried, other| PlacementError::BaseTransport {
        port: player.spec().to_string(),
        transport,
        carried,
        other,
    };
    match (transport, player.spec()) {
        (Transport::Can, PortSpec::Pty { .. } | PortSpec::Serial(_)) => {
            Err(unfit("CAN", "serial bytes", "serial"))
        }
        (Transport::Serial, PortSpec::Pty { .. } | PortSpec::Serial(_)) | (Transport::Can, _) => {
            Ok(player)
        }
        (Transport::Serial, _) => Err(unfit("a serial line", "CAN frames", "can")),
    }
}

/// Checks that no two roles of the plan share a serial line. A bus may be shared.
fn shared(bench: &BenchFile, with_base: bool) -> Result<(), PlacementError> {
    let mut seen: Vec<(&'static str, PathBuf)> = Vec::new();
    for role in ROLES {
        if role == "base" && !with_base {
            continue;
        }
        let Some(port) = bench.role(role).port().cloned() else { continue };
        let (PortSpec::Serial(SerialSpec { device, .. })
        | PortSpec::Slcan { serial: SerialSpec { device, .. }, .. }) = spec(role, &port)?
        else {
            continue;
        };
        let place = match &device {
            // The same device under two names, as in /dev/serial/by-id.
            SerialDevice::Path(path) => {
                Path::new(path).canonicalize().unwrap_or_else(|_| PathBuf::from(path))
            }
            SerialDevice::Usb(id) => PathBuf::from(format!("usb:{id}")),
        };
        if let Some((first, _)) = seen.iter().find(|(_, known)| *known == place) {
            return Err(PlacementError::SharedPort { port: port.to_string(), first, second: role });
        }
        seen.push((role, place));
    }
    Ok(())
}

/// Default port for this medium.
pub fn usual_port(medium: Medium, can: &PortSpec) -> PortSpec {
    match medium {
        Medium::Can => can.clone(),
        Medium::Serial(_) => PortSpec::Pty { link: None },
    }
}

#[cfg(test)]
mod tests {
    use super::{BenchFile, Placement, PlacementError, Player, PortSpec, Transport};

    fn place(text: &str, base: Option<Transport>) -> Result<Placement, PlacementError> {
        let bench: BenchFile = toml::from_str(text).unwrap();
        Placement::new(&bench, base, &PortSpec::Can { interface: "vcan0".to_owned() })
    }

    fn spec(text: &str) -> PortSpec {
        text.parse().unwrap()
    }

    #[test]
    fn a_role_without_a_port_goes_where_its_kind_of_line_is() {
        let pty = Player::Emulated(spec("pty"));
        let placed = place("", Some(Transport::Serial)).unwrap();
        assert_eq!((&placed.gyro, &placed.base), (&pty, &Some(pty.clone())));
        let placed = place("", Some(Transport::Can)).unwrap();
        assert_eq!(placed.base, Some(Player::Emulated(spec("can:vcan0"))));
        assert_eq!(placed.bus(), "pty+can");
        assert_eq!(place("", None).unwrap().base, None);
    }

    #[test]
    fn real_and_emulated_devices_are_mixed() {
        let bench = "[gyro]\nport = \"/dev/ttyUSB0\"\n[base]\nport = \"slcan-pty\"\nemulated = true\n\
                     [table]\nport = \"/dev/ttyUSB1\"";
        let placed = place(bench, Some(Transport::Can)).unwrap();
        assert_eq!(placed.gyro, Player::Real(spec("/dev/ttyUSB0")));
        assert_eq!(placed.base, Some(Player::Emulated(spec("slcan-pty"))));
        assert_eq!(placed.table, Some(Player::Real(spec("/dev/ttyUSB1"))));
        assert_eq!(placed.bus(), "serial+slcan-pty");
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let refused = |bench: &str, base| place(bench, base).unwrap_err().to_string();
        let cases = [
            refused("[base]\nport = \"/dev/ttyS1\"", Some(Transport::Can)),
            refused("[base]\nport = \"can:can0\"", Some(Transport::Serial)),
            refused("[table]\nport = \"/dev/ttyS2\"\nemulated = true", None),
            refused(
                "[gyro]\nport = \"/dev/ttyS1\"\n[base]\nport = \"serial:/dev/ttyS1?baud=300\"",
                Some(Transport::Serial),
            ),
        ];
        insta::assert_snapshot!(cases.join("\n"), @r#"
        failed to put the base on serial:/dev/ttyS1: the plan's device file has it on CAN, and this carries serial bytes
        failed to put the base on can:can0: the plan's device file has it on a serial line, and this carries CAN frames
        failed to put the emulated table on /dev/ttyS2: the plan commands it, and the other end of that port is out of sight
        failed to tell the gyro from the base: both are on serial:/dev/ttyS1?baud=300
        "#);
        // A base that the plan does not have cannot conflict.
        let bench = "[gyro]\nport = \"/dev/ttyS1\"\n[base]\nport = \"/dev/ttyS1\"";
        assert!(place(bench, None).is_ok());
    }
}
