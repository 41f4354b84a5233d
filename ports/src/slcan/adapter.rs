//! An adapter that is played on a pty.

use super::{EVENTS_MAX, Lines};
use crate::error::{PortError, PortLost};
use crate::pty::PtyPort;
use crate::{Counters, FrameEvent};
use std::collections::VecDeque;
use std::path::Path;
use wire::can::CanFrame;
use wire::can_error::CanErrorEvent;
use wire::slcan::{Adapter, Channel, Dialect, Identity, TransmitFull};
use wire::time::Timestamp;

/// An adapter on a pty. This side is its bus: frames that the other side sends are received here.
///
/// The other side opens and closes the bus, which is told as [`FrameEvent::Up`] and [`FrameEvent::Down`];
/// it begins closed. Errors are told in the lines that the Linux driver understands, and in the status
/// flags that other programs ask for.
#[derive(Debug)]
pub struct SlcanAdapter {
    pty: PtyPort,
    adapter: Adapter,
    lines: Lines,
    /// From the other side, and not yet handed on; at most [`EVENTS_MAX`].
    events: VecDeque<FrameEvent>,
    counters: Counters,
}

impl SlcanAdapter {
    /// An adapter on a new pty, with a symbolic link to its far side where one is wanted. Called within a
    /// tokio runtime that has IO enabled.
    ///
    /// # Errors
    /// When the system has no pty to give, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, PortError> {
        Ok(Self {
            pty: PtyPort::open(link)?,
            adapter: Adapter::new(Identity::default(), Dialect::Linux),
            lines: Lines::default(),
            events: VecDeque::with_capacity(EVENTS_MAX),
            counters: Counters::default(),
        })
    }

    /// What the other side opens.
    pub fn far_path(&self) -> &str {
        self.pty.far_path()
    }

    /// Whether the other side has opened the bus.
    pub const fn channel(&self) -> Channel {
        self.adapter.channel()
    }

    /// Waits for what comes next, and answers the other side meanwhile. May be called off without losing
    /// anything.
    ///
    /// # Errors
    /// What the system reports of the pty; that the other side closes it is none.
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        self.lines.finish(|bytes| self.pty.send(bytes));
        loop {
            if let Some(event) = self.events.pop_front() {
                return Ok(event);
            }
            let packet = self.pty.receive().await?;
            // Byte for byte, so that opening and closing keep their place among the frames.
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

    /// Hands a frame to the other side at once. What finds no room, or a bus that the other side has not
    /// opened, is lost and counted.
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

    /// Tells the other side of an error on the bus; while it is closed, nobody.
    pub fn report(&mut self, event: &CanErrorEvent) {
        self.adapter.receive_error(event);
        self.answer();
    }

    /// Hands the lines that wait to the other side; `false` when the last of them did not get across.
    fn answer(&mut self) -> bool {
        let mut sent = true;
        while let Some(line) = self.adapter.transmit() {
            sent = self.lines.send(line.as_slice(), |bytes| self.pty.send(bytes));
        }
        sent
    }

    /// What has crossed it, the serial line included.
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
