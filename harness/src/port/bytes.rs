//! A port that serial bytes cross.

use super::Counters;
use super::error::{PortError, PortLost};
use super::pty::PtyPort;
use super::serial::{SerialEvent, SerialPort};
use super::spec::PortSpec;
use std::io;
use wire::serial::SerialSettings;

/// A port for bytes.
#[derive(Debug)]
pub enum BytePort {
    /// A pty whose far side another program opens.
    Pty(PtyPort),
    /// A serial port.
    Serial(SerialPort),
}

/// What a port for bytes tells.
pub type ByteEvent = SerialEvent;

impl BytePort {
    /// Opens the port. What `spec` does not say of a serial port is set as is `usual`; a pty paces
    /// nothing and takes no settings. Called within a tokio runtime that has IO enabled.
    ///
    /// # Errors
    /// When it cannot be opened, or carries frames.
    pub fn open(spec: &PortSpec, usual: SerialSettings) -> Result<Self, PortError> {
        match spec {
            PortSpec::Pty { link } => PtyPort::open(link.as_deref()).map(Self::Pty),
            PortSpec::Serial(serial) => SerialPort::open(serial, usual).map(Self::Serial),
            PortSpec::Can { .. } | PortSpec::Slcan { .. } | PortSpec::SlcanPty { .. } => {
                Err(PortError::WrongKind {
                    spec: spec.to_string(),
                    wanted: "serial bytes",
                    known: "pty, serial:/dev/..., serial:usb:VENDOR:PRODUCT",
                })
            }
        }
    }

    /// Waits for what comes next. May be called off without losing anything.
    ///
    /// # Errors
    /// When the port is gone; again and again until it was reopened.
    pub async fn receive(&mut self) -> Result<ByteEvent, PortLost> {
        match self {
            Self::Pty(port) => port.receive().await.map(ByteEvent::Bytes),
            Self::Serial(port) => port.receive().await,
        }
    }

    /// Hands bytes to the port at once, and says how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        match self {
            Self::Pty(port) => port.send(bytes),
            Self::Serial(port) => port.send(bytes),
        }
    }

    /// Holds the line low, until [`end_break`](Self::end_break).
    ///
    /// # Errors
    /// A pty carries no break; otherwise when the port is gone or its driver cannot do it.
    pub fn begin_break(&mut self) -> io::Result<()> {
        match self {
            Self::Pty(_) => Err(io::ErrorKind::Unsupported.into()),
            Self::Serial(port) => port.begin_break(),
        }
    }

    /// The end of a break.
    ///
    /// # Errors
    /// As with its beginning.
    pub fn end_break(&mut self) -> io::Result<()> {
        match self {
            Self::Pty(_) => Err(io::ErrorKind::Unsupported.into()),
            Self::Serial(port) => port.end_break(),
        }
    }

    /// Waits until a port that was lost is back. May be called off, and called again. A pty is ours and
    /// never away.
    ///
    /// # Errors
    /// When it stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Pty(_) => Ok(()),
            Self::Serial(port) => port.reopen().await,
        }
    }

    /// What the other side opens; `None` where it is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Pty(port) => Some(port.far_path()),
            Self::Serial(_) => None,
        }
    }

    /// What has crossed it.
    pub const fn counters(&self) -> Counters {
        match self {
            Self::Pty(port) => port.counters(),
            Self::Serial(port) => port.counters(),
        }
    }
}
