//! An adapter: a state machine between a serial line and a bus.

use super::decode::{CommandDecoder, LineCounters};
use super::{
    Answer, BitRate, BitTiming, Command, ReceivedFrame, StatusFlags, TIMESTAMP_WRAP_MS, Text,
};
use crate::can::{CanFrame, Id};
use crate::packet::{BYTES_MAX, Packet};
use crate::time::Timestamp;
use heapless::Deque;

/// Maximum number of frames waiting for the serial line (assumption: the adapters' queue of 32 frames).
const FRAME_LINES_MAX: usize = 32;

/// Maximum number of lines waiting for the serial line: beyond the frames, an answer for every byte of one packet from
/// the host, so that a busy bus does not block the answer to `C`.
pub const OUTPUT_LINES_MAX: usize = FRAME_LINES_MAX + BYTES_MAX;

/// Bit timing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Timing {
    Rate(BitRate),
    Registers(BitTiming),
}

/// State of the channel to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channel {
    /// Sends and receives nothing.
    #[default]
    Closed,
    /// Sends and receives.
    Open,
    /// Receives only.
    ListenOnly,
}

/// Identification of an adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Answer to `V`.
    pub version: Text,
    /// Answer to `N`.
    pub serial_number: Text,
}

/// The examples of the CANUSB manual: version `1013`, serial number `A123`.
impl Default for Identity {
    fn default() -> Self {
        const VERSION: Text = Text::new(b"1013").expect("four characters");
        const SERIAL_NUMBER: Text = Text::new(b"A123").expect("four characters");
        Self { version: VERSION, serial_number: SERIAL_NUMBER }
    }
}

/// The bus has no room for another frame at the moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TransmitFull;

/// Counters of an [`Adapter`] since its creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AdapterCounters {
    /// Lines from the host.
    pub lines: LineCounters,
    /// Commands and lines answered with BEL.
    pub refused: u64,
    /// Frames from the host that the bus accepted.
    pub frames_to_bus: u64,
    /// Frames from the bus that were queued for the host.
    pub frames_to_host: u64,
    /// Frames from the bus lost because the queue was full ([`StatusFlags::RECEIVE_FIFO_FULL`]).
    pub frames_lost: u64,
    /// Frames on the bus while the channel was closed.
    pub frames_unheard: u64,
    /// Answers lost because the queue was full.
    pub answers_lost: u64,
}

/// An adapter between a serial line and a bus.
///
/// [`Adapter::receive`] takes bytes from the host, [`Adapter::receive_frame`] a frame from the bus; after each of them,
/// call [`Adapter::transmit`] until it returns `None` and send the lines. Its bus has no errors.
///
/// It answers as the CANUSB manual specifies. Where the manual is silent: opening clears the flags, because the
/// controller is reset then; an empty line is refused like any other invalid command (assumption).
#[derive(Debug, Clone, Default)]
pub struct Adapter {
    decoder: CommandDecoder,
    core: Core,
}

/// All but the decoder, which lends each command to this part.
#[derive(Debug, Clone, Default)]
struct Core {
    identity: Identity,
    channel: Channel,
    timing: Option<Timing>,
    timestamps: bool,
    status: StatusFlags,
    output: Deque<Packet, OUTPUT_LINES_MAX>,
    counters: AdapterCounters,
}

impl Adapter {
    /// A closed adapter without a bit rate.
    pub fn new(identity: Identity) -> Self {
        Self { decoder: CommandDecoder::default(), core: Core { identity, ..Core::default() } }
    }

    /// Takes bytes from the host. Calls `send` for each frame to send, which returns whether the bus has room.
    ///
    /// A run may have any length. If the output is fetched after every [`BYTES_MAX`] bytes, no answer is lost; with
    /// longer runs, answers without room are counted.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        mut send: impl FnMut(CanFrame) -> Result<(), TransmitFull>,
    ) {
        let core = &mut self.core;
        self.decoder.feed(bytes, |command| {
            let answer = command.ok().and_then(|command| core.carry_out(&command, &mut send));
            core.answer(&answer.unwrap_or(Answer::Refused));
        });
    }

    /// Takes a frame from the bus.
    pub fn receive_frame(&mut self, now: Timestamp, frame: CanFrame) {
        let core = &mut self.core;
        if core.channel == Channel::Closed {
            core.counters.frames_unheard += 1;
            return;
        }
        let timestamp_ms = core.timestamps.then(|| milliseconds(now));
        let line = Answer::Frame(ReceivedFrame { frame, timestamp_ms }).encode();
        if core.output.len() < FRAME_LINES_MAX && core.output.push_back(line).is_ok() {
            core.counters.frames_to_host += 1;
        } else {
            core.status |= StatusFlags::RECEIVE_FIFO_FULL;
            core.counters.frames_lost += 1;
        }
    }

    /// The next line for the host.
    pub fn transmit(&mut self) -> Option<Packet> {
        self.core.output.pop_front()
    }

    /// State of the channel to the bus.
    pub const fn channel(&self) -> Channel {
        self.core.channel
    }

    /// The bit rate selected by the host, in bits per second.
    pub fn bits_per_second(&self) -> Option<u32> {
        self.core.timing.map(|timing| match timing {
            Timing::Rate(rate) => rate.bits_per_second(),
            Timing::Registers(registers) => registers.bits_per_second(),
        })
    }

    /// The current status flags; reading them here does not clear them.
    pub const fn status(&self) -> StatusFlags {
        self.core.status
    }

    /// The counters.
    pub const fn counters(&self) -> AdapterCounters {
        AdapterCounters { lines: self.decoder.counters(), ..self.core.counters }
    }
}

impl Core {
    /// The answer to a command; `None` if it cannot be carried out.
    fn carry_out(
        &mut self,
        command: &Command,
        send: &mut impl FnMut(CanFrame) -> Result<(), TransmitFull>,
    ) -> Option<Answer> {
        let closed = self.channel == Channel::Closed;
        match command {
            Command::Version => return Some(Answer::Version(self.identity.version)),
            Command::SerialNumber => {
                return Some(Answer::SerialNumber(self.identity.serial_number));
            }
            Command::BitRate(rate) if closed => self.timing = Some(Timing::Rate(*rate)),
            Command::BitTiming(timing) if closed => self.timing = Some(Timing::Registers(*timing)),
            Command::TimestampsOff if closed => self.timestamps = false,
            Command::TimestampsOn if closed => self.timestamps = true,
            Command::Open if closed => self.open(Channel::Open)?,
            Command::OpenListenOnly if closed => self.open(Channel::ListenOnly)?,
            Command::Close if !closed => self.channel = Channel::Closed,
            Command::Status if !closed => {
                return Some(Answer::Status(core::mem::take(&mut self.status)));
            }
            Command::Transmit(frame) if self.channel == Channel::Open => {
                if send(*frame) == Err(TransmitFull) {
                    self.status |= StatusFlags::TRANSMIT_FIFO_FULL;
                    return None;
                }
                self.counters.frames_to_bus += 1;
                return Some(match frame.id() {
                    Id::Standard(_) => Answer::TakenStandard,
                    Id::Extended(_) => Answer::TakenExtended,
                });
            }
            Command::BitRate(_)
            | Command::BitTiming(_)
            | Command::TimestampsOff
            | Command::TimestampsOn
            | Command::Open
            | Command::OpenListenOnly
            | Command::Close
            | Command::Status
            | Command::Transmit(_) => return None,
        }
        Some(Answer::Done)
    }

    /// Joins the bus; `None` without a bit rate.
    fn open(&mut self, channel: Channel) -> Option<()> {
        self.timing?;
        self.channel = channel;
        self.status = StatusFlags::empty();
        Some(())
    }

    fn answer(&mut self, answer: &Answer) {
        if *answer == Answer::Refused {
            self.counters.refused += 1;
        }
        if self.output.push_back(answer.encode()).is_err() {
            self.counters.answers_lost += 1;
        }
    }
}

/// An adapter's clock: milliseconds that wrap to zero every minute.
fn milliseconds(now: Timestamp) -> u16 {
    const NANOS_PER_MILLISECOND: i64 = 1_000_000;
    (now.as_nanos() / NANOS_PER_MILLISECOND).rem_euclid(i64::from(TIMESTAMP_WRAP_MS)) as u16
}
