//! A port of either kind, for who serves a device without minding which.

use super::{BytePort, Counters, FramePort, PortError};

/// Bytes or frames cross it.
#[derive(Debug)]
pub enum AnyPort {
    /// Boxed: it keeps more than the other.
    Bytes(Box<BytePort>),
    /// Frames of a bus.
    Frames(FramePort),
}

impl AnyPort {
    /// What the other side opens; `None` where it is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Bytes(port) => port.far_path(),
            Self::Frames(port) => port.far_path(),
        }
    }

    /// Waits for a port that is gone to come back. May be called off.
    ///
    /// # Errors
    /// When it stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Bytes(port) => port.reopen().await,
            Self::Frames(port) => port.reopen().await,
        }
    }

    /// What has crossed it, and what was lost.
    pub fn counters(&self) -> Counters {
        match self {
            Self::Bytes(port) => port.counters(),
            Self::Frames(port) => port.counters(),
        }
    }
}
