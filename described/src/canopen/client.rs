//! The client of SDO transfers, for plans: it writes and reads numbers.

use super::abort::Abort;
use super::sdo;
use wire::time::{Span, Timestamp};

/// How long an answer may take. Assumption: the usual time-out of masters is some hundred milliseconds.
const TIMEOUT: Span = Span::from_secs(1);
/// Most bytes that are read: a number has at most eight.
const BYTES_MAX: usize = 64;

/// One transfer of a number.
#[derive(Debug, Clone)]
pub struct SdoClient {
    object: (u16, u8),
    /// What is written, until it is sent; what is read.
    data: Vec<u8>,
    writes: bool,
    toggle: u8,
    deadline: Timestamp,
    /// The other object for which an answer came.
    other: Option<(u16, u8)>,
    says_length: bool,
}

/// What comes of a frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// It belongs to something else.
    Nothing,
    /// These bytes are sent next.
    Send([u8; 8]),
    /// The transfer is complete; these bytes were read.
    Done(Vec<u8>),
    /// The device has aborted it.
    Aborted(Abort),
    /// Its answer makes no sense; the client has to [abort](SdoClient::give_up) it.
    Senseless(Abort),
}

impl SdoClient {
    /// Begins a transfer: writes these bytes, or reads. Returns the first request, too.
    pub fn new(now: Timestamp, object: (u16, u8), write: Option<Vec<u8>>) -> (Self, [u8; 8]) {
        let first = match &write {
            None => sdo::words(0x40, object, [0; 4]),
            Some(data) if data.len() <= 4 => {
                let mut four = [0; 4];
                four[..data.len()].copy_from_slice(data);
                sdo::words(0x23 | ((4 - data.len()) as u8) << 2, object, four)
            }
            Some(data) => sdo::words(0x21, object, (data.len() as u32).to_le_bytes()),
        };
        let writes = write.is_some();
        let data = write.filter(|data| data.len() > 4).unwrap_or_default();
        let deadline = now + TIMEOUT;
        let client =
            Self { object, data, writes, toggle: 0, deadline, other: None, says_length: true };
        (client, first)
    }

    /// When the answer is overdue.
    pub const fn deadline(&self) -> Timestamp {
        self.deadline
    }

    /// The other object for which an answer came, if one did.
    pub const fn other(&self) -> Option<(u16, u8)> {
        self.other
    }

    /// Whether the device has said how many bytes it sent. If not, those that were read end with some that mean nothing.
    pub const fn says_length(&self) -> bool {
        self.says_length
    }

    /// What tells the device that the transfer is abandoned.
    pub fn give_up(&self, why: Abort) -> [u8; 8] {
        sdo::words(sdo::ABORT, self.object, why.0.to_le_bytes())
    }

    /// Takes an answer of the device.
    pub fn receive(&mut self, now: Timestamp, words: &[u8; 8]) -> Progress {
        self.deadline = now + TIMEOUT;
        match (words[0] >> 5, self.writes) {
            (2..=4, _) if sdo::object(words) != self.object => {
                self.other = Some(sdo::object(words));
                Progress::Nothing
            }
            (4, _) => Progress::Aborted(Abort(u32::from_le_bytes(sdo::data(words)))),
            (3, true) if self.data.is_empty() => Progress::Done(Vec::new()),
            (3, true) => self.segment(),
            (1, true) if words[0] & 0x10 != self.toggle ^ 0x10 => {
                Progress::Senseless(Abort::TOGGLE)
            }
            (1, true) if self.data.is_empty() => Progress::Done(Vec::new()),
            (1, true) => self.segment(),
            (2, false) if words[0] & 2 != 0 => {
                self.says_length = words[0] & 1 != 0;
                let unused = if self.says_length { usize::from(words[0] >> 2 & 3) } else { 0 };
                Progress::Done(words[4..8 - unused].to_vec())
            }
            (2, false) => Progress::Send([0x60, 0, 0, 0, 0, 0, 0, 0]),
            (0, false) if words[0] & 0x10 != self.toggle => Progress::Senseless(Abort::TOGGLE),
            (0, false) => {
                let length = sdo::SEGMENT - usize::from(words[0] >> 1 & 7);
                self.data.extend_from_slice(&words[1..=length]);
                self.toggle ^= 0x10;
                match words[0] & 1 {
                    _ if self.data.len() > BYTES_MAX => Progress::Senseless(Abort::MEMORY),
                    1 => Progress::Done(std::mem::take(&mut self.data)),
                    _ => Progress::Send([0x60 | self.toggle, 0, 0, 0, 0, 0, 0, 0]),
                }
            }
            _ => Progress::Senseless(Abort::COMMAND),
        }
    }

    /// The next segment of what is written.
    fn segment(&mut self) -> Progress {
        let part: Vec<u8> = self.data.drain(..self.data.len().min(sdo::SEGMENT)).collect();
        let words = sdo::segment(self.toggle, &part, self.data.is_empty());
        self.toggle ^= 0x10;
        Progress::Send(words)
    }
}
