//! The manager of a battery pack: the same as `manager.py`, as code that needs neither a bus nor a clock.
//!
//! It closes the contactor, after a precharge, while charging is requested and the cells are well. It opens it
//! permanently on over-voltage, over-temperature, or when the cells fall silent; it ignores messages with a wrong
//! checksum or counter.

use harness::wire::can::{CanFrame, Id, StandardId};
use harness::wire::device::{Device, PortId, Transmit};
use harness::wire::time::{Span, Timestamp};
use std::collections::VecDeque;

const CELLS: u16 = 0x100;
const COMMAND: u16 = 0x200;
const TRIP_REPORT: u16 = 0x210;
const REQUEST: u16 = 0x300;
const PERIOD: Span = Span::from_millis(50);
/// Voltage limit of the cells' manufacturer, V.
const VOLTAGE_MAX: f64 = 4.25;
/// Temperature limit of the cells' manufacturer, degC.
const TEMPERATURE_MAX: i8 = 60;
/// Half the current from this temperature on, degC.
const WARM: i8 = 45;
const SILENCE: Span = Span::from_millis(500);
const PRECHARGE: Span = Span::from_millis(100);
/// Rated current of the cells, A.
const CURRENT_LIMIT: f64 = 40.0;

/// A mistake that a test plants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// Charges warm cells like cold ones.
    NoDerating,
    /// Opens a second late.
    OpensLate,
    /// Notices the silence of the cells three times too late.
    LongTimeOut,
    /// The counter of its command stands still.
    StuckCounter,
    /// Does not wait for the precharge.
    SkipsPrecharge,
    /// After a wrong checksum, does not check the counter any more.
    TrustsAfterError,
    /// Opens half a second after it has closed, though nothing is wrong.
    GivesUp,
}

/// Its state, in the numbers of its command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum State {
    #[default]
    Standby = 0,
    Precharge = 1,
    Charging = 2,
    Tripped = 3,
}

/// Reason for keeping the contactor open, in the numbers of its report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reason {
    OverVoltage = 1,
    OverTemperature = 2,
    Silence = 3,
}

/// The manager.
#[derive(Debug, Clone, Default)]
pub struct Manager {
    mistake: Option<Mistake>,
    asked: bool,
    cells_at: Option<Timestamp>,
    cells_count: Option<u8>,
    trusting: bool,
    voltage: f64,
    temperature: i8,
    state: State,
    since: Timestamp,
    count: u8,
    reason: Option<Reason>,
    is_reported: bool,
    due: Timestamp,
    outgoing: VecDeque<CanFrame>,
}

impl Manager {
    /// A manager with this mistake, if any.
    pub fn new(mistake: Option<Mistake>) -> Self {
        Self { mistake, ..Self::default() }
    }

    fn makes(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    fn hear_cells(&mut self, now: Timestamp, data: &[u8; 8]) {
        if crc8_sae_j1850(&data[..7]) != data[7] {
            self.trusting = self.makes(Mistake::TrustsAfterError);
            return;
        }
        let count = Some(data[5] & 0xf);
        if count == self.cells_count && !self.trusting {
            return;
        }
        self.cells_count = count;
        self.voltage = f64::from(u16::from_le_bytes([data[0], data[1]])) * 0.001;
        self.temperature = data[4].cast_signed();
        self.cells_at = Some(now);
    }

    fn wrong(&self, now: Timestamp) -> Option<Reason> {
        let heard_at = self.cells_at?;
        let time_out = SILENCE * if self.makes(Mistake::LongTimeOut) { 3 } else { 1 };
        match () {
            () if self.voltage > VOLTAGE_MAX => Some(Reason::OverVoltage),
            () if self.temperature > TEMPERATURE_MAX => Some(Reason::OverTemperature),
            () if now - heard_at > time_out => Some(Reason::Silence),
            () => None,
        }
    }

    fn step(&mut self, now: Timestamp) {
        let wrong = self.wrong(now);
        let is_charged = self.makes(Mistake::SkipsPrecharge) || now - self.since >= PRECHARGE;
        let next = match self.state {
            State::Tripped => State::Tripped,
            _ if wrong.is_some() => State::Tripped,
            State::Standby if self.asked && self.cells_at.is_some() => State::Precharge,
            State::Precharge | State::Charging if !self.asked => State::Standby,
            State::Precharge if is_charged => State::Charging,
            same => same,
        };
        if next != self.state {
            (self.state, self.since) = (next, now);
            if next == State::Tripped {
                (self.reason, self.is_reported) = (wrong, false);
            }
        }
        let late = self.makes(Mistake::OpensLate) && next == State::Tripped;
        let gives_up = self.makes(Mistake::GivesUp) && now - self.since > Span::from_millis(500);
        let closed = match late {
            true => now - self.since < Span::from_secs(1),
            false => next == State::Charging && !gives_up,
        };
        let command = self.command(closed);
        self.send(COMMAND, &command);
        if !self.is_reported {
            self.is_reported = true;
            self.send(TRIP_REPORT, &[self.reason.map_or(0, |reason| reason as u8)]);
        }
    }

    fn command(&mut self, closed: bool) -> [u8; 5] {
        let warm = self.temperature > WARM && !self.makes(Mistake::NoDerating);
        let limit = if warm { CURRENT_LIMIT / 2.0 } else { CURRENT_LIMIT };
        let limit = if closed { (limit / 0.01).round() as u16 } else { 0 };
        let [low, high] = limit.to_le_bytes();
        let mut data = [u8::from(closed) | (self.state as u8) << 1, low, high, self.count, 0];
        data[4] = crc8_sae_j1850(&data[..4]);
        if !self.makes(Mistake::StuckCounter) {
            self.count = (self.count + 1) % 16;
        }
        data
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        let frame = StandardId::new(id).and_then(|id| CanFrame::new(id, data));
        self.outgoing.extend(frame);
    }
}

/// CRC-8 SAE J1850: polynomial 0x1d, all ones as initial value and final inversion.
fn crc8_sae_j1850(data: &[u8]) -> u8 {
    let step = |crc: u8| if crc & 0x80 == 0 { crc << 1 } else { (crc << 1) ^ 0x1d };
    !data.iter().fold(0xff, |crc, byte| (0..8).fold(crc ^ byte, |crc, _| step(crc)))
}

impl Device for Manager {
    fn receive(&mut self, now: Timestamp, _: PortId, what: &Transmit) {
        let Transmit::Frame(frame) = what else { return };
        let Id::Standard(id) = frame.id() else { return };
        match (id.as_raw(), frame.data()) {
            (CELLS, data) => {
                if let Ok(data) = data.try_into() {
                    self.hear_cells(now, data);
                }
            }
            (REQUEST, [asked, ..]) => self.asked = asked & 1 == 1,
            _ => {}
        }
    }

    fn wake(&mut self, now: Timestamp) {
        if now >= self.due {
            self.due = now + PERIOD;
            self.step(now);
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        self.due
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.outgoing.pop_front().map(|frame| (PortId(0), Transmit::Frame(frame)))
    }
}
