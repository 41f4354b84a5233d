//! Links of the simulated bench: bytes take their time on a serial line, frames on a CAN bus.

mod can_bus;
mod serial_line;

pub use can_bus::{BIT_RATE, CanBus, FRAMES_MAX};
pub use serial_line::{PACKETS_MAX, SerialLine};
