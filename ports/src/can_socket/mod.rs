//! A CAN interface of the kernel (SocketCAN, `Documentation/networking/can.rst`).
//!
//! Error frames are received ([`FrameEvent::Bus`]), and CAN FD frames too if the interface has them. Frames sent here
//! are not received back; other programs on this machine receive them. When the interface goes down, the port reports
//! this, waits until it is up again and reports that too; when the interface is deleted the port is lost.
//!
//! Frames that arrive between calls of `receive` wait in the socket. If its buffer is full, or the kernel's queue before
//! it, the kernel drops and counts them ([`Counters::receive_dropped_frames`]).

mod frame;
mod interface;
#[cfg(test)]
mod tests;

pub use interface::{Interface, InterfaceState, kernel_has_can};

use super::attempts::Attempts;
use super::error::{PortError, PortLost};
use super::watch::watch;
use super::{Counters, FrameEvent};
pub use frame::{Heard, from_socket, to_socket};
use rustix::io::Errno;
use rustix::net::sockopt::{set_socket_recv_buffer_size, set_socket_recv_buffer_size_force};
use socketcan::{CanFdSocket, CanRawFrame, Socket as _, SocketOptions as _};
use std::io;
use std::time::Duration;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::time::{Interval, MissedTickBehavior, interval};
use wire::can::CanFrame;

/// Requested receive buffer, bytes. The kernel doubles it and charges about 800 bytes per frame: room for about
/// 10,000, which take half a second on a bus at 1 Mbit/s.
const RECEIVE_BUFFER: usize = 4 << 20;
/// Time between two checks whether an interface is up again; the socket does not report it.
const LOOK_PERIOD: Duration = Duration::from_millis(50);
/// Number of values returned by `SO_MEMINFO` (`SK_MEMINFO_VARS` of `linux/sock_diag.h`).
const MEMINFO_VARS: usize = 9;

#[derive(Debug)]
pub struct CanSocketPort {
    interface: Interface,
    link: Result<AsyncFd<CanFdSocket>, PortLost>,
    /// While the interface is down: the timer of the checks.
    look: Option<Interval>,
    /// An event that must follow the one just returned.
    next: Option<FrameEvent>,
    attempts: Attempts,
    counters: Counters,
    /// Frames that the interface had dropped before this socket was opened.
    dropped_before: u64,
}

impl CanSocketPort {
    /// Opens the interface of this name. Must be called within a tokio runtime with IO and time enabled.
    ///
    /// # Errors
    /// If the kernel has no CAN, or the interface is missing or down.
    pub fn open(interface: &str) -> Result<Self, PortError> {
        let interface = Interface::new(interface);
        let dropped_before = interface.dropped();
        let link = Ok(open(&interface)?);
        let (attempts, counters) = (Attempts::default(), Counters::default());
        Ok(Self { interface, link, look: None, next: None, attempts, counters, dropped_before })
    }

    pub fn interface(&self) -> &str {
        self.interface.name()
    }

    /// Waits for the next event. May be cancelled without loss.
    ///
    /// # Errors
    /// If the interface was deleted; on every call until it was [reopened](Self::reopen).
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        loop {
            if let Some(event) = self.next.take() {
                return Ok(event);
            }
            let socket = self.link.as_ref().map_err(|lost| *lost)?;
            let heard = tokio::select! {
                biased;
                heard = read(socket) => heard,
                () = tick(self.look.as_mut()) => {
                    if self.interface.state() == InterfaceState::Down {
                        continue;
                    }
                    return Ok(self.up());
                }
            };
            let event = match heard {
                Ok(frame) => self.take(&frame),
                Err(cause) => match Errno::from_io_error(&cause) {
                    Some(Errno::NETDOWN) => self.down(),
                    Some(Errno::NODEV) => return Err(self.lose(PortLost::Deleted)),
                    // A length that neither a classic nor an FD frame has.
                    None if cause.kind() == io::ErrorKind::InvalidData => {
                        self.counters.unsupported_frames += 1;
                        None
                    }
                    _ => return Err(self.lose(PortLost::Other(cause.kind()))),
                },
            };
            let Some(event) = event else { continue };
            // A frame arrived before the next check: the interface is up, which is reported first.
            if matches!(event, FrameEvent::Frame(_)) && self.look.is_some() {
                self.next = Some(event);
                return Ok(self.up());
            }
            return Ok(event);
        }
    }

    fn take(&mut self, frame: &CanRawFrame) -> Option<FrameEvent> {
        self.counters.fd_frames += u64::from(matches!(frame, CanRawFrame::Fd(_)));
        match from_socket(frame) {
            Heard::Frame(frame) => {
                self.counters.frames_in += 1;
                Some(FrameEvent::Frame(frame))
            }
            Heard::Error(event) => {
                self.counters.error_frames += 1;
                Some(FrameEvent::Bus(event))
            }
            Heard::Unsupported => {
                self.counters.unsupported_frames += 1;
                None
            }
        }
    }

    /// `None` if that is already known.
    fn down(&mut self) -> Option<FrameEvent> {
        if self.look.is_some() {
            return None;
        }
        let mut look = interval(LOOK_PERIOD);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        self.look = Some(look);
        Some(FrameEvent::Down)
    }

    fn up(&mut self) -> FrameEvent {
        self.look = None;
        self.counters.returns += 1;
        FrameEvent::Up
    }

    fn lose(&mut self, lost: PortLost) -> PortLost {
        // The count disappears with the socket.
        self.counters = self.counters();
        self.link = Err(lost);
        self.look = None;
        lost
    }

    /// Sends a frame to the interface at once. Frames without room are lost and counted.
    pub fn send(&mut self, frame: &CanFrame) {
        let sent = match (&self.link, to_socket(frame)) {
            (Ok(socket), Some(frame)) => socket.get_ref().write_frame(&frame).is_ok(),
            _ => false,
        };
        if sent {
            self.counters.frames_out += 1;
        } else {
            self.counters.overrun_frames += 1;
        }
    }

    /// Closes the socket and opens it again, twenty times a second until the interface exists and is up. May be
    /// cancelled, and called again.
    ///
    /// # Errors
    /// If the interface stayed away for too long; the next call waits as long again.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        if self.link.is_ok() {
            self.lose(PortLost::Deleted);
        }
        let open = || Ok((self.interface.dropped(), open(&self.interface)?));
        let given_up = |last| PortError::given_up(self.interface.name(), last);
        let (dropped, socket) = self.attempts.reopen(open).await.map_err(given_up)?;
        (self.dropped_before, self.link) = (dropped, Ok(socket));
        self.counters.returns += 1;
        Ok(())
    }

    pub fn counters(&self) -> Counters {
        let dropped = match &self.link {
            Ok(socket) => {
                let by_interface = self.interface.dropped().saturating_sub(self.dropped_before);
                dropped(socket.get_ref()).saturating_add(by_interface)
            }
            Err(_) => 0,
        };
        let before = self.counters.receive_dropped_frames;
        Counters { receive_dropped_frames: before.saturating_add(dropped), ..self.counters }
    }
}

fn open(interface: &Interface) -> Result<AsyncFd<CanFdSocket>, PortError> {
    let failed = |source| {
        let interface = interface.name().to_owned();
        PortError::Can { step: "watch", interface, source }
    };
    // An interface going down is only an error, not readable data.
    watch(connect(interface)?, Interest::READABLE | Interest::ERROR).map_err(failed)
}

/// A socket on the interface that never blocks, without an event loop.
///
/// # Errors
/// When the kernel has no CAN, or there is no such interface, or it is down.
pub fn connect(interface: &Interface) -> Result<CanFdSocket, PortError> {
    interface.require_up()?;
    let name = || interface.name().to_owned();
    let failed = |step| move |source| PortError::Can { step, interface: name(), source };
    let socket = CanFdSocket::open(interface.name()).map_err(failed("open"))?;
    socket.set_nonblocking(true).map_err(failed("set up"))?;
    socket.set_error_filter_accept_all().map_err(failed("hear the errors of"))?;
    socket.set_recv_own_msgs(false).map_err(failed("set up"))?;
    // Without the right to exceed the machine's limit (`net.core.rmem_max`), use that limit.
    if set_socket_recv_buffer_size_force(&socket, RECEIVE_BUFFER).is_err() {
        set_socket_recv_buffer_size(&socket, RECEIVE_BUFFER)
            .map_err(|cause| failed("set the receive buffer of")(cause.into()))?;
    }
    Ok(socket)
}

async fn read(socket: &AsyncFd<CanFdSocket>) -> io::Result<CanRawFrame> {
    socket.async_io(Interest::READABLE | Interest::ERROR, CanFdSocket::read_raw_frame).await
}

/// Waits for the next check; forever if there is no timer.
async fn tick(look: Option<&mut Interval>) {
    match look {
        Some(look) => _ = look.tick().await,
        None => std::future::pending().await,
    }
}

/// Frames that the receive queue of this socket dropped. Read from the socket, because the mark on received frames
/// (`SO_RXQ_OVFL`) misses losses after the last frame.
fn dropped(socket: &CanFdSocket) -> u64 {
    let mut answer = [0; MEMINFO_VARS * size_of::<u32>()];
    let count = socket
        .get_socket_option_bytes(libc::SOL_SOCKET, libc::SO_MEMINFO, &mut answer)
        .unwrap_or(0);
    let place = libc::SK_MEMINFO_DROPS as usize;
    let (vars, _) = answer.get(..count).unwrap_or_default().as_chunks();
    vars.get(place).map_or(0, |var| u32::from_ne_bytes(*var).into())
}
