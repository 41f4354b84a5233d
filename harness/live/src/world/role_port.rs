//! A port that plays a role in a run: it may be lost and come back, and tells of both.

use ports::pty::PtyPort;
use ports::{
    AnyPort, ByteEvent, BytePort, Counters, FrameEvent, FramePort, PortError, PortLost, PortSpec,
};
use wire::can::{BitRates, CanFrame};
use wire::can_error::CanErrorEvent;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::Timestamp;

/// What a port of a run tells.
#[derive(Debug)]
pub enum PortEvent {
    /// Bytes of a serial line.
    Bytes(Packet),
    /// The line was held low.
    Break,
    /// A frame of a bus.
    Frame(CanFrame),
    /// What a controller says of the bus.
    Bus(CanErrorEvent),
    /// The interface was taken down.
    Down,
    /// It is up again.
    Up,
    /// The other side has opened the bus of the adapter that is played here.
    Opened,
    /// It has closed it.
    Closed,
    /// The port is gone; it is waited for.
    Lost(PortLost),
    /// It is back.
    Back,
    /// It stayed away; it is waited for again.
    Away(PortError),
}

/// What crosses a role's port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traffic {
    /// Bytes, usually at these settings.
    Bytes(SerialSettings),
    /// Frames, on a bus that is meant to have these rates.
    Frames(BitRates),
}

/// A port and its name.
#[derive(Debug)]
pub struct RolePort {
    name: String,
    medium: AnyPort,
    /// It is gone, and was told to be.
    lost: bool,
}

impl RolePort {
    /// Opens the port.
    ///
    /// # Errors
    ///
    /// When it cannot be opened, or carries something else.
    pub(super) async fn open(spec: &PortSpec, traffic: Traffic) -> Result<Self, PortError> {
        let medium = match traffic {
            Traffic::Bytes(usual) => {
                let mut port = BytePort::open(spec, usual)?;
                if let BytePort::Pty(pty) = &mut port {
                    // Who opens the far side and sets no rate has the right one, as the rate of a pty is
                    // looked at.
                    pty.pty().set_baud(usual.baud)?;
                }
                AnyPort::Bytes(Box::new(port))
            }
            Traffic::Frames(rates) => AnyPort::Frames(FramePort::open(spec, rates).await?),
        };
        Ok(Self { name: spec.to_string(), medium, lost: false })
    }

    /// As a bench file names it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the other side opens; `None` where it is a device.
    pub fn far_path(&self) -> Option<&str> {
        self.medium.far_path()
    }

    pub(super) fn counters(&self) -> Counters {
        self.medium.counters()
    }

    /// The rate that the other side of a pty has set; `None` where that is not known.
    pub(super) fn far_baud(&mut self) -> Option<u32> {
        match &mut self.medium {
            AnyPort::Bytes(port) => match &mut **port {
                BytePort::Pty(port) => PtyPort::pty(port).baud().ok(),
                BytePort::Serial(_) => None,
            },
            AnyPort::Frames(_) => None,
        }
    }

    /// Waits for what comes next; while the port is gone, for it to come back. May be called off without
    /// losing anything.
    pub(super) async fn next(&mut self) -> PortEvent {
        if self.lost {
            return match self.medium.reopen().await {
                Ok(()) => {
                    self.lost = false;
                    PortEvent::Back
                }
                Err(error) => PortEvent::Away(error),
            };
        }
        let heard = match &mut self.medium {
            AnyPort::Bytes(port) => port.receive().await.map(PortEvent::from),
            AnyPort::Frames(port) => {
                let played_here = matches!(port, FramePort::SlcanAdapter(_));
                port.receive().await.map(|event| match event {
                    FrameEvent::Frame(frame) => PortEvent::Frame(frame),
                    FrameEvent::Bus(event) => PortEvent::Bus(event),
                    FrameEvent::Up if played_here => PortEvent::Opened,
                    FrameEvent::Up => PortEvent::Up,
                    FrameEvent::Down if played_here => PortEvent::Closed,
                    FrameEvent::Down => PortEvent::Down,
                })
            }
        };
        heard.unwrap_or_else(|lost| {
            self.lost = true;
            PortEvent::Lost(lost)
        })
    }

    /// Puts bytes on the line at once; what finds no room is counted.
    pub(super) fn send_bytes(&mut self, bytes: &[u8]) {
        if let AnyPort::Bytes(port) = &mut self.medium {
            port.send(bytes);
        }
    }

    /// Puts a frame on the bus at once; what finds no room is counted.
    pub(super) fn send_frame(&mut self, now: Timestamp, frame: &CanFrame) {
        if let AnyPort::Frames(port) = &mut self.medium {
            port.send(now, frame);
        }
    }
}

impl From<ByteEvent> for PortEvent {
    fn from(event: ByteEvent) -> Self {
        match event {
            ByteEvent::Bytes(packet) => Self::Bytes(packet),
            ByteEvent::Break => Self::Break,
        }
    }
}

/// The next event of a port; without one, never.
pub(super) async fn next(port: Option<&mut RolePort>) -> PortEvent {
    match port {
        Some(port) => port.next().await,
        None => std::future::pending().await,
    }
}
