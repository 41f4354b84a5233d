//! The lines of a simulated bench: who hears what, and when.

use crate::link::{CanBus, SerialLine};
use controller::config::Transport;
use wire::gyro::GyroStream;
use wire::time::Timestamp;

/// Who put a frame on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Node {
    Controller,
    Base,
    /// Another, which a fault put on the bus.
    Stranger,
}

/// How the controller and the base are joined.
#[derive(Debug)]
pub(super) enum BaseLink {
    None,
    Can(CanBus<Node>),
    Serial { to_base: SerialLine, to_controller: SerialLine },
}

impl BaseLink {
    pub(super) const fn is_bus(&self) -> bool {
        matches!(self, Self::Can(_))
    }
}

/// Every line of the bench.
#[derive(Debug)]
pub(super) struct Lines {
    /// The gyro's stream, to the controller.
    pub(super) gyro: SerialLine,
    /// The controller's commands, to the gyro.
    pub(super) gyro_commands: SerialLine,
    pub(super) base: BaseLink,
    pub(super) to_table: SerialLine,
    pub(super) from_table: SerialLine,
}

impl Lines {
    pub(super) fn new(stream: GyroStream, base: Option<Transport>) -> Self {
        let gyro = stream.format.serial();
        let table = wire::table::SETTINGS;
        let base = match base {
            None => BaseLink::None,
            Some(Transport::Can) => BaseLink::Can(CanBus::new()),
            Some(Transport::Serial) => {
                let settings = wire::base::serial_link::SETTINGS;
                BaseLink::Serial {
                    to_base: SerialLine::new(settings),
                    to_controller: SerialLine::new(settings),
                }
            }
        };
        Self {
            gyro: SerialLine::new(gyro),
            gyro_commands: SerialLine::new(gyro),
            base,
            to_table: SerialLine::new(table),
            from_table: SerialLine::new(table),
        }
    }

    /// When something is through next, on any line.
    pub(super) fn next_arrival(&self) -> Timestamp {
        let base = match &self.base {
            BaseLink::None => Timestamp::MAX,
            BaseLink::Can(bus) => bus.next_arrival(),
            BaseLink::Serial { to_base, to_controller } => {
                to_base.next_arrival().min(to_controller.next_arrival())
            }
        };
        base.min(self.gyro.next_arrival())
            .min(self.gyro_commands.next_arrival())
            .min(self.to_table.next_arrival())
            .min(self.from_table.next_arrival())
    }

    /// What has been dropped for want of room, on all lines.
    pub(super) fn dropped(&self) -> u64 {
        let base = match &self.base {
            BaseLink::None => 0,
            BaseLink::Can(bus) => bus.dropped(),
            BaseLink::Serial { to_base, to_controller } => {
                to_base.dropped() + to_controller.dropped()
            }
        };
        let serial = [&self.gyro, &self.gyro_commands, &self.to_table, &self.from_table];
        base + serial.into_iter().map(SerialLine::dropped).sum::<u64>()
    }
}
