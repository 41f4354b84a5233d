//! A port for CAN frames.

use super::can_socket::{CanSocketPort, Interface};
use super::error::{PortError, PortLost};
use super::slcan::{SlcanAdapter, SlcanHost};
use super::spec::PortSpec;
use super::{Counters, FrameEvent};
use wire::can::{BitRates, CanFrame};
use wire::slcan::BitRate;
use wire::time::Timestamp;

#[derive(Debug)]
pub enum FramePort {
    Can(Box<CanSocketPort>),
    /// Uses an adapter.
    SlcanHost(Box<SlcanHost>),
    /// Emulates an adapter.
    SlcanAdapter(Box<SlcanAdapter>),
}

impl FramePort {
    /// Opens the port of a bus with these rates. An adapter gets the nominal rate unless `spec` has another; an
    /// interface of the kernel keeps its own (`ip link`). Must be called within a tokio runtime with IO and time
    /// enabled.
    ///
    /// # Errors
    /// If the port cannot be opened, or carries bytes; or if CAN FD frames are required and the port carries only
    /// classic ones.
    pub async fn open(spec: &PortSpec, rates: BitRates) -> Result<Self, PortError> {
        let wrong = |wanted, known| PortError::WrongKind { spec: spec.to_string(), wanted, known };
        let is_fd = rates.data.is_some();
        match spec {
            PortSpec::Can { interface } => {
                let port = CanSocketPort::open(interface)?;
                if is_fd && !Interface::new(interface).takes_fd() {
                    return Err(wrong("CAN FD frames", "can:INTERFACE, set up with `fd on`"));
                }
                Ok(Self::Can(Box::new(port)))
            }
            PortSpec::Slcan { .. } | PortSpec::SlcanPty { .. } if is_fd => {
                Err(wrong("CAN FD frames", "can:INTERFACE, set up with `fd on`"))
            }
            PortSpec::Slcan { serial, bitrate } => {
                let usual = BitRate::from_bits_per_second(rates.nominal);
                let bitrate = bitrate.or(usual).ok_or_else(|| PortError::NoBitRate {
                    port: serial.device.to_string(),
                    bit_rate: rates.nominal,
                })?;
                Ok(Self::SlcanHost(Box::new(SlcanHost::open(serial, bitrate).await?)))
            }
            PortSpec::SlcanPty { link } => {
                Ok(Self::SlcanAdapter(Box::new(SlcanAdapter::open(link.as_deref())?)))
            }
            PortSpec::Pty { .. } | PortSpec::Serial(_) => {
                Err(wrong("CAN frames", "can:INTERFACE, slcan:/dev/..., slcan-pty"))
            }
        }
    }

    /// Waits for the next event. May be cancelled without loss.
    ///
    /// # Errors
    /// If the port is gone; on every call until it was reopened.
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        match self {
            Self::Can(port) => port.receive().await,
            Self::SlcanHost(port) => port.receive().await,
            Self::SlcanAdapter(port) => port.receive().await,
        }
    }

    /// Sends a frame at once; without room it is lost and counted. An emulated adapter adds the timestamp `now` if the
    /// other side requests timestamps.
    pub fn send(&mut self, now: Timestamp, frame: &CanFrame) {
        match self {
            Self::Can(port) => port.send(frame),
            Self::SlcanHost(port) => port.send(frame),
            Self::SlcanAdapter(port) => port.send(now, frame),
        }
    }

    /// Waits for the return of a lost port. May be cancelled, and called again. An emulated adapter is never lost.
    ///
    /// # Errors
    /// If the port stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Can(port) => port.reopen().await,
            Self::SlcanHost(port) => port.reopen().await,
            Self::SlcanAdapter(_) => Ok(()),
        }
    }

    /// Path for the other side to open: an interface or a pty. `None` if that is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Can(port) => Some(port.interface()),
            Self::SlcanHost(_) => None,
            Self::SlcanAdapter(port) => Some(port.far_path()),
        }
    }

    pub fn counters(&self) -> Counters {
        match self {
            Self::Can(port) => port.counters(),
            Self::SlcanHost(port) => port.counters(),
            Self::SlcanAdapter(port) => port.counters(),
        }
    }
}
