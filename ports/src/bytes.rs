//! A port for serial bytes.

use super::Counters;
use super::error::{PortError, PortLost};
use super::pty::PtyPort;
use super::serial::{SerialEvent, SerialPort};
use super::spec::PortSpec;
use wire::serial::SerialSettings;

#[derive(Debug)]
pub enum BytePort {
    /// A pty whose other side another program opens.
    Pty(PtyPort),
    Serial(SerialPort),
}

pub type ByteEvent = SerialEvent;

impl BytePort {
    /// Opens the port. Settings of a serial port missing in `spec` are taken from `usual`; a pty has no pacing and no
    /// settings. Must be called within a tokio runtime with IO enabled.
    ///
    /// # Errors
    /// If it cannot be opened, or carries frames.
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

    /// Waits for the next event. May be cancelled without loss.
    ///
    /// # Errors
    /// If the port is gone; on every call until it was reopened.
    pub async fn receive(&mut self) -> Result<ByteEvent, PortLost> {
        match self {
            Self::Pty(port) => port.receive().await.map(ByteEvent::Bytes),
            Self::Serial(port) => port.receive().await,
        }
    }

    /// Sends bytes at once, and returns how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        match self {
            Self::Pty(port) => port.send(bytes),
            Self::Serial(port) => port.send(bytes),
        }
    }

    /// Waits for the return of a lost port. May be cancelled, and called again. A pty is created here and never lost.
    ///
    /// # Errors
    /// If the port stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Pty(_) => Ok(()),
            Self::Serial(port) => port.reopen().await,
        }
    }

    /// Path for the other side to open; `None` if that is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Pty(port) => Some(port.far_path()),
            Self::Serial(_) => None,
        }
    }

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
