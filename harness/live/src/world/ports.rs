//! The ports that the harness has open in a run: those of emulated devices, and those that it listens at.

use super::journal::Journal;
use super::placement::far_spec;
use super::role_port::{PortEvent, RolePort, Traffic};
use crate::lines::{Place, Places};
use controller::config::Transport;
use ports::serial::usb;
use ports::spec::{SerialDevice, SerialSpec};
use ports::{PortError, PortSpec};
use record::Device;
use record::outcome::{PortSide, PortSummary};
use rig::line::EndId;
use std::collections::BTreeMap;
use std::future::Future as _;
use std::sync::Arc;
use std::task::Poll;
use wire::can::BitRates;
use wire::device::Transmit;
use wire::gyro::GyroFormat;
use wire::time::{Span, Timestamp};

/// A rate that is still wrong after this is not one that is being set. Assumption: a program opens its port
/// and sets it within a second.
const RATE_GRACE: Span = Span::from_secs(1);

/// Name of a role.
pub const GYRO: &str = "gyro";
/// See [`GYRO`].
pub const BASE: &str = "base";
/// See [`GYRO`].
pub const TABLE: &str = "table";

/// Whose device a role is, in the record.
pub(super) fn device(role: &str) -> Device {
    match role {
        GYRO => Device::Gyro,
        BASE => Device::Base,
        _ => Device::Table,
    }
}

/// What crosses the line of a base.
pub const fn base_traffic(transport: Transport) -> Traffic {
    match transport {
        Transport::Can => Traffic::Frames(BitRates::USUAL),
        Transport::Serial => Traffic::Bytes(wire::base::serial_link::SETTINGS),
    }
}

/// A port that a run needs.
#[derive(Debug, Clone)]
pub struct PortPlan {
    /// The role that it plays, or its line: as bench files and messages name it.
    pub role: Arc<str>,
    pub side: PortSide,
    pub spec: PortSpec,
    pub traffic: Traffic,
    /// Which end of which line it is: what comes from it is sent from there, and what is sent there leaves by it.
    pub line: usize,
    /// See `line`.
    pub end: EndId,
    /// As whose notes on it are.
    pub who: Device,
    /// It is the other side of this earlier port.
    pub(crate) far_of: Option<usize>,
    /// Nothing is sent: it is heard what others say on a bus.
    pub listens: bool,
}

/// What a run needs of the system: its ports, and where real devices are that the device under test has for itself.
#[derive(Debug, Clone, Default)]
pub struct PortPlans {
    pub ports: Vec<PortPlan>,
    /// Role and port.
    pub real: Vec<(Arc<str>, PortSpec)>,
}

/// A port that is open.
#[derive(Debug)]
pub struct OpenPort {
    pub plan: PortPlan,
    pub port: RolePort,
    rate: RateWatch,
}

/// The ports of the harness.
#[derive(Debug)]
pub struct Ports {
    pub open: Vec<OpenPort>,
    real: Vec<(Arc<str>, PortSpec)>,
    /// Which is asked first, in turn: one that never falls silent keeps no other waiting.
    first: usize,
}

/// Where the device under test finds its devices.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wiring {
    /// What stands for `{gyro}` and `{base}`, or for a line, in a command line.
    pub(super) words: BTreeMap<String, String>,
    /// The ports that it opens.
    pub(super) ports: BTreeMap<String, PortSpec>,
    /// The same, for programs that look for their lines by name.
    pub places: Places,
}

impl Wiring {
    /// The port of a role.
    pub(super) fn port(&self, role: &str) -> Option<&PortSpec> {
        self.ports.get(role)
    }
}

impl OpenPort {
    /// Hands something to it at once; what finds no room is counted.
    pub fn send(&mut self, now: Timestamp, what: &Transmit) {
        match what {
            Transmit::Bytes(packet) => self.port.send_bytes(packet.as_slice()),
            Transmit::Frame(frame) => self.port.send_frame(now, frame),
        }
    }

    /// What has crossed it, what is zero left out.
    pub fn counted(&self) -> BTreeMap<&'static str, u64> {
        self.port.counters().rows().into_iter().filter(|(_, n)| *n > 0).collect()
    }
}

impl Ports {
    /// Opens what the harness needs.
    ///
    /// # Errors
    ///
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
            // An adapter that is played here answers whoever opens it.
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

    /// Where the other side of each of these ports is, and where real devices are.
    ///
    /// # Errors
    ///
    /// When a USB adapter is not plugged in.
    pub fn wiring(&self) -> Result<Wiring, PortError> {
        let mut wiring = Wiring::default();
        let emulated = self.open.iter().filter(|open| {
            open.plan.side == PortSide::Bench && !open.plan.listens && !self.has_far(open)
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

    /// The harness itself has the other side.
    fn has_far(&self, near: &OpenPort) -> bool {
        self.open.iter().any(|open| {
            open.plan.far_of.is_some_and(|place| std::ptr::eq(&raw const self.open[place], near))
        })
    }

    /// Waits for what any of them tells, and says which. May be called off without losing anything.
    pub async fn next(&mut self) -> (usize, PortEvent) {
        let count = self.open.len();
        if count == 0 {
            return std::future::pending().await;
        }
        self.first = (self.first + 1) % count;
        let (before, after) = self.open.split_at_mut(self.first);
        let mut waiting: Vec<_> =
            after.iter_mut().chain(before).map(|open| Box::pin(open.port.next())).collect();
        let first = self.first;
        std::future::poll_fn(move |context| {
            for (index, port) in waiting.iter_mut().enumerate() {
                if let Poll::Ready(event) = port.as_mut().poll(context) {
                    return Poll::Ready(((first + index) % count, event));
                }
            }
            Poll::Pending
        })
        .await
    }

    /// The name of the port of a role.
    pub(super) fn name(&self, role: &str) -> &str {
        let found = self.open.iter().find(|open| &*open.plan.role == role);
        found.map_or("", |open| open.port.name())
    }

    /// The places of the ports that lead to that line.
    pub(crate) fn of_line(&mut self, line: usize) -> impl Iterator<Item = &mut OpenPort> {
        self.open.iter_mut().filter(move |open| open.plan.line == line)
    }

    /// What is wrong with the rate that the other side of a pty has set; `None` where nothing is.
    pub(super) fn wrong_rate(&mut self, now: Timestamp) -> Option<String> {
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

    /// What speaks for lines that are crossed or lead nowhere, where a run has not passed.
    pub(super) fn miswired(&self, gyro: Option<GyroFormat>) -> Option<String> {
        // One that puts out angles, too, may be told which.
        let takes_none = gyro?.facts().angle_step.is_none();
        let port = self.open.iter().find(|open| &*open.plan.role == GYRO)?;
        match port.port.counters().bytes_in {
            bytes @ 1.. if takes_none => Some(format!(
                "{bytes} bytes came to the {GYRO}'s port, and this {GYRO} takes none: are the lines crossed?"
            )),
            _ => None,
        }
    }

    pub(super) fn summaries(&self, journal: &Journal) -> Vec<PortSummary> {
        let summary = |open: &OpenPort| {
            journal.summary((Arc::clone(&open.plan.role), open.plan.side), &open.port)
        };
        // The plan's side of a port comes before the device's.
        let mut order: Vec<usize> = (0..self.open.len()).collect();
        order.sort_by_key(|place| {
            let far_of = self.open[*place].plan.far_of;
            (far_of.unwrap_or(*place), far_of.is_none())
        });
        order.into_iter().map(|place| summary(&self.open[place])).collect()
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
