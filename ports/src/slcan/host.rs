//! The user of an adapter.

use super::{EVENTS_MAX, Lines, USUAL};
use crate::error::{PortError, PortLost};
use crate::serial::{SerialEvent, SerialPort};
use crate::spec::SerialSpec;
use crate::{Counters, FrameEvent};
use std::collections::VecDeque;
use std::pin::Pin;
use std::time::Duration;
use tokio::time::{Sleep, sleep};
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
    /// `None` if the bus is open, or was not yet asked for.
    joining: Option<Joining>,
}

/// How far an adapter has been brought to an open bus.
#[derive(Debug)]
struct Joining {
    stage: Stage,
    /// How often it has refused.
    refusals: usize,
    /// End of the wait. Kept here so that a cancelled wait continues where it was.
    limit: Pin<Box<Sleep>>,
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    /// Earlier traffic is discarded, so many reads so far.
    Clearing(usize),
    /// The answer to a command is awaited.
    Told(Told),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    BitRate,
    Open,
}

impl Told {
    const fn words(self) -> &'static str {
        match self {
            Self::BitRate => "take the bitrate",
            Self::Open => "open the bus",
        }
    }
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
            joining: None,
        };
        host.join().await?;
        Ok(host)
    }

    /// Brings the adapter from any state to an open bus. May be cancelled, and called again.
    async fn join(&mut self) -> Result<(), PortError> {
        let joined = self.go_on_joining().await;
        self.joining = None;
        joined
    }

    /// Each turn of the loop waits once, before it changes anything: a cancelled call loses nothing.
    async fn go_on_joining(&mut self) -> Result<(), PortError> {
        self.joining.is_none().then(|| self.begin_to_join(0));
        loop {
            let Some(Joining { stage, refusals, limit }) = &mut self.joining else { return Ok(()) };
            let (stage, refusals) = (*stage, *refusals);
            let heard = tokio::select! {
                biased;
                heard = self.serial.receive() => Some(heard.map_err(|source| {
                    PortError::AdapterLost { port: self.name.clone(), source }
                })?),
                () = limit.as_mut() => None,
            };
            match (stage, heard) {
                (Stage::Clearing(reads), Some(_)) if reads < STALE_READS_MAX => {
                    self.wait(Stage::Clearing(reads + 1), QUIET);
                }
                (Stage::Clearing(_), _) => {
                    // A partial line from before does not belong to the new stream; the counts stay.
                    self.counters = self.counters + self.of_lines();
                    self.decoder = AnswerDecoder::default();
                    self.tell(Told::BitRate);
                }
                (Stage::Told(told), Some(event)) => match self.answer(&event) {
                    None => {}
                    Some(Answer::Refused) if refusals + 1 < REFUSALS_MAX => {
                        self.begin_to_join(refusals + 1);
                    }
                    Some(Answer::Refused) => {
                        let (port, command) = (self.name.clone(), told.words());
                        return Err(PortError::AdapterRefused { port, command });
                    }
                    Some(_) => self.obeyed(told),
                },
                (Stage::Told(told), None) => {
                    tracing::warn!("{}: no answer when told to {}", self.name, told.words());
                    self.obeyed(told);
                }
            }
        }
    }

    fn begin_to_join(&mut self, refusals: usize) {
        // Ends a partial line of another program (CAN232 manual: send two or three CR first).
        self.serial.send(b"\r\r\r");
        self.command(&Command::Close);
        let (stage, limit) = (Stage::Clearing(0), Box::pin(sleep(QUIET)));
        self.joining = Some(Joining { stage, refusals, limit });
    }

    fn wait(&mut self, stage: Stage, limit: Duration) {
        if let Some(joining) = &mut self.joining {
            (joining.stage, joining.limit) = (stage, Box::pin(sleep(limit)));
        }
    }

    fn obeyed(&mut self, told: Told) {
        match told {
            Told::BitRate => self.tell(Told::Open),
            Told::Open => self.joining = None,
        }
    }

    fn tell(&mut self, told: Told) {
        self.command(&match told {
            Told::BitRate => Command::BitRate(self.bitrate),
            Told::Open => Command::Open,
        });
        self.wait(Stage::Told(told), ANSWER_LIMIT);
    }

    /// The answer to a command, if this is it. Frames that arrive before it are kept.
    fn answer(&mut self, heard: &SerialEvent) -> Option<Answer> {
        let SerialEvent::Bytes(packet) = heard else { return None };
        let (mut answer, events, counters) = (None, &mut self.events, &mut self.counters);
        self.decoder.feed(packet.as_slice(), |heard| match heard {
            Answer::Done | Answer::Refused if answer.is_none() => answer = Some(heard),
            heard => events.extend(event(heard, counters)),
        });
        // No reader yet: keep the newest events.
        while self.events.len() > EVENTS_MAX {
            self.events.pop_front();
            self.counters.receive_dropped_frames += 1;
        }
        answer
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

    /// Sends a frame to the adapter's line at once. Without room there, or before the bus is open, it is lost and counted;
    /// does not wait for the adapter's acknowledgement, and counts [refusals](Counters::refused).
    pub fn send(&mut self, frame: &CanFrame) {
        let is_open = self.joining.is_none();
        if is_open && frame.fd_flags().is_none() && self.command(&Command::Transmit(*frame)) {
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
        if self.joining.is_none() {
            self.events.clear();
            self.serial.reopen().await?;
            self.lines = Lines::default();
        }
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
