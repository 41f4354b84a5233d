//! The line or bus between the plan and a device of the user's own.

use crate::faults::{Chance, FaultKind, Toward};
use crate::link::{CanBus, SerialLine, StateChange};
use crate::world::faults::makes_frames;
use described::Medium;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Who is at the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// The plan, which plays everybody but the device.
    Host,
    /// The device.
    Device,
    /// Another node, which a fault put on the bus.
    Stranger,
}

/// Both directions, paced by bit time or baud rate.
#[derive(Debug)]
pub(in crate::world) enum DeviceLink {
    Can(CanBus<End>),
    Serial { to_device: SerialLine, to_host: SerialLine },
}

impl DeviceLink {
    pub(in crate::world) fn new(medium: Medium) -> Self {
        match medium {
            Medium::Can => Self::Can(CanBus::new()),
            Medium::Serial(settings) => Self::Serial {
                to_device: SerialLine::new(settings),
                to_host: SerialLine::new(settings),
            },
        }
    }

    /// When something is through next.
    pub(in crate::world) fn next_arrival(&self) -> Timestamp {
        match self {
            Self::Can(bus) => bus.next_arrival(),
            Self::Serial { to_device, to_host } => {
                to_device.next_arrival().min(to_host.next_arrival())
            }
        }
    }

    /// Puts something on the line; what is of another medium is none of this line's.
    pub(in crate::world) fn send(&mut self, now: Timestamp, from: End, what: Transmit) {
        match (self, what) {
            (Self::Can(bus), Transmit::Frame(frame)) => bus.send(now, from, frame),
            (Self::Serial { to_device, to_host }, Transmit::Bytes(packet)) => match from {
                End::Device => to_host.send(now, packet),
                End::Host | End::Stranger => to_device.send(now, packet),
            },
            _ => {}
        }
    }

    /// Something that is through by `now`, and who sent it.
    pub(in crate::world) fn arrived(&mut self, now: Timestamp) -> Option<(End, Transmit)> {
        match self {
            Self::Can(bus) => bus.arrived(now).map(|(from, frame)| (from, Transmit::Frame(frame))),
            Self::Serial { to_device, to_host } => {
                let to_device = to_device.arrived(now).map(|packet| (End::Host, packet));
                let either = to_device.or_else(|| Some((End::Device, to_host.arrived(now)?)));
                either.map(|(from, packet)| (from, Transmit::Bytes(packet)))
            }
        }
    }

    /// What found no room.
    pub(in crate::world) fn dropped(&self) -> u64 {
        match self {
            Self::Can(bus) => bus.dropped(),
            Self::Serial { to_device, to_host } => to_device.dropped() + to_host.dropped(),
        }
    }

    /// The next change of a node's error state that was not told yet.
    pub(in crate::world) fn state_change(&mut self) -> Option<StateChange<End>> {
        match self {
            Self::Can(bus) => bus.state_change(),
            Self::Serial { .. } => None,
        }
    }

    /// From now on the line is faulty in this way too. Each direction draws for itself.
    pub(in crate::world) fn begin_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        kind: &FaultKind,
        toward: Toward,
        chance: impl Fn(&str) -> Chance,
    ) {
        let ways =
            [(Toward::Host, "to host", End::Device), (Toward::Device, "to device", End::Host)];
        let struck = ways.into_iter().filter(|(way, ..)| toward == Toward::Both || toward == *way);
        match self {
            Self::Can(bus) => {
                const NODES: [End; 2] = [End::Host, End::Device];
                let mut strike = |name, from| {
                    let fault = (number, kind, chance(name));
                    bus.begin_fault(now, fault, from, &NODES, End::Stranger);
                };
                if makes_frames(kind) {
                    return strike("bus", None);
                }
                struck.for_each(|(_, name, from)| strike(name, Some(from)));
            }
            Self::Serial { to_device, to_host } => {
                for (way, name, _) in struck {
                    let line = if way == Toward::Host { &mut *to_host } else { &mut *to_device };
                    line.begin_fault(now, number, kind, chance(name));
                }
            }
        }
    }

    /// The fault of this number is over; how often it acted.
    pub(in crate::world) fn end_fault(&mut self, now: Timestamp, number: usize) -> u64 {
        match self {
            Self::Can(bus) => bus.end_fault(now, number),
            Self::Serial { to_device, to_host } => {
                to_device.end_fault(number) + to_host.end_fault(number)
            }
        }
    }
}

/// As the record names a node.
pub(super) const fn node(end: End) -> &'static str {
    match end {
        End::Host => "host",
        End::Device => "device",
        End::Stranger => "stranger",
    }
}
