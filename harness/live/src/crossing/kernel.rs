//! The lines of a rig as ptys and CAN buses of the kernel, with both ends in this process.

use super::can_wire::CanWire;
use super::error::KernelError;
use super::pty_wire::PtyWire;
use super::slcan_wire::SlcanWire;
use rig::crossing::{CrossedLine, Crossing, CrossingFailure, KernelBus, Toward};
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Common prefix of the interface names.
const VCAN_INTERFACES: &str = "vcan";

#[derive(Debug)]
enum Wire {
    Pty(PtyWire),
    Can(CanWire),
    Slcan(Box<SlcanWire>),
}

impl Wire {
    fn carry(
        &mut self,
        now: Timestamp,
        toward: Toward,
        what: &mut Transmit,
    ) -> Result<(), CrossingFailure> {
        match (self, what) {
            (Self::Pty(wire), Transmit::Bytes(packet)) => wire.carry(toward, packet),
            (Self::Can(wire), Transmit::Frame(frame)) => wire.carry(toward, frame),
            (Self::Slcan(wire), Transmit::Frame(frame)) => wire.carry(now, toward, frame),
            // A line ignores the other medium.
            _ => Ok(()),
        }
    }
}

/// All lines of a rig, by index. A failed line is `None`.
#[derive(Debug)]
pub struct Kernel {
    wires: Vec<(CrossedLine, Option<Wire>)>,
    name: &'static str,
    failure: Option<CrossingFailure>,
}

impl Kernel {
    /// Opens the carriers of these lines. The first CAN bus uses `vcan0`, the second `vcan1`.
    ///
    /// # Errors
    /// When the system does not have one of them.
    pub fn open(bus: KernelBus, lines: &[CrossedLine]) -> Result<Self, KernelError> {
        let mut kernel = Self { wires: Vec::new(), name: "pty", failure: None };
        let mut buses = 0;
        for line in lines {
            let name = Arc::clone(&line.name);
            let wire = match (line.is_can, bus) {
                (false, _) => Wire::Pty(PtyWire::open(name)?),
                (true, KernelBus::Pty) => return Err(KernelError::NoFrames { line: name }),
                (true, KernelBus::Vcan) => {
                    kernel.name = "vcan";
                    buses += 1;
                    Wire::Can(CanWire::open(name, &format!("{VCAN_INTERFACES}{}", buses - 1))?)
                }
                (true, KernelBus::Slcan) if line.is_fd => {
                    return Err(KernelError::NoFd { line: name });
                }
                (true, KernelBus::Slcan) => {
                    kernel.name = "slcan";
                    Wire::Slcan(Box::new(SlcanWire::open(name)?))
                }
            };
            kernel.wires.push((line.clone(), Some(wire)));
        }
        Ok(kernel)
    }

    /// Replaces the pty of a serial line.
    #[cfg(test)]
    pub(super) fn with_wire(mut self, line: &str, wire: PtyWire) -> Self {
        let found = self.wires.iter_mut().find(|(known, _)| &*known.name == line);
        found.unwrap().1 = Some(Wire::Pty(wire));
        self
    }
}

impl Crossing for Kernel {
    fn carry(&mut self, now: Timestamp, line: usize, from: usize, what: &mut Transmit) -> bool {
        let Some((line, slot)) = self.wires.get_mut(line) else { return false };
        let Some(wire) = slot else { return false };
        // Frames that a fault put on a bus are carried like those of the devices.
        let is_device = from == line.device_end || from == usize::from(u8::MAX);
        let toward = if is_device { Toward::Host } else { Toward::Device };
        let Err(failure) = wire.carry(now, toward, what) else { return true };
        *slot = None;
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
