//! A port that plays a role in a run: it may be lost and come back, and reports both.

use ports::pty::PtyPort;
use ports::{
    AnyPort, ByteEvent, BytePort, Counters, FrameEvent, FramePort, PortError, PortLost, PortSpec,
};
use record::figures;
use wire::can::{BitRates, CanFrame};
use wire::can_error::CanErrorEvent;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::Timestamp;

#[derive(Debug)]
pub enum PortEvent {
    Bytes(Packet),
    /// The line was held low.
    Break,
    Frame(CanFrame),
    /// An error event of the CAN controller.
    Bus(CanErrorEvent),
    Down,
    Up,
    /// The far side has opened the bus of the emulated adapter.
    Opened,
    Closed,
    /// The port is gone; its return is awaited.
    Lost(PortLost),
    Back,
    /// The port stayed away; its return is awaited again.
    Away(PortError),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traffic {
    /// Bytes, usually at these settings.
    Bytes(SerialSettings),
    /// Frames, on a bus that should have these rates.
    Frames(BitRates),
}

/// What leads to the other side of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Link {
    /// A pty that was made here.
    Pty,
    /// An adapter that is emulated here, on a pty that was made here.
    EmulatedAdapter,
    Serial,
    /// An interface of the kernel.
    Interface,
    Adapter,
}

impl Link {
    /// Bytes or frames that were to be sent and found no room. At an emulated adapter nobody may be on the bus, and
    /// nothing is lost.
    pub(super) const fn unsent(self, counters: &Counters) -> u64 {
        match self {
            Self::Pty | Self::Serial => counters.overrun_bytes,
            Self::Interface | Self::Adapter => counters.overrun_frames,
            Self::EmulatedAdapter => 0,
        }
    }

    pub(super) fn counted(self, count: u64) -> String {
        match self {
            Self::Pty | Self::Serial => figures::counted(count, "byte", "bytes"),
            _ => figures::counted(count, "frame", "frames"),
        }
    }
}

#[derive(Debug)]
pub struct RolePort {
    name: String,
    medium: AnyPort,
    /// The port is gone, and that was reported.
    lost: bool,
}

impl RolePort {
    /// Opens the port.
    ///
    /// # Errors
    /// When it cannot be opened, or carries another kind of traffic.
    pub(super) async fn open(spec: &PortSpec, traffic: Traffic) -> Result<Self, PortError> {
        let medium = match traffic {
            Traffic::Bytes(usual) => {
                let mut port = BytePort::open(spec, usual)?;
                if let BytePort::Pty(pty) = &mut port {
                    // A program that opens the far side and sets no rate counts as right: the rate of a pty is only
                    // checked.
                    pty.pty().set_baud(usual.baud)?;
                }
                AnyPort::Bytes(Box::new(port))
            }
            Traffic::Frames(rates) => AnyPort::Frames(FramePort::open(spec, rates).await?),
        };
        Ok(Self { name: spec.to_string(), medium, lost: false })
    }

    /// Name in a bench file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Path that the other side opens; `None` if that is a device.
    pub fn far_path(&self) -> Option<&str> {
        self.medium.far_path()
    }

    /// Path of a pty whose other side nobody has opened.
    pub(super) fn unopened(&self) -> Option<&str> {
        let was_opened = match &self.medium {
            AnyPort::Bytes(port) => match &**port {
                BytePort::Pty(port) => port.was_opened(),
                BytePort::Serial(_) => true,
            },
            AnyPort::Frames(FramePort::SlcanAdapter(port)) => port.was_opened(),
            AnyPort::Frames(_) => true,
        };
        self.far_path().filter(|_| !was_opened)
    }

    pub(super) fn link(&self) -> Link {
        match &self.medium {
            AnyPort::Bytes(port) => match &**port {
                BytePort::Pty(_) => Link::Pty,
                BytePort::Serial(_) => Link::Serial,
            },
            AnyPort::Frames(FramePort::Can(_)) => Link::Interface,
            AnyPort::Frames(FramePort::SlcanHost(_)) => Link::Adapter,
            AnyPort::Frames(FramePort::SlcanAdapter(_)) => Link::EmulatedAdapter,
        }
    }

    /// Bytes or frames that were to be sent and found no room.
    pub(super) fn unsent(&self) -> u64 {
        self.link().unsent(&self.counters())
    }

    pub(super) fn counters(&self) -> Counters {
        self.medium.counters()
    }

    /// Rate that the far side of a pty has set; `None` if unknown.
    pub(super) fn far_baud(&mut self) -> Option<u32> {
        match &mut self.medium {
            AnyPort::Bytes(port) => match &mut **port {
                BytePort::Pty(port) => PtyPort::pty(port).baud().ok(),
                BytePort::Serial(_) => None,
            },
            AnyPort::Frames(_) => None,
        }
    }

    /// Waits for the next event; while the port is gone, for its return. Cancel-safe.
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

    /// Sends bytes at once; counts what finds no room.
    pub(super) fn send_bytes(&mut self, bytes: &[u8]) {
        if let AnyPort::Bytes(port) = &mut self.medium {
            port.send(bytes);
        }
    }

    /// Sends a frame at once; counts it if it finds no room.
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

/// Waits for the next event of a port; without a port, forever.
pub(super) async fn next(port: Option<&mut RolePort>) -> PortEvent {
    match port {
        Some(port) => port.next().await,
        None => std::future::pending().await,
    }
}
