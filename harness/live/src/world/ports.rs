//! The ports that the harness opens in a run: those of emulated devices, and those at which it only listens.

use super::placement::far_spec;
use super::role_port::{PortEvent, RolePort, Traffic};
use crate::lines::{Place, Places};
use controller::config::Transport;
use futures_util::future::select_all;
use ports::serial::usb;
use ports::spec::{SerialDevice, SerialSpec};
use ports::{PortError, PortSpec};
use record::Device;
use record::outcome::PortSide;
use rig::line::EndId;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::can::BitRates;
use wire::device::Transmit;
use wire::gyro::GyroFormat;
use wire::time::{Span, Timestamp};

/// A wrong rate that lasts longer than this is not just about to be set. Assumption: a program opens its port and sets
/// the rate within a second.
pub(crate) const RATE_GRACE: Span = Span::from_secs(1);

pub const GYRO: &str = "gyro";
pub const BASE: &str = "base";
pub const TABLE: &str = "table";

/// Device of a role in the record.
pub(super) fn device(role: &str) -> Device {
    match role {
        GYRO => Device::Gyro,
        BASE => Device::Base,
        _ => Device::Table,
    }
}

pub const fn base_traffic(transport: Transport) -> Traffic {
    match transport {
        Transport::Can => Traffic::Frames(BitRates::USUAL),
        Transport::Serial => Traffic::Bytes(wire::base::serial_link::SETTINGS),
    }
}

#[derive(Debug, Clone)]
pub struct PortPlan {
    /// Its role or line, as named in bench files and messages.
    pub role: Arc<str>,
    pub side: PortSide,
    pub spec: PortSpec,
    pub traffic: Traffic,
    /// Line and end that the port serves: data from the port is sent from that end, and data for that end goes to the
    /// port.
    pub line: usize,
    pub end: EndId,
    /// Device to which notes on it are attributed.
    pub who: Device,
    /// Index of the earlier port of which this is the far side.
    pub(crate) far_of: Option<usize>,
    /// Whether it only listens to a bus and sends nothing.
    pub listens: bool,
}

/// Ports of a run: those of the harness, and those of real devices that only the device under test opens.
#[derive(Debug, Clone, Default)]
pub struct PortPlans {
    pub ports: Vec<PortPlan>,
    pub real: Vec<(Arc<str>, PortSpec)>,
}

#[derive(Debug)]
pub struct OpenPort {
    pub plan: PortPlan,
    pub port: RolePort,
    rate: RateWatch,
}

#[derive(Debug)]
pub struct Ports {
    pub open: Vec<OpenPort>,
    real: Vec<(Arc<str>, PortSpec)>,
    /// The port polled first, in turn, so that a busy port does not starve the others.
    first: usize,
}

/// Ports of the devices for the device under test.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wiring {
    /// Values for `{gyro}` and `{base}`, or for a line, in a command line.
    pub(super) words: BTreeMap<String, String>,
    /// The ports that it opens.
    pub(super) ports: BTreeMap<String, PortSpec>,
    /// Ports of lines, for programs that look them up by name.
    pub places: Places,
}

impl Wiring {
    pub(super) fn port(&self, role: &str) -> Option<&PortSpec> {
        self.ports.get(role)
    }
}

impl OpenPort {
    /// Sends at once; counts what finds no room.
    pub fn send(&mut self, now: Timestamp, what: &Transmit) {
        match what {
            Transmit::Bytes(packet) => self.port.send_bytes(packet.as_slice()),
            Transmit::Frame(frame) => self.port.send_frame(now, frame),
        }
    }

    pub fn counted(&self) -> BTreeMap<&'static str, u64> {
        self.port.counters().rows().into_iter().filter(|(_, n)| *n > 0).collect()
    }
}

impl Ports {
    /// Opens the ports of the harness.
    ///
    /// # Errors
    /// The first port that cannot be opened.
    pub async fn open(plans: PortPlans) -> Result<Self, PortError> {
        let mut ports = Self { open: Vec::new(), real: plans.real, first: 0 };
        for mut plan in plans.ports {
            let far = plan.far_of.and_then(|near| ports.open.get(near));
            if let Some(OpenPort { port, .. }) = far
                && let Some(path) = port.far_path()
            {
                plan.spec = far_spec(&plan.spec, path);
            }
            // An emulated adapter must answer when it is opened.
            let port = {
                let mut opening = std::pin::pin!(RolePort::open(&plan.spec, plan.traffic));
                loop {
                    tokio::select! {
                        port = &mut opening => break port?,
                        _ = ports.next() => {}
                    }
                }
            };
            let right = match plan.traffic {
                Traffic::Bytes(settings) if plan.side == PortSide::Bench => Some(settings.baud),
                _ => None,
            };
            ports.open.push(OpenPort { plan, port, rate: RateWatch::new(right) });
        }
        Ok(ports)
    }

    /// Far sides of these ports, and the ports of real devices.
    ///
    /// # Errors
    /// When a USB adapter is not plugged in.
    pub fn wiring(&self) -> Result<Wiring, PortError> {
        let mut wiring = Wiring::default();
        // A bus of the kernel has room for others even if the plan is at its port, beside a real device.
        let is_shared = |open: &OpenPort| matches!(open.plan.spec, PortSpec::Can { .. });
        let emulated = self.open.iter().filter(|open| {
            (open.plan.side == PortSide::Bench || is_shared(open))
                && !open.plan.listens
                && !self.has_far(open)
        });
        let emulated = emulated.filter_map(|open| {
            let path = open.port.far_path();
            let far = path.map(|path| far_spec(&open.plan.spec, path))?;
            Some((&open.plan.role, far, Some(open.plan.traffic)))
        });
        let real = self.real.iter().map(|(role, spec)| (role, spec.clone(), None));
        for (role, far, traffic) in emulated.chain(real) {
            wiring.words.insert(role.to_string(), word(&far)?);
            let place = Place::of_port(&far);
            let place = match traffic {
                Some(Traffic::Bytes(settings)) => place.with_settings(settings),
                Some(Traffic::Frames(rates)) => place.with_rates(rates),
                None => place,
            };
            wiring.places.insert(role.to_string(), place);
            wiring.ports.insert(role.to_string(), far);
        }
        Ok(wiring)
    }

    /// Whether the harness itself opens the far side.
    fn has_far(&self, near: &OpenPort) -> bool {
        self.open.iter().any(|open| {
            open.plan.far_of.is_some_and(|place| std::ptr::eq(&raw const self.open[place], near))
        })
    }

    /// Waits for an event of any port; returns the port's index too. Cancel-safe.
    pub async fn next(&mut self) -> (usize, PortEvent) {
        let count = self.open.len();
        if count == 0 {
            return std::future::pending().await;
        }
        self.first = (self.first + 1) % count;
        let (before, after) = self.open.split_at_mut(self.first);
        let waiting = after.iter_mut().chain(before).map(|open| Box::pin(open.port.next()));
        let (event, index, _) = select_all(waiting).await;
        ((self.first + index) % count, event)
    }

    pub(super) fn name(&self, role: &str) -> &str {
        let found = self.open.iter().find(|open| &*open.plan.role == role);
        found.map_or("", |open| open.port.name())
    }

    pub(crate) fn of_line(&mut self, line: usize) -> impl Iterator<Item = &mut OpenPort> {
        self.open.iter_mut().filter(move |open| open.plan.line == line)
    }

    /// A message about a wrong rate set at the far side of a pty; `None` if the rate is right.
    pub(crate) fn wrong_rate(&mut self, now: Timestamp) -> Option<String> {
        self.open.iter_mut().find_map(|OpenPort { plan, port, rate }| {
            let role = &plan.role;
            rate.wrong(now, port.far_baud()).map(|(set, right)| {
                format!(
                    "the other side has set the {role}'s port to {set} baud, and the {role} speaks \
                     {right}: a real line would carry nothing but errors"
                )
            })
        })
    }

    /// A hint at crossed or unconnected lines, for a run that has not passed.
    pub(super) fn miswired(&self, gyro: Option<GyroFormat>) -> Option<String> {
        // A gyro that also outputs angles accepts commands, to select the output.
        let takes_none = gyro?.facts().angle_step.is_none();
        let port = self.open.iter().find(|open| &*open.plan.role == GYRO)?;
        match port.port.counters().bytes_in {
            bytes @ 1.. if takes_none => Some(format!(
                "{bytes} bytes came to the {GYRO}'s port, and this {GYRO} takes none: are the lines crossed?"
            )),
            _ => None,
        }
    }
}

/// A path or an interface, for command lines.
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

/// Watches the rate that the far side of a pty sets.
#[derive(Debug)]
struct RateWatch {
    /// `None` for a port of frames.
    right: Option<u32>,
    wrong_since: Option<Timestamp>,
}

impl RateWatch {
    const fn new(right: Option<u32>) -> Self {
        Self { right, wrong_since: None }
    }

    /// The rate that is set and the right one, once it has been wrong for too long.
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
