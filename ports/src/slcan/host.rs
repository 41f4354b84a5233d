//! The user of an adapter.

use super::{EVENTS_MAX, Lines, USUAL};
use crate::error::{PortError, PortLost};
use crate::serial::{SerialEvent, SerialPort};
use crate::spec::SerialSpec;
use crate::{Counters, FrameEvent};
use std::collections::VecDeque;
use std::time::Duration;
use tokio::time::timeout;
use wire::can::CanFrame;
use wire::can_error::CanErrorEvent;
use wire::slcan::{Answer, AnswerDecoder, BitRate, Command};

/// Time-out for an adapter's answer. Assumption: USB adapters answer within a few milliseconds. An adapter that does
/// not answer at all is taken to have obeyed: some firmware acknowledges nothing.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);
/// Earlier traffic is over after this time without input.
const QUIET: Duration = Duration::from_millis(50);
/// How often an adapter may refuse to be opened. One that is slow answers the first commands when the last ones have been sent: its
/// refusal to close what is closed is then read as one of these.
const REFUSALS_MAX: usize = 3;
/// Maximum number of discarded reads before opening a bus that is never quiet.
const STALE_READS_MAX: usize = 1_000;

/// An adapter on a serial port, with its bus open.
#[derive(Debug)]
pub struct SlcanHost {
    serial: SerialPort,
    name: String,
    bitrate: BitRate,
    decoder: AnswerDecoder,
    lines: Lines,
    /// Decoded but not passed on yet; at most [`EVENTS_MAX`].
    events: VecDeque<FrameEvent>,
    counters: Counters,
}

impl SlcanHost {
    /// Opens the port, closes the adapter's bus if it was open, and opens it at `bitrate`. Must be called within a
    /// tokio runtime with IO and time enabled.
    ///
    /// # Errors
    /// If the port cannot be opened, or the adapter refuses.
    pub async fn open(spec: &SerialSpec, bitrate: BitRate) -> Result<Self, PortError> {
        let mut host = Self {
            serial: SerialPort::open(spec, USUAL)?,
            name: spec.device.to_string(),
            bitrate,
            decoder: AnswerDecoder::default(),
            lines: Lines::default(),
            events: VecDeque::with_capacity(EVENTS_MAX),
            counters: Counters::default(),
        };
        host.join().await?;
        Ok(host)
    }

    /// Brings the adapter from any state to an open bus.
    async fn join(&mut self) -> Result<(), PortError> {
        for _ in 1..REFUSALS_MAX {
            match self.try_to_join().await {
                Err(PortError::AdapterRefused { .. }) => {}
                other => return other,
            }
        }
        self.try_to_join().await
    }

    async fn try_to_join(&mut self) -> Result<(), PortError> {
        // Ends a partial line of another program (CAN232 manual: send two or three CR first).
        self.serial.send(b"\r\r\r");
        self.command(&Command::Close);
        for _ in 0..STALE_READS_MAX {
            match timeout(QUIET, self.serial.receive()).await {
                Ok(result) => _ = result.map_err(|lost| self.lost(lost))?,
                Err(_) => break,
            }
        }
        // A partial line from before does not belong to the new stream; the counts stay.
        self.counters = self.counters + self.of_lines();
        self.decoder = AnswerDecoder::default();
        for (command, words) in
            [(Command::BitRate(self.bitrate), "take the bitrate"), (Command::Open, "open the bus")]
        {
            self.command(&command);
            match timeout(ANSWER_LIMIT, self.answer()).await {
                Ok(Ok(Answer::Refused)) => {
                    let port = self.name.clone();
                    return Err(PortError::AdapterRefused { port, command: words });
                }
                Ok(Err(lost)) => return Err(self.lost(lost)),
                Ok(Ok(_)) => {}
                Err(_) => tracing::warn!("{}: no answer when told to {words}", self.name),
            }
        }
        Ok(())
    }

    fn lost(&self, source: PortLost) -> PortError {
        PortError::AdapterLost { port: self.name.clone(), source }
    }

    /// The answer to a command. Frames that arrive before it are kept.
    async fn answer(&mut self) -> Result<Answer, PortLost> {
        loop {
            let SerialEvent::Bytes(packet) = self.serial.receive().await? else { continue };
            let (mut answer, events, counters) = (None, &mut self.events, &mut self.counters);
            self.decoder.feed(packet.as_slice(), |heard| match heard {
                Answer::Done | Answer::Refused if answer.is_none() => answer = Some(heard),
                heard => events.extend(event(heard, counters)),
            });
            if let Some(answer) = answer {
                return Ok(answer);
            }
            // No reader yet: keep the newest events.
            while self.events.len() > EVENTS_MAX {
                self.events.pop_front();
                self.counters.receive_dropped_frames += 1;
            }
        }
    }

    fn command(&mut self, command: &Command) -> bool {
        self.lines.send(command.encode().as_slice(), |bytes| self.serial.send(bytes))
    }

    /// Waits for the next event. May be cancelled without loss.
    ///
    /// # Errors
    /// If the adapter is gone; on every call until it was [reopened](Self::reopen).
    pub async fn receive(&mut self) -> Result<FrameEvent, PortLost> {
        self.lines.finish(|bytes| self.serial.send(bytes));
        loop {
            if let Some(event) = self.events.pop_front() {
                return Ok(event);
            }
            if let SerialEvent::Bytes(packet) = self.serial.receive().await? {
                let (events, counters) = (&mut self.events, &mut self.counters);
                self.decoder.feed(packet.as_slice(), |heard| events.extend(event(heard, counters)));
            }
        }
    }

    /// Sends a frame to the adapter's line at once. Without room there it is lost and counted; does not wait for the
    /// adapter's acknowledgement, and counts [refusals](Counters::refused).
    pub fn send(&mut self, frame: &CanFrame) {
        if frame.fd_flags().is_none() && self.command(&Command::Transmit(*frame)) {
            self.counters.frames_out += 1;
        } else {
            self.counters.overrun_frames += 1;
        }
    }

    /// Closes the port, waits for the adapter's return, and opens its bus. May be cancelled, and called again.
    ///
    /// # Errors
    /// If the adapter stayed away for too long, or refuses.
    pub async fn reopen(&mut self) -> Result<(), PortError> {
        self.events.clear();
        self.serial.reopen().await?;
        self.lines = Lines::default();
        self.join().await
    }

    /// Traffic and losses of the port, including the serial line.
    pub fn counters(&self) -> Counters {
        self.counters + self.serial.counters() + self.of_lines()
    }

    /// Line counts since the bus was opened.
    fn of_lines(&self) -> Counters {
        let lines = self.decoder.counters();
        Counters {
            malformed_lines: lines.malformed + lines.overlong,
            unsupported_frames: lines.unsupported,
            ..Counters::default()
        }
    }
}

impl Drop for SlcanHost {
    /// Closes the bus: an abandoned adapter with an open bus fills its queues.
    fn drop(&mut self) {
        self.command(&Command::Close);
    }
}

/// The bus event in an answer.
fn event(answer: Answer, counters: &mut Counters) -> Option<FrameEvent> {
    let event = match answer {
        Answer::Frame(received) => {
            counters.frames_in += 1;
            return Some(FrameEvent::Frame(received.frame));
        }
        Answer::State(report) => CanErrorEvent::from(report),
        Answer::Errors(errors) => CanErrorEvent::from(errors),
        Answer::Refused => {
            counters.refused += 1;
            return None;
        }
        Answer::Done
        | Answer::TakenStandard
        | Answer::TakenExtended
        | Answer::Version(_)
        | Answer::SerialNumber(_)
        | Answer::Status(_) => return None,
    };
    counters.error_frames += 1;
    Some(FrameEvent::Bus(event))
}
