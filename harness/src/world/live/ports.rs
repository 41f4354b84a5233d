//! The ports that the harness has open in a run: those of emulated devices, and those that it listens at.

use super::journal::Journal;
use super::placement::{Placement, Player, far_spec};
use super::role_port::{PortEvent, RolePort, Traffic, next};
use crate::outcome::{PortSide, PortSummary};
use crate::port::serial::usb;
use crate::port::spec::{SerialDevice, SerialSpec};
use crate::port::{PortError, PortSpec};
use crate::record::Device;
use controller::config::Transport;
use std::collections::BTreeMap;
use wire::gyro::GyroFormat;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// A rate that is still wrong after this is not one that is being set. Assumption: a program opens its port
/// and sets it within a second.
const RATE_GRACE: Span = Span::from_secs(1);

/// Name of a role.
pub(super) const GYRO: &str = "gyro";
/// See [`GYRO`].
pub(super) const BASE: &str = "base";
/// See [`GYRO`].
pub(super) const TABLE: &str = "table";
/// The emulated table's own end of its line; the other is the plan's.
pub(super) const TABLE_DEVICE: &str = "emulated table";

/// Whose device a role is, in the record.
pub(super) fn device(role: &str) -> Device {
    match role {
        GYRO => Device::Gyro,
        BASE => Device::Base,
        _ => Device::Table,
    }
}

/// What crosses the line of a base.
pub(super) const fn base_traffic(transport: Transport) -> Traffic {
    match transport {
        Transport::Can => Traffic::Frames,
        Transport::Serial => Traffic::Bytes(wire::base::serial_link::SETTINGS),
    }
}

/// The ports of the harness.
#[derive(Debug)]
pub(super) struct Ports {
    /// An emulated gyro's.
    pub(super) gyro: Option<RolePort>,
    /// An emulated base's, or the bus of a real one.
    pub(super) base: Option<RolePort>,
    /// A table's, real or emulated, through which the plan commands it.
    pub(super) table: Option<RolePort>,
    /// An emulated table's own.
    pub(super) table_device: Option<RolePort>,
    rates: [RateWatch; 2],
}

/// Where the device under test finds its devices.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Wiring {
    /// What stands for `{gyro}` and `{base}` in a command line.
    pub(super) words: BTreeMap<String, String>,
    /// The ports that it opens.
    pub(super) gyro: Option<PortSpec>,
    /// See `gyro`.
    pub(super) base: Option<PortSpec>,
}

impl Ports {
    /// Opens what the harness needs.
    ///
    /// # Errors
    ///
    /// The first port that cannot be opened.
    pub(super) async fn open(
        placement: &Placement,
        gyro: SerialSettings,
        base: Option<Transport>,
    ) -> Result<Self, PortError> {
        let gyro_port = match &placement.gyro {
            Player::Emulated(spec) => Some(RolePort::open(spec, Traffic::Bytes(gyro)).await?),
            Player::Real(_) => None,
        };
        let traffic = base.map(base_traffic);
        let base_port = match (&placement.base, traffic) {
            (
                Some(Player::Emulated(spec) | Player::Real(spec @ PortSpec::Can { .. })),
                Some(traffic),
            ) => Some(RolePort::open(spec, traffic).await?),
            _ => None,
        };
        let (table, table_device) = open_table(placement.table.as_ref()).await?;
        let base_rate = match traffic {
            Some(Traffic::Bytes(settings)) => Some(settings.baud),
            _ => None,
        };
        let rates = [RateWatch::new(Some(gyro.baud)), RateWatch::new(base_rate)];
        Ok(Self { gyro: gyro_port, base: base_port, table, table_device, rates })
    }

    /// Where the other side of each of these ports is, and where real devices are.
    ///
    /// # Errors
    ///
    /// When a USB adapter is not plugged in.
    pub(super) fn wiring(&self, placement: &Placement) -> Result<Wiring, PortError> {
        let mut wiring = Wiring::default();
        let roles = [
            (GYRO, Some(&placement.gyro), &self.gyro, &mut wiring.gyro),
            (BASE, placement.base.as_ref(), &self.base, &mut wiring.base),
        ];
        for (role, player, port, far) in roles {
            *far = match (player, port) {
                (Some(Player::Real(spec)), _) => Some(spec.clone()),
                (Some(Player::Emulated(spec)), Some(port)) => {
                    port.far_path().map(|path| far_spec(spec, path))
                }
                _ => None,
            };
            if let Some(spec) = far {
                wiring.words.insert(role.to_owned(), word(spec)?);
            }
        }
        Ok(wiring)
    }

    /// Waits for what any of them tells. May be called off without losing anything.
    pub(super) async fn next(&mut self) -> (&'static str, PortEvent) {
        tokio::select! {
            event = next(self.gyro.as_mut()) => (GYRO, event),
            event = next(self.base.as_mut()) => (BASE, event),
            event = next(self.table.as_mut()) => (TABLE, event),
            event = next(self.table_device.as_mut()) => (TABLE_DEVICE, event),
        }
    }

    /// The name of the port of a role.
    pub(super) fn name(&self, role: &str) -> &str {
        let port = match role {
            GYRO => &self.gyro,
            BASE => &self.base,
            TABLE_DEVICE => &self.table_device,
            _ => &self.table,
        };
        port.as_ref().map_or("", RolePort::name)
    }

    /// What is wrong with the rate that the other side of a pty has set; `None` where nothing is.
    pub(super) fn wrong_rate(&mut self, now: Timestamp) -> Option<String> {
        let ports = [(GYRO, &mut self.gyro), (BASE, &mut self.base)];
        ports.into_iter().zip(&mut self.rates).find_map(|((role, port), watch)| {
            watch.wrong(now, port.as_mut()?.far_baud()).map(|(set, right)| {
                format!(
                    "the other side has set the {role}'s port to {set} baud, and the {role} speaks \
                     {right}: a real line would carry nothing but errors"
                )
            })
        })
    }

    /// What speaks for lines that are crossed or lead nowhere, where a run has not passed.
    pub(super) fn miswired(&self, gyro: GyroFormat) -> Option<String> {
        let heard = |port: &Option<RolePort>| port.as_ref().map(|port| port.counters().bytes_in);
        // Only the digital gyros take commands.
        let takes_none = matches!(gyro, GyroFormat::Navigator | GyroFormat::Ecore2000);
        match heard(&self.gyro) {
            Some(bytes @ 1..) if takes_none => Some(format!(
                "{bytes} bytes came to the {GYRO}'s port, and this {GYRO} takes none: are the lines crossed?"
            )),
            _ => None,
        }
    }

    pub(super) fn summaries(&self, journal: &Journal) -> Vec<PortSummary> {
        let ports = [
            ((GYRO, PortSide::Bench), &self.gyro),
            ((BASE, PortSide::Bench), &self.base),
            ((TABLE, PortSide::Plan), &self.table),
            ((TABLE, PortSide::Bench), &self.table_device),
        ];
        let open = ports.into_iter().filter_map(|(whose, port)| Some((whose, port.as_ref()?)));
        open.map(|(whose, port)| journal.summary(whose, port)).collect()
    }
}

/// The plan's end of the table's line and, of an emulated one, its own.
async fn open_table(
    table: Option<&Player>,
) -> Result<(Option<RolePort>, Option<RolePort>), PortError> {
    let traffic = Traffic::Bytes(wire::table::SETTINGS);
    match table {
        None => Ok((None, None)),
        Some(Player::Real(spec)) => Ok((Some(RolePort::open(spec, traffic).await?), None)),
        Some(Player::Emulated(spec)) => {
            let device = RolePort::open(spec, traffic).await?;
            let far = device.far_path().map(|path| far_spec(spec, path));
            let plan = RolePort::open(far.as_ref().unwrap_or(spec), traffic).await?;
            Ok((Some(plan), Some(device)))
        }
    }
}

/// A path or an interface, as command lines take them.
fn word(spec: &PortSpec) -> Result<String, PortError> {
    Ok(match spec {
        PortSpec::Can { interface } => interface.clone(),
        PortSpec::Serial(SerialSpec { device, .. })
        | PortSpec::Slcan { serial: SerialSpec { device, .. }, .. } => match device {
            SerialDevice::Path(path) => path.clone(),
            SerialDevice::Usb(id) => usb::find(id, &usb::adapters())?,
        },
        PortSpec::Pty { .. } | PortSpec::SlcanPty { .. } => spec.to_string(),
    })
}

/// Watches the rate that the other side of a pty sets.
#[derive(Debug)]
struct RateWatch {
    /// None where there are no bytes.
    right: Option<u32>,
    wrong_since: Option<Timestamp>,
}

impl RateWatch {
    const fn new(right: Option<u32>) -> Self {
        Self { right, wrong_since: None }
    }

    /// The rate that is set and the one that would be right, once it is wrong for good.
    fn wrong(&mut self, now: Timestamp, set: Option<u32>) -> Option<(u32, u32)> {
        let (Some(set), Some(right)) = (set, self.right) else { return None };
        if set == right {
            self.wrong_since = None;
            return None;
        }
        let since = *self.wrong_since.get_or_insert(now);
        (now - since >= RATE_GRACE).then_some((set, right))
    }
}

#[cfg(test)]
mod tests {
    use super::{PortSpec, RATE_GRACE, RateWatch, Timestamp, far_spec, word};

    #[test]
    fn the_other_side_is_opened_as_what_it_is() {
        for (here, there, as_word) in [
            ("pty", "serial:/dev/pts/4", "/dev/pts/4"),
            ("slcan-pty:./can.pty", "slcan:/dev/pts/4", "/dev/pts/4"),
            ("can:vcan0", "can:vcan0", "vcan0"),
        ] {
            let far = far_spec(&here.parse::<PortSpec>().unwrap(), "/dev/pts/4");
            assert_eq!((far.to_string().as_str(), word(&far).unwrap().as_str()), (there, as_word));
        }
    }

    #[test]
    fn a_rate_that_is_only_passed_through_is_not_wrong() {
        let mut watch = RateWatch::new(Some(9_600));
        let wrong = Some((4_800, 9_600));
        assert_eq!(watch.wrong(Timestamp::ZERO, Some(4_800)), None);
        assert_eq!(watch.wrong(Timestamp::ZERO + RATE_GRACE, Some(9_600)), None);
        assert_eq!(watch.wrong(Timestamp::ZERO + RATE_GRACE, Some(4_800)), None);
        assert_eq!(watch.wrong(Timestamp::ZERO + RATE_GRACE + RATE_GRACE, Some(4_800)), wrong);
        assert_eq!(RateWatch::new(None).wrong(Timestamp::MAX, Some(1)), None);
    }
}
