//! Links of the simulated bench: bytes take their time on a serial line, frames on a CAN bus, and messages may be changed
//! before.

mod can_bus;
mod gilbert_elliott;
mod serial_line;
mod tampering;

pub use can_bus::{CanBus, ErrorCounters, ErrorState, FRAMES_MAX, StateChange};
pub use gilbert_elliott::GilbertElliott;
pub use serial_line::{PACKETS_MAX, SerialLine};
pub use tampering::{Struck, Tampering};
