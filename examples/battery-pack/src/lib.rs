//! The manager of a battery pack: the same as `manager.py`, as code that needs neither a bus nor a clock.
//!
//! It closes the contactor while it is asked to charge and the cells are well, and opens it for good on over-voltage,
//! over-temperature, or when the cells fall silent.

use harness::wire::can::{CanFrame, Id, StandardId};
use harness::wire::device::{Device, PortId, Transmit};
use harness::wire::time::{Span, Timestamp};

const CELLS: u16 = 0x100;
const COMMAND: u16 = 0x200;
const REQUEST: u16 = 0x300;
const PERIOD: Span = Span::from_millis(50);
/// Where the cells' maker says stop, V.
const VOLTAGE_MAX: f64 = 4.25;
/// Likewise, degC.
const TEMPERATURE_MAX: i8 = 60;
const SILENCE: Span = Span::from_millis(500);
/// What the cells may take, A.
const CURRENT_LIMIT: f64 = 40.0;

/// A mistake that a test plants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// It never opens the contactor.
    NeverOpens,
    /// It opens a second late.
    OpensLate,
    /// It closes again by itself.
    ClosesAgain,
    /// It allows twice what the cells may take.
    LimitTooHigh,
    /// It does not notice that the cells fell silent.
    ForgetsSilence,
}

/// The manager.
#[derive(Debug, Clone, Default)]
pub struct Manager {
    mistake: Option<Mistake>,
    asked: bool,
    cells_at: Option<Timestamp>,
    voltage: f64,
    temperature: i8,
    tripped_at: Option<Timestamp>,
    due: Timestamp,
    outgoing: Option<CanFrame>,
}

impl Manager {
    /// One that makes this mistake, or none.
    pub fn new(mistake: Option<Mistake>) -> Self {
        Self { mistake, ..Self::default() }
    }

    fn closed(&mut self, now: Timestamp) -> bool {
        let forgets = self.mistake == Some(Mistake::ForgetsSilence);
        let silent = self.cells_at.is_none_or(|at| now - at > SILENCE && !forgets);
        let bad = self.voltage > VOLTAGE_MAX || self.temperature > TEMPERATURE_MAX;
        if self.cells_at.is_some() && (bad || silent) {
            self.tripped_at.get_or_insert(now);
        }
        let since = self.tripped_at.map(|at| now - at);
        let tripped = match (self.mistake, since) {
            (_, None) | (Some(Mistake::NeverOpens), _) => false,
            (Some(Mistake::OpensLate), Some(since)) => since > Span::from_secs(1),
            (Some(Mistake::ClosesAgain), Some(since)) => since < Span::from_millis(500),
            (_, Some(_)) => true,
        };
        self.asked && !silent && !tripped
    }

    fn command(&mut self, now: Timestamp) -> Option<CanFrame> {
        let closed = self.closed(now);
        let twice = self.mistake == Some(Mistake::LimitTooHigh);
        let limit = if closed { CURRENT_LIMIT * if twice { 2.0 } else { 1.0 } } else { 0.0 };
        let [low, high] = ((limit / 0.01).round() as u16).to_le_bytes();
        CanFrame::new(StandardId::new(COMMAND)?, &[u8::from(closed), low, high, 0])
    }
}

impl Device for Manager {
    fn receive(&mut self, now: Timestamp, _: PortId, what: &Transmit) {
        let Transmit::Frame(frame) = what else { return };
        let Id::Standard(id) = frame.id() else { return };
        match (id.as_raw(), frame.data()) {
            (CELLS, [low, high, _, _, temperature, ..]) => {
                self.voltage = f64::from(u16::from_le_bytes([*low, *high])) * 0.001;
                self.temperature = temperature.cast_signed();
                self.cells_at = Some(now);
            }
            (REQUEST, [asked, ..]) => self.asked = asked & 1 == 1,
            _ => {}
        }
    }

    fn wake(&mut self, now: Timestamp) {
        if now >= self.due {
            self.due = now + PERIOD;
            self.outgoing = self.command(now);
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        self.due
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.outgoing.take().map(|frame| (PortId(0), Transmit::Frame(frame)))
    }
}
