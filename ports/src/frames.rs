//! A port that CAN frames cross.

use super::Counters;
use super::can_socket::{CanSocketPort, Interface};
use super::error::{PortError, PortLost};
use super::slcan::{SlcanAdapter, SlcanHost};
use super::spec::PortSpec;
use std::io;
use wire::can::{BitRates, CanFrame};
use wire::can_error::CanErrorEvent;
use wire::slcan::BitRate;
use wire::time::Timestamp;

/// A port for frames.
#[derive(Debug)]
pub enum FramePort {
    /// An interface of the kernel.
    Can(Box<CanSocketPort>),
    /// An adapter that is used from here.
    SlcanHost(Box<SlcanHost>),
    /// An adapter that is played here.
    SlcanAdapter(Box<SlcanAdapter>),
}

/// What a port for frames tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameEvent {
    /// A frame from the bus.
    Frame(CanFrame),
    /// What the controller says of the bus: an error frame.
    Bus(CanErrorEvent),
    /// The interface was taken down, or the other side has closed the bus of the adapter played here.
    Down,
    /// It is up again, or the other side has opened the bus.
    Up,
}

impl FramePort {
    /// Opens the port of a bus of these rates. An adapter gets the nominal one where `spec` says no other; an
    /// interface of the kernel runs at what it was set to (`ip link`). Called within a tokio runtime that
    /// has IO and time enabled.
    ///
    /// # Errors
    /// When it cannot be opened, or carries bytes; when there are to be CAN FD frames, and the port carries classic ones alone.
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

    /// Waits for what comes next. May be called off without losing anything.
    ///
    /// # Errors
    /// When the port is gone; again and again until it was reopened.
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        match self {
            Self::Can(port) => port.receive().await,
            Self::SlcanHost(port) => port.receive().await,
            Self::SlcanAdapter(port) => port.receive().await,
        }
    }

    /// Hands a frame to the port at once; what finds no room is lost and counted. An adapter played here
    /// stamps it with `now` where the other side wants that.
    pub fn send(&mut self, now: Timestamp, frame: &CanFrame) {
        match self {
            Self::Can(port) => port.send(frame),
            Self::SlcanHost(port) => port.send(frame),
            Self::SlcanAdapter(port) => port.send(now, frame),
        }
    }

    /// Tells the other side of an error on the bus, as if the bus were real.
    ///
    /// # Errors
    /// Where the bus is real, and its errors are not ours to make up (`Unsupported`); else what the system
    /// reports.
    pub fn report(&mut self, event: &CanErrorEvent) -> io::Result<()> {
        match self {
            Self::Can(port) => port.report(event),
            Self::SlcanHost(_) => Err(io::ErrorKind::Unsupported.into()),
            Self::SlcanAdapter(port) => {
                port.report(event);
                Ok(())
            }
        }
    }

    /// Waits until a port that was lost is back. May be called off, and called again. An adapter played
    /// here is never away.
    ///
    /// # Errors
    /// When it stayed away for too long.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        match self {
            Self::Can(port) => port.reopen().await,
            Self::SlcanHost(port) => port.reopen().await,
            Self::SlcanAdapter(_) => Ok(()),
        }
    }

    /// What the other side opens: an interface or a pty. `None` where it is a device.
    pub fn far_path(&self) -> Option<&str> {
        match self {
            Self::Can(port) => Some(port.interface()),
            Self::SlcanHost(_) => None,
            Self::SlcanAdapter(port) => Some(port.far_path()),
        }
    }

    /// What has crossed it.
    pub fn counters(&self) -> Counters {
        match self {
            Self::Can(port) => port.counters(),
            Self::SlcanHost(port) => port.counters(),
            Self::SlcanAdapter(port) => port.counters(),
        }
    }
}
