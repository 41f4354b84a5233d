//! A serial port: a UART, a USB adapter, or the far side of a pty.
//!
//! Errors on the line appear in the stream if the driver reports them ([`marks`]): bytes with a framing or parity
//! error, and breaks. Overruns of the UART do not: the kernel keeps them in counters that need an `ioctl`
//! (`TIOCGICOUNT`), for which there is no safe wrapper; it also writes them to its log (`dmesg`, "input overrun(s)").

pub mod marks;
mod open;
#[cfg(test)]
mod tests;
pub mod usb;

pub use open::written;

use super::Counters;
use super::attempts::Attempts;
use super::error::{PortError, PortLost};
use super::spec::SerialSpec;
use marks::{Heard, Marks};
use open::Before;
use tokio::io::AsyncReadExt as _;
use tokio_serial::SerialStream;
use wire::packet::Packet;
use wire::serial::SerialSettings;

const READ_BYTES: usize = 1_024;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SerialEvent {
    /// At least one byte.
    Bytes(Packet),
    /// The line was held low for longer than a byte takes.
    Break,
}

#[derive(Debug)]
pub struct SerialPort {
    spec: SerialSpec,
    settings: SerialSettings,
    line: Result<SerialStream, PortLost>,
    marks: Marks,
    before: Option<Before>,
    /// Bytes read but not passed on yet: `buffer[next..end]`.
    buffer: Box<[u8; READ_BYTES]>,
    next: usize,
    end: usize,
    attempts: Attempts,
    counters: Counters,
}

impl SerialPort {
    /// Opens the port; settings missing in `spec` are taken from `usual`. Discards bytes that arrived before the
    /// settings took effect. Must be called within a tokio runtime with IO enabled.
    ///
    /// # Errors
    /// If there is no such port, permission is missing, it is in use, or it rejects its settings.
    pub fn open(spec: &SerialSpec, usual: SerialSettings) -> Result<Self, PortError> {
        let settings = spec.options.settings(usual);
        let (stream, marks, before) = open::open(spec, settings)?;
        Ok(Self {
            spec: spec.clone(),
            settings,
            line: Ok(stream),
            marks,
            before,
            buffer: Box::new([0; READ_BYTES]),
            next: 0,
            end: 0,
            attempts: Attempts::default(),
            counters: Counters::default(),
        })
    }

    pub const fn settings(&self) -> SerialSettings {
        self.settings
    }

    /// Waits for bytes or a break. May be cancelled without loss.
    ///
    /// # Errors
    /// If the port is gone; on every call until it was [reopened](Self::reopen).
    pub async fn receive(&mut self) -> Result<SerialEvent, PortLost> {
        loop {
            while let Some(heard) = self.decode() {
                match heard {
                    Heard::Bytes(packet) => {
                        self.counters.bytes_in += packet.as_slice().len() as u64;
                        return Ok(SerialEvent::Bytes(packet));
                    }
                    Heard::Break => {
                        self.counters.breaks += 1;
                        return Ok(SerialEvent::Break);
                    }
                    Heard::LineError => {
                        self.counters.bytes_in += 1;
                        self.counters.line_errors += 1;
                    }
                }
            }
            let stream = self.line.as_mut().map_err(|lost| *lost)?;
            let lost = match stream.read(&mut self.buffer[..]).await {
                // The result of reading a tty whose device is gone.
                Ok(0) => PortLost::HungUp,
                Ok(count) => {
                    (self.next, self.end) = (0, count);
                    continue;
                }
                Err(cause) => PortLost::from_tty(&cause),
            };
            // Closed, so that the device can get its name again when it returns.
            (self.line, self.before) = (Err(lost), None);
        }
    }

    /// The next event in the bytes read; `None` when all were passed on.
    fn decode(&mut self) -> Option<Heard> {
        let mut rest = self.buffer.get(self.next..self.end)?;
        let heard = self.marks.next(&mut rest);
        self.next = self.end - rest.len();
        heard
    }

    /// Sends bytes at once, and returns how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let mut rest = bytes;
        if let Ok(stream) = &mut self.line {
            while !rest.is_empty() {
                match stream.try_write(rest) {
                    Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
                    // No room; or the port is gone, which the next read reports.
                    Ok(0) | Err(_) => break,
                }
            }
        }
        let taken = bytes.len() - rest.len();
        self.counters.overrun_bytes += rest.len() as u64;
        self.counters.bytes_out += taken as u64;
        taken
    }

    /// Closes the port and opens it again, twenty times a second until it exists; a USB id also finds it under another
    /// name. May be cancelled, and called again.
    ///
    /// # Errors
    /// If the port stayed away for too long; the next call waits as long again.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        if self.line.is_ok() {
            (self.line, self.before) = (Err(PortLost::HungUp), None);
        }
        let open = || open::open(&self.spec, self.settings);
        let given_up = |last| PortError::given_up(&self.spec.device.to_string(), last);
        let (stream, marks, before) = self.attempts.reopen(open).await.map_err(given_up)?;
        (self.line, self.marks, self.before) = (Ok(stream), marks, before);
        (self.next, self.end) = (0, 0);
        self.counters.returns += 1;
        Ok(())
    }

    pub const fn counters(&self) -> Counters {
        self.counters
    }
}
