//! Why lines cannot go through the kernel.

use ports::PortError;
use ports::pty::PtyError;
use rig::crossing::CrossingFailure;
use std::sync::Arc;

/// Interface for the frames of the first CAN bus.
pub const VCAN_INTERFACE: &str = "vcan0";

/// Why the lines cannot go through the kernel.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum KernelError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Pty(#[from] PtyError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error("failed to find a bus for {line}: it is on CAN, and a pty carries bytes")]
    #[diagnostic(help(
        "--bus slcan carries its frames across a pty as lines, --bus vcan across {VCAN_INTERFACE}"
    ))]
    NoFrames { line: Arc<str> },
    #[error(
        "failed to find a carrier for {line}: it is a CAN FD bus, and SLCAN carries classic frames"
    )]
    #[diagnostic(help("--bus vcan carries its frames across an interface of the kernel"))]
    NoFd { line: Arc<str> },
    #[error(transparent)]
    Crossing(#[from] CrossingFailure),
}
