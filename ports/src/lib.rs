//! The ports of a bench behind one interface: for the live world, for a single emulated device, for playing back a log
//! and for inspecting a machine.
//!
//! | port | media | traffic |
//! |---|---|---|
//! | [`BytePort`] | a pty that is created here, a serial port | serial bytes |
//! | [`FramePort`] | SocketCAN; slcan, as user of an adapter and as an adapter on a pty | CAN frames |
//!
//! All ports follow the same rules:
//! * `receive` waits and may be cancelled without loss. It detects that a port is gone ([`PortLost`]); `reopen` then
//!   waits for its return.
//! * `send` never waits. Data without room is lost, as in a UART or a controller whose buffer is full, and is counted.
//! * Every loss that the system reports is counted: [`Counters`].
//!
//! [`spec`]: names of ports. [`pty`], [`serial`], [`can_socket`]: the media. [`unix_socket`]: a source of requests,
//! not of traffic.

#![allow(missing_docs, reason = "a crate of this workspace, which `harness` does not export")]

mod any;
mod attempts;
mod bytes;
pub mod can_socket;
mod counters;
mod error;
mod frame_event;
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
pub use frame_event::FrameEvent;
pub use frames::FramePort;
pub use spec::PortSpec;
pub use watch::watch;
