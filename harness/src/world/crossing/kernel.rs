//! The lines of a bench as ptys and a CAN bus of the kernel, with both ends here.

use super::can_wire::CanWire;
use super::pty_wire::PtyWire;
use super::slcan_wire::SlcanWire;
use super::{Crossing, CrossingFailure, KernelBus, Line, Toward};
use crate::port::PortError;
use crate::port::pty::PtyError;
use controller::config::Transport;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// The interface that frames cross.
pub const VCAN_INTERFACE: &str = "vcan0";

/// Why the lines cannot cross the kernel.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum KernelError {
    /// There is no pty.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Pty(#[from] PtyError),
    /// There is no CAN interface.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    /// A pty carries no frames.
    #[error("failed to find a bus for the base: it is on CAN, and a pty carries bytes")]
    #[diagnostic(help(
        "--bus slcan carries its frames across a pty as lines, --bus vcan across {VCAN_INTERFACE}"
    ))]
    NoFrames,
    /// What carries frames does not work.
    #[error(transparent)]
    Crossing(#[from] CrossingFailure),
}

/// What carries frames.
#[derive(Debug)]
enum Bus {
    Can(CanWire),
    Slcan(Box<SlcanWire>),
}

/// Every line of a bench. Those that it does not need, and those that failed, are `None`.
#[derive(Debug)]
pub struct Kernel {
    gyro: Option<PtyWire>,
    base: Option<PtyWire>,
    table: Option<PtyWire>,
    bus: Option<Bus>,
    name: &'static str,
    failure: Option<CrossingFailure>,
}

impl Kernel {
    /// Opens what a bench needs whose base is connected like that; one without a base has a table.
    ///
    /// # Errors
    /// When the system does not have it.
    pub fn open(bus: KernelBus, base: Option<Transport>) -> Result<Self, KernelError> {
        let mut kernel = Self {
            gyro: Some(PtyWire::open(Line::Gyro)?),
            base: None,
            table: None,
            bus: None,
            name: "pty",
            failure: None,
        };
        match (base, bus) {
            (None, _) => kernel.table = Some(PtyWire::open(Line::Table)?),
            (Some(Transport::Serial), _) => kernel.base = Some(PtyWire::open(Line::Base)?),
            (Some(Transport::Can), KernelBus::Pty) => return Err(KernelError::NoFrames),
            (Some(Transport::Can), KernelBus::Vcan) => {
                kernel.bus = Some(Bus::Can(CanWire::open(VCAN_INTERFACE)?));
                kernel.name = "vcan";
            }
            (Some(Transport::Can), KernelBus::Slcan) => {
                kernel.bus = Some(Bus::Slcan(Box::new(SlcanWire::open()?)));
                kernel.name = "slcan";
            }
        }
        Ok(kernel)
    }

    /// With another pty, or none, for a serial line.
    #[cfg(test)]
    pub(super) fn with_wire(mut self, line: Line, wire: PtyWire) -> Self {
        *self.wire(line) = Some(wire);
        self
    }

    const fn wire(&mut self, line: Line) -> &mut Option<PtyWire> {
        match line {
            Line::Gyro => &mut self.gyro,
            Line::Base => &mut self.base,
            Line::Table => &mut self.table,
        }
    }
}

impl Crossing for Kernel {
    fn bytes(&mut self, line: Line, toward: Toward, packet: &mut Packet) -> bool {
        let slot = self.wire(line);
        let Some(wire) = slot else { return false };
        let Err(failure) = wire.carry(toward, packet) else { return true };
        *slot = None;
        self.failure.get_or_insert(failure);
        false
    }

    fn frame(&mut self, now: Timestamp, toward: Toward, frame: &mut CanFrame) -> bool {
        let result = match &mut self.bus {
            None => return false,
            Some(Bus::Can(wire)) => wire.carry(toward, frame),
            Some(Bus::Slcan(wire)) => wire.carry(now, toward, frame),
        };
        let Err(failure) = result else { return true };
        self.bus = None;
        self.failure.get_or_insert(failure);
        false
    }

    fn failure(&mut self) -> Option<CrossingFailure> {
        self.failure.take()
    }

    fn bus(&self) -> &'static str {
        self.name
    }
}
