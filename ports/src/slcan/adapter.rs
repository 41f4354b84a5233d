//! An emulated adapter on a pty.

use super::{EVENTS_MAX, Lines};
use crate::error::{PortError, PortLost};
use crate::pty::PtyPort;
use crate::{Counters, FrameEvent};
use std::collections::VecDeque;
use std::path::Path;
use wire::can::CanFrame;
use wire::slcan::{Adapter, Channel, Identity, TransmitFull};
use wire::time::Timestamp;

/// An emulated adapter on a pty. This side is its bus: it receives the frames that the other side sends.
///
/// The other side opens and closes the bus, reported as [`FrameEvent::Up`] and [`FrameEvent::Down`]; it is closed at
/// first.
#[derive(Debug)]
pub struct SlcanAdapter {
    pty: PtyPort,
    adapter: Adapter,
    lines: Lines,
    /// Received from the other side and not passed on yet; at most [`EVENTS_MAX`].
    events: VecDeque<FrameEvent>,
    counters: Counters,
}

impl SlcanAdapter {
    /// An adapter on a new pty, optionally with a symbolic link to its other side. Must be called within a tokio
    /// runtime with IO enabled.
    ///
    /// # Errors
    /// If the system has no pty available, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, PortError> {
        Ok(Self {
            pty: PtyPort::open(link)?,
            adapter: Adapter::new(Identity::default()),
            lines: Lines::default(),
            events: VecDeque::with_capacity(EVENTS_MAX),
            counters: Counters::default(),
        })
    }

    pub fn far_path(&self) -> &str {
        self.pty.far_path()
    }

    /// Whether the other side has been opened, as far as the system tells.
    pub fn was_opened(&self) -> bool {
        self.pty.was_opened()
    }

    /// State of the bus, which the other side opens.
    pub const fn channel(&self) -> Channel {
        self.adapter.channel()
    }

    /// Waits for the next event, and answers the other side meanwhile. May be cancelled without loss.
    ///
    /// # Errors
    /// The system's error of the pty; a port closed on the other side is not an error.
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        self.lines.finish(|bytes| self.pty.send(bytes));
        loop {
            if let Some(event) = self.events.pop_front() {
                return Ok(event);
            }
            let packet = self.pty.receive().await?;
            // Byte by byte, so that opening and closing keep their order among the frames.
            for byte in packet.as_slice() {
                let before = self.adapter.channel();
                let (events, counters) = (&mut self.events, &mut self.counters);
                self.adapter.receive(std::slice::from_ref(byte), |frame| {
                    if events.len() >= EVENTS_MAX {
                        return Err(TransmitFull);
                    }
                    counters.frames_in += 1;
                    events.push_back(FrameEvent::Frame(frame));
                    Ok(())
                });
                match (before, self.adapter.channel()) {
                    (Channel::Closed, Channel::Open | Channel::ListenOnly) => {
                        self.events.push_back(FrameEvent::Up);
                    }
                    (Channel::Open | Channel::ListenOnly, Channel::Closed) => {
                        self.events.push_back(FrameEvent::Down);
                    }
                    _ => {}
                }
            }
            self.answer();
        }
    }

    /// Sends a frame to the other side at once. A frame without room, or on a closed bus, is lost and counted.
    pub fn send(&mut self, now: Timestamp, frame: &CanFrame) {
        let before = self.adapter.counters().frames_to_host;
        if frame.fd_flags().is_none() {
            self.adapter.receive_frame(now, *frame);
        }
        let queued = self.adapter.counters().frames_to_host > before;
        if self.answer() && queued {
            self.counters.frames_out += 1;
        } else {
            self.counters.overrun_frames += 1;
        }
    }

    /// Sends the waiting lines to the other side; `false` if the last of them found no room.
    fn answer(&mut self) -> bool {
        let mut sent = true;
        while let Some(line) = self.adapter.transmit() {
            sent = self.lines.send(line.as_slice(), |bytes| self.pty.send(bytes));
        }
        sent
    }

    /// Traffic and losses of the port, including the serial line.
    pub fn counters(&self) -> Counters {
        let adapter = self.adapter.counters();
        let of_lines = Counters {
            malformed_lines: adapter.lines.malformed + adapter.lines.overlong,
            unsupported_frames: adapter.lines.unsupported,
            refused: adapter.refused,
            ..Counters::default()
        };
        self.counters + self.pty.counters() + of_lines
    }
}
