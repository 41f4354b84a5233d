//! The lines of a rig, and the taps at their ends.

use controller::config::Transport;
use harness::link::{CanBus, SerialLine};
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::gyro::GyroStream;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Who hears what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// The gyro's stream.
    GyroToController,
    /// Commands to a gyro that takes some.
    ControllerToGyro,
    /// Motion, pose and answers.
    BaseToController,
    /// Requests.
    ControllerToBase,
}

const DIRECTIONS: usize = 4;

/// What is received at once.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// Serial bytes.
    Bytes(Vec<u8>),
    /// A CAN frame.
    Frame(CanFrame),
}

/// Says what is received in place of what has arrived.
pub type Tap = Box<dyn FnMut(Timestamp, Piece) -> Vec<Piece>>;

pub(super) struct Arrived {
    pub(super) direction: Direction,
    pub(super) piece: Piece,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Node {
    Controller,
    Base,
}

enum BaseLink {
    None,
    Can(CanBus<Node>),
    Serial { to_base: SerialLine, to_controller: SerialLine },
}

pub(super) struct Links {
    pub(super) gyro: SerialLine,
    pub(super) gyro_commands: SerialLine,
    base: BaseLink,
    taps: [Option<Tap>; DIRECTIONS],
}

impl Links {
    pub(super) fn new(stream: GyroStream, base: Option<Transport>) -> Self {
        let gyro = || SerialLine::new(stream.format.serial());
        let serial = || SerialLine::new(wire::base::serial_link::SETTINGS);
        Self {
            gyro_commands: gyro(),
            gyro: gyro(),
            base: match base {
                None => BaseLink::None,
                Some(Transport::Can) => BaseLink::Can(CanBus::new()),
                Some(Transport::Serial) => {
                    BaseLink::Serial { to_base: serial(), to_controller: serial() }
                }
            },
            taps: [const { None }; DIRECTIONS],
        }
    }

    pub(super) fn tap(&mut self, direction: Direction, tap: Option<Tap>) {
        self.taps[direction as usize] = tap;
    }

    pub(super) fn through_tap(
        &mut self,
        now: Timestamp,
        direction: Direction,
        piece: Piece,
    ) -> Vec<Piece> {
        match &mut self.taps[direction as usize] {
            Some(tap) => tap(now, piece),
            None => vec![piece],
        }
    }

    pub(super) fn next_arrival(&self) -> Timestamp {
        let base = match &self.base {
            BaseLink::None => Timestamp::MAX,
            BaseLink::Can(bus) => bus.next_arrival(),
            BaseLink::Serial { to_base, to_controller } => {
                to_base.next_arrival().min(to_controller.next_arrival())
            }
        };
        base.min(self.gyro.next_arrival()).min(self.gyro_commands.next_arrival())
    }

    /// What is through by `now`.
    pub(super) fn arrived(&mut self, now: Timestamp) -> Option<Arrived> {
        let bytes = |packet: Packet| Piece::Bytes(packet.as_slice().to_vec());
        if let Some(packet) = self.gyro.arrived(now) {
            return Some(Arrived { direction: Direction::GyroToController, piece: bytes(packet) });
        }
        if let Some(packet) = self.gyro_commands.arrived(now) {
            return Some(Arrived { direction: Direction::ControllerToGyro, piece: bytes(packet) });
        }
        match &mut self.base {
            BaseLink::None => None,
            BaseLink::Can(bus) => bus.arrived(now).map(|(from, frame)| Arrived {
                direction: match from {
                    Node::Controller => Direction::ControllerToBase,
                    Node::Base => Direction::BaseToController,
                },
                piece: Piece::Frame(frame),
            }),
            BaseLink::Serial { to_base, to_controller } => {
                let to_base = to_base.arrived(now).map(|packet| Arrived {
                    direction: Direction::ControllerToBase,
                    piece: bytes(packet),
                });
                to_base.or_else(|| {
                    to_controller.arrived(now).map(|packet| Arrived {
                        direction: Direction::BaseToController,
                        piece: bytes(packet),
                    })
                })
            }
        }
    }

    pub(super) fn send_to_base(&mut self, now: Timestamp, packet: Packet) {
        if let BaseLink::Serial { to_base, .. } = &mut self.base {
            to_base.send(now, packet);
        }
    }

    pub(super) fn send_frame(&mut self, now: Timestamp, frame: CanFrame) {
        if let BaseLink::Can(bus) = &mut self.base {
            bus.send(now, Node::Controller, frame);
        }
    }

    pub(super) fn send_from_base(&mut self, now: Timestamp, output: Transmit) {
        match (output, &mut self.base) {
            (Transmit::Frame(frame), BaseLink::Can(bus)) => bus.send(now, Node::Base, frame),
            (Transmit::Bytes(packet), BaseLink::Serial { to_controller, .. }) => {
                to_controller.send(now, packet);
            }
            _ => {}
        }
    }
}
