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

#[cfg(test)]
mod tests {
    use super::{ByteEvent, BytePort};
    use crate::{FramePort, PortError, PortSpec};
    use std::time::Duration;
    use wire::can::BitRates;
    use wire::serial::SerialSettings;

    const USUAL: SerialSettings = SerialSettings::new_8n1(9_600);

    fn run<T>(test: impl Future<Output = T>) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            tokio::time::timeout(Duration::from_secs(20), test).await.expect("the test ends")
        })
    }

    fn spec(text: &str) -> PortSpec {
        text.parse().unwrap()
    }

    #[test]
    fn a_pty_and_who_opens_its_far_side_are_two_ports() {
        run(async {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("gyro.pty").to_string_lossy().into_owned();
            let mut here = BytePort::open(&spec(&format!("pty:{path}")), USUAL).unwrap();
            assert_eq!(here.far_path(), Some(path.as_str()));
            let mut there = BytePort::open(&spec(&format!("serial:{path}")), USUAL).unwrap();
            assert_eq!(there.far_path(), None);
            for (from, to) in [(0, 1), (1, 0)] {
                let ports = [&mut here, &mut there];
                assert_eq!(ports[from].send(b"hello"), 5);
                let Ok(ByteEvent::Bytes(heard)) = ports[to].receive().await else {
                    panic!("bytes")
                };
                assert_eq!(heard.as_slice(), b"hello");
            }
            for counters in [here.counters(), there.counters()] {
                assert_eq!((counters.bytes_in, counters.bytes_out), (5, 5));
                assert!(counters.all_crossed());
            }
            assert!(here.begin_break().is_err() && there.begin_break().is_ok());
            assert!(here.reopen().await.is_ok());
            drop(here);
            assert!(there.receive().await.is_err());
        });
    }

    #[test]
    fn bytes_and_frames_are_not_mixed_up() {
        run(async {
            for text in ["can:can0", "slcan:/dev/ttyACM0", "slcan-pty"] {
                let error = BytePort::open(&spec(text), USUAL).unwrap_err();
                assert!(matches!(error, PortError::WrongKind { .. }), "{text}: {error}");
            }
            for text in ["pty", "/dev/ttyUSB0"] {
                let error = FramePort::open(&spec(text), BitRates::USUAL).await.unwrap_err();
                assert!(matches!(error, PortError::WrongKind { .. }), "{text}: {error}");
            }
        });
    }
}
