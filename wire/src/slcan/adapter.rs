//! An adapter: a state machine between a serial line and a bus.

use super::decode::{CommandDecoder, LineCounters};
use super::{
    Answer, BitRate, BitTiming, BusErrors, Command, ReceivedFrame, StateReport, StatusFlags,
    TIMESTAMP_WRAP_MS, Text,
};
use crate::can::{CanFrame, Id};
use crate::can_error::{BusState, CanErrorEvent, ControllerProblems};
use crate::packet::{BYTES_MAX, Packet};
use crate::time::Timestamp;
use heapless::Deque;

/// Frames and reports that wait for the serial line at most (assumption: the adapters' queue of 32 frames).
const REPORT_LINES_MAX: usize = 32;

/// Lines that wait for the serial line at most: beyond the frames, an answer for every byte of one packet
/// from the host, so that a busy bus does not keep `C` from being answered.
pub const OUTPUT_LINES_MAX: usize = REPORT_LINES_MAX + BYTES_MAX;

/// What a bit lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Timing {
    Rate(BitRate),
    Registers(BitTiming),
}

/// Whether the adapter takes part in the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channel {
    /// It does not: nothing is sent, nothing heard.
    #[default]
    Closed,
    /// It does.
    Open,
    /// It hears, and sends nothing.
    ListenOnly,
}

/// How an adapter says that the bus is in trouble.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dialect {
    /// In the status flags alone, as the Lawicel adapters do.
    #[default]
    Lawicel,
    /// In state and error lines as well, unasked, which the Linux driver turns into error frames.
    Linux,
}

/// What an adapter says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Behind `V`.
    pub version: Text,
    /// Behind `N`.
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

/// The bus has no room for another frame now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TransmitFull;

/// What an [`Adapter`] has counted since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AdapterCounters {
    /// Lines from the host.
    pub lines: LineCounters,
    /// Commands and lines answered with BEL.
    pub refused: u64,
    /// Frames from the host that the bus took.
    pub frames_to_bus: u64,
    /// Frames from the bus that were queued for the host.
    pub frames_to_host: u64,
    /// Frames from the bus that found the queue full ([`StatusFlags::RECEIVE_FIFO_FULL`]).
    pub frames_lost: u64,
    /// Frames on the bus while the channel was closed.
    pub frames_unheard: u64,
    /// Answers and reports that found the queue full.
    pub answers_lost: u64,
}

/// An adapter between a serial line and a bus.
///
/// Bytes from the host come in by [`Adapter::receive`], frames and errors from the bus by
/// [`Adapter::receive_frame`] and [`Adapter::receive_error`]; after each of them, send what
/// [`Adapter::transmit`] gives until there is none.
///
/// It answers as the CANUSB manual says. Where that is silent: the flags are cleared on opening, as the
/// controller is reset then; an empty line is refused as any other that is no command (assumption).
#[derive(Debug, Clone, Default)]
pub struct Adapter {
    decoder: CommandDecoder,
    core: Core,
}

/// All but the decoder, which lends each command to it.
#[derive(Debug, Clone, Default)]
struct Core {
    identity: Identity,
    dialect: Dialect,
    channel: Channel,
    timing: Option<Timing>,
    timestamps: bool,
    status: StatusFlags,
    output: Deque<Packet, OUTPUT_LINES_MAX>,
    counters: AdapterCounters,
}

impl Adapter {
    /// An adapter that is closed and has no bit rate.
    pub fn new(identity: Identity, dialect: Dialect) -> Self {
        Self { decoder: CommandDecoder::new(), core: Core { identity, dialect, ..Core::default() } }
    }

    /// Takes bytes from the host. Each frame that the host wants sent goes to `send`, which says whether the
    /// bus has room for it.
    ///
    /// A run may have any length. Where the output is taken after every [`BYTES_MAX`] bytes, no answer is
    /// lost; of a longer run those that find no room are counted.
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
        if core.report(&Answer::Frame(ReceivedFrame { frame, timestamp_ms })) {
            core.counters.frames_to_host += 1;
        } else {
            core.status |= StatusFlags::RECEIVE_FIFO_FULL;
            core.counters.frames_lost += 1;
        }
    }

    /// Takes an error from the bus.
    pub fn receive_error(&mut self, event: &CanErrorEvent) {
        let core = &mut self.core;
        if core.channel == Channel::Closed {
            return;
        }
        core.status |= status_of(event);
        if core.dialect == Dialect::Lawicel {
            return;
        }
        let state = StateReport::from_event(event).map(Answer::State);
        let errors = BusErrors::from_event(event).map(Answer::Errors);
        for report in [errors, state].into_iter().flatten() {
            if !core.report(&report) {
                core.counters.answers_lost += 1;
            }
        }
    }

    /// The next line for the host.
    pub fn transmit(&mut self) -> Option<Packet> {
        self.core.output.pop_front()
    }

    /// Whether it takes part in the bus.
    pub const fn channel(&self) -> Channel {
        self.core.channel
    }

    /// The bit rate that the host chose, in bits per second.
    pub fn bits_per_second(&self) -> Option<u32> {
        self.core.timing.map(|timing| match timing {
            Timing::Rate(rate) => rate.bits_per_second(),
            Timing::Registers(registers) => registers.bits_per_second(),
        })
    }

    /// The status flags as they stand; reading them here does not clear them.
    pub const fn status(&self) -> StatusFlags {
        self.core.status
    }

    /// The counters.
    pub const fn counters(&self) -> AdapterCounters {
        AdapterCounters { lines: self.decoder.counters(), ..self.core.counters }
    }
}

impl Core {
    /// The answer to a command; `None` where it cannot be carried out.
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

    /// Queues what the host did not ask for; `false` where there is no room.
    fn report(&mut self, answer: &Answer) -> bool {
        self.output.len() < REPORT_LINES_MAX && self.output.push_back(answer.encode()).is_ok()
    }
}

/// An adapter's clock: milliseconds that return to zero every minute.
fn milliseconds(now: Timestamp) -> u16 {
    const NANOS_PER_MILLISECOND: i64 = 1_000_000;
    (now.as_nanos() / NANOS_PER_MILLISECOND).rem_euclid(i64::from(TIMESTAMP_WRAP_MS)) as u16
}

/// The flags that an error sets.
fn status_of(event: &CanErrorEvent) -> StatusFlags {
    let controller = event.controller.unwrap_or_default();
    let state = event.bus_state().unwrap_or(BusState::Active);
    let mut status = StatusFlags::empty();
    status.set(StatusFlags::ERROR_WARNING, state >= BusState::Warning);
    status.set(StatusFlags::ERROR_PASSIVE, state >= BusState::Passive);
    status.set(StatusFlags::DATA_OVERRUN, controller.contains(ControllerProblems::RX_OVERFLOW));
    status.set(StatusFlags::ARBITRATION_LOST, event.lost_arbitration.is_some());
    status.set(StatusFlags::BUS_ERROR, event.bus_error || event.protocol.is_some());
    status
}
