//! The ports of a bench, in one shape: for the live world, for a device emulated alone, for a log played
//! back and for the look at what a machine has.
//!
//! | port | media | what crosses it |
//! |---|---|---|
//! | [`BytePort`] | a pty that is made here, a serial port | serial bytes |
//! | [`FramePort`] | SocketCAN; slcan, as the adapter's user and as the adapter on a pty | CAN frames |
//!
//! All of them keep to the same rules:
//! * `receive` waits and may be called off without losing anything. It is what notices that a port is
//!   gone ([`PortLost`]); `reopen` then waits for it to come back.
//! * `send` never waits. What finds no room is lost, as in a UART or a controller that nobody empties,
//!   and is counted.
//! * Nothing is lost silently where the system tells of it: [`Counters`].
//!
//! [`spec`]: how a port is named. [`pty`], [`serial`], [`can_socket`]: the media. [`unix_socket`]: where requests come from, not traffic.

mod any;
mod backoff;
mod bytes;
pub mod can_socket;
mod counters;
mod error;
mod frames;
pub mod pty;
pub mod serial;
pub mod slcan;
pub mod spec;
pub mod unix_socket;
mod watch;

pub use any::AnyPort;
pub use bytes::{ByteEvent, BytePort};
pub use counters::Counters;
pub use error::{PortError, PortLost};
pub use frames::{FrameEvent, FramePort};
pub use spec::PortSpec;
pub use watch::watch;
