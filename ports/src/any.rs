//! A port of either kind, for code that serves a device on any of them.

use super::{BytePort, Counters, FramePort, PortError};

#[derive(Debug)]
pub enum AnyPort {
    /// Boxed, because it is larger than the other variant.
    Bytes(Box<BytePort>),
    Frames(FramePort),
}

impl AnyPort {
    /// Path for the other side to open; `None` if that is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Bytes(port) => port.far_path(),
            Self::Frames(port) => port.far_path(),
        }
    }

    /// Waits for the return of a lost port. May be cancelled.
    ///
    /// # Errors
    /// If the port stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Bytes(port) => port.reopen().await,
            Self::Frames(port) => port.reopen().await,
        }
    }

    pub fn counters(&self) -> Counters {
        match self {
            Self::Bytes(port) => port.counters(),
            Self::Frames(port) => port.counters(),
        }
    }
}
