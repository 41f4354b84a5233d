//! A serial port: a UART, a USB adapter, or the far side of a pty.
//!
//! What goes wrong on the line is told within the stream, where the driver knows it ([`marks`]): bytes
//! with a framing or parity error, and breaks. Overruns of the UART itself are not: the kernel keeps them
//! in counters that only an `ioctl` gives (`TIOCGICOUNT`), for which there is no safe wrapper; it writes
//! them to its log, though (`dmesg`, "input overrun(s)").

pub mod marks;
mod open;
#[cfg(test)]
mod tests;
pub mod usb;

use super::Counters;
use super::backoff::Backoff;
use super::error::{PortError, PortLost};
use super::spec::SerialSpec;
use marks::{Heard, Marks};
use std::io;
use tokio::io::AsyncReadExt as _;
use tokio_serial::SerialStream;
use wire::packet::Packet;
use wire::serial::SerialSettings;

/// Taken from the port at once.
const READ_BYTES: usize = 1_024;

/// What a serial port heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SerialEvent {
    /// Bytes; at least one.
    Bytes(Packet),
    /// The line was held low for longer than a byte takes.
    Break,
}

/// A serial port that is used from here.
#[derive(Debug)]
pub struct SerialPort {
    spec: SerialSpec,
    settings: SerialSettings,
    line: Line,
    marks: Marks,
    /// Read, and not yet handed on: `buffer[next..end]`.
    buffer: Box<[u8; READ_BYTES]>,
    next: usize,
    end: usize,
    backoff: Backoff,
    counters: Counters,
}

#[derive(Debug)]
enum Line {
    Open(SerialStream),
    Lost(PortLost),
}

impl SerialPort {
    /// Opens the port; what `spec` does not say is set as is `usual`. Bytes that came in before the
    /// settings were in force are thrown away. Called within a tokio runtime that has IO enabled.
    ///
    /// # Errors
    /// When there is no such port, it is not ours to open, is in use, or does not take its settings.
    pub fn open(spec: &SerialSpec, usual: SerialSettings) -> Result<Self, PortError> {
        let settings = spec.options.settings(usual);
        let (stream, marks) = open::open(spec, settings)?;
        Ok(Self {
            spec: spec.clone(),
            settings,
            line: Line::Open(stream),
            marks,
            buffer: Box::new([0; READ_BYTES]),
            next: 0,
            end: 0,
            backoff: Backoff::default(),
            counters: Counters::default(),
        })
    }

    /// What it is set to.
    pub const fn settings(&self) -> SerialSettings {
        self.settings
    }

    /// Waits for bytes or a break. May be called off without losing any.
    ///
    /// # Errors
    /// When the port is gone; again and again until it was [reopened](Self::reopen).
    pub async fn receive(&mut self) -> Result<SerialEvent, PortLost> {
        loop {
            while let Some(heard) = self.decode() {
                match heard {
                    Heard::Bytes(packet) => return Ok(SerialEvent::Bytes(packet)),
                    Heard::Break => {
                        self.counters.breaks += 1;
                        return Ok(SerialEvent::Break);
                    }
                    Heard::LineError => self.counters.line_errors += 1,
                }
            }
            let stream = match &mut self.line {
                Line::Open(stream) => stream,
                Line::Lost(lost) => return Err(*lost),
            };
            let lost = match stream.read(&mut self.buffer[..]).await {
                // What reading a tty gives whose device is gone.
                Ok(0) => PortLost::HungUp,
                Ok(count) => {
                    (self.next, self.end) = (0, count);
                    self.counters.bytes_in += count as u64;
                    continue;
                }
                Err(cause) => PortLost::from_tty(&cause),
            };
            // Closed, so that the device can have its name again when it is back.
            self.line = Line::Lost(lost);
        }
    }

    /// The next event in what was read; `None` when all has been handed on.
    fn decode(&mut self) -> Option<Heard> {
        let mut rest = self.buffer.get(self.next..self.end)?;
        let heard = self.marks.next(&mut rest);
        self.next = self.end - rest.len();
        heard
    }

    /// Hands bytes to the port at once, and says how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let mut rest = bytes;
        if let Line::Open(stream) = &mut self.line {
            while !rest.is_empty() {
                match stream.try_write(rest) {
                    Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
                    // No room; or gone, which reading will tell.
                    Ok(0) | Err(_) => break,
                }
            }
        }
        let taken = bytes.len() - rest.len();
        self.counters.overrun_bytes += rest.len() as u64;
        self.counters.bytes_out += taken as u64;
        taken
    }

    /// Holds the line low, until [`end_break`](Self::end_break). For how long is the caller's to time: a
    /// break lasts longer than a byte does.
    ///
    /// # Errors
    /// When the port is gone or its driver cannot do it.
    pub fn begin_break(&mut self) -> io::Result<()> {
        self.with_stream(tokio_serial::SerialPort::set_break)
    }

    /// The end of a break.
    ///
    /// # Errors
    /// As with its beginning.
    pub fn end_break(&mut self) -> io::Result<()> {
        self.with_stream(tokio_serial::SerialPort::clear_break)
    }

    fn with_stream(
        &self,
        act: impl FnOnce(&SerialStream) -> tokio_serial::Result<()>,
    ) -> io::Result<()> {
        match &self.line {
            Line::Open(stream) => Ok(act(stream)?),
            Line::Lost(_) => Err(io::ErrorKind::NotConnected.into()),
        }
    }

    /// Closes the port and opens it again, with growing pauses until it is there; by USB id it is found
    /// under another name, too. May be called off, and called again.
    ///
    /// # Errors
    /// When it stayed away for too long; the next call begins the series anew.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        if let Line::Open(_) = self.line {
            self.line = Line::Lost(PortLost::HungUp);
        }
        let mut last = None;
        while self.backoff.pause().await {
            match open::open(&self.spec, self.settings) {
                Ok((stream, marks)) => {
                    (self.line, self.marks) = (Line::Open(stream), marks);
                    (self.next, self.end) = (0, 0);
                    self.backoff = Backoff::default();
                    self.counters.returns += 1;
                    return Ok(());
                }
                Err(error) => last = Some(error),
            }
        }
        self.backoff = Backoff::default();
        Err(PortError::given_up(&self.spec.device.to_string(), last))
    }

    /// What has crossed it.
    pub const fn counters(&self) -> Counters {
        self.counters
    }
}
