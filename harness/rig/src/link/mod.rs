//! Links of the simulated bench: pacing of serial lines and CAN buses, their faults, and faults of messages.

mod can_bus;
mod end_id;
mod gilbert_elliott;
mod serial_line;
mod tampering;

pub use can_bus::{CanBus, ErrorCounters, ErrorState, StateChange};
pub use end_id::EndId;
pub use gilbert_elliott::GilbertElliott;
pub use serial_line::{SerialLine, collide};
pub use tampering::{Struck, Tampering};
