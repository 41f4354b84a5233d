//! What ports for frames have in common.

use wire::can::CanFrame;
use wire::can_error::CanErrorEvent;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameEvent {
    /// A frame from the bus.
    Frame(CanFrame),
    /// The controller's report on the bus: an error frame.
    Bus(CanErrorEvent),
    /// The interface went down, or the other side closed the bus of the emulated adapter.
    Down,
    /// The interface is up again, or the other side opened the bus.
    Up,
}
