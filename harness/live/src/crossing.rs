//! Virtual time through the kernel: what arrives is what was read from a pty or a CAN socket after it was written to
//! the other side. Nothing waits, and a lap takes as long as its system calls.

mod can_wire;
mod error;
mod kernel;
mod pty_wire;
mod slcan_wire;
#[cfg(test)]
mod tests;
mod wait;

pub use error::{KernelError, VCAN_INTERFACE};
pub use kernel::Kernel;
