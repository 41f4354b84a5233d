//! ISO-TP (ISO 15765-2:2016): messages of up to 4,095 bytes between two nodes on CAN, in frames of one or the other.
//!
//! A [`Channel`] is one node's end. It does no IO: time is an argument.

mod coming;
mod going;
mod settings;
#[cfg(test)]
mod tests;

pub use settings::IsoTp;

use coming::Coming;
use going::Going;
use std::collections::VecDeque;
use wire::can::{CanFrame, DATA_BYTES_MAX, FdFlags, Id, fd_length};
use wire::time::{Span, Timestamp};

/// Longest message: what a first frame can announce in 12 bits. A longer announcement is answered with an overflow.
pub(crate) const BYTES_MAX: usize = 4_095;

/// Padding of CAN FD frames without a `padding` of their own: what the standard recommends, as it has no stuff bits.
const FD_PADDING: u8 = 0xCC;

/// Upper four bits of the first byte of a frame (9.6.1).
const SINGLE: u8 = 0x0;
const FIRST: u8 = 0x1;
const CONSECUTIVE: u8 = 0x2;
const FLOW_CONTROL: u8 = 0x3;

/// Flow status of a flow control (9.6.5.1).
const CONTINUE: u8 = 0;
const WAIT: u8 = 1;
const OVERFLOW: u8 = 2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    Server,
    Client,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Received {
    pub(crate) data: Vec<u8>,
    /// It was addressed to all servers.
    pub(crate) functional: bool,
}

/// Deliberate slowness.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Slowness {
    /// Time before each flow control.
    pub(crate) flow_control: Span,
    /// Time between consecutive frames, whatever the receiver asks for; zero as the receiver asks.
    pub(crate) separation: Span,
}

#[derive(Debug, Clone)]
pub(crate) struct Channel {
    settings: IsoTp,
    end: End,
    pub(crate) slowness: Slowness,
    going: Option<Going>,
    coming: Option<Coming>,
    ready: VecDeque<CanFrame>,
    failure: Option<&'static str>,
    failures: u64,
}

impl Channel {
    pub(crate) fn new(settings: IsoTp, end: End) -> Self {
        Self {
            settings,
            end,
            slowness: Slowness::default(),
            going: None,
            coming: None,
            ready: VecDeque::new(),
            failure: None,
            failures: 0,
        }
    }

    /// Discards everything, like a node that loses power.
    pub(crate) fn reset(&mut self) {
        (self.going, self.coming, self.failure) = (None, None, None);
        self.ready.clear();
    }

    /// Sends a message of 1 to [`BYTES_MAX`] bytes; it replaces one in progress. Returns `false`, with nothing sent, for
    /// another length.
    pub(crate) fn send(&mut self, now: Timestamp, data: &[u8]) -> bool {
        if data.is_empty() || data.len() > BYTES_MAX {
            return false;
        }
        let id = self.id();
        self.going = None;
        if let Some(single) = self.single(data) {
            self.push(id, &single);
            return true;
        }
        let room = self.settings.frame_bytes();
        let length = data.len() as u16;
        let mut first = vec![FIRST << 4 | (length >> 8) as u8, length as u8];
        first.extend_from_slice(&data[..room - first.len()]);
        self.push(id, &first);
        let sent = room - 2;
        self.going = Some(Going::new(data[sent..].to_vec(), now + self.settings.n_bs));
        true
    }

    /// Sends a message in a single frame to all servers; returns `false`, with nothing sent, if it does not fit.
    pub(crate) fn send_to_all(&mut self, data: &[u8]) -> bool {
        match (self.settings.functional, self.single(data)) {
            (Some(id), Some(single)) if !data.is_empty() => {
                self.push(id, &single);
                true
            }
            _ => false,
        }
    }

    /// Takes a frame from the bus; returns the message that it completes.
    pub(crate) fn receive(&mut self, now: Timestamp, frame: &CanFrame) -> Option<Received> {
        let (hears, to_all) = match self.end {
            End::Server => (self.settings.request, self.settings.functional),
            End::Client => (self.settings.response, None),
        };
        let functional = Some(frame.id()) == to_all;
        if frame.id() != hears && !functional {
            return None;
        }
        let data = frame.data();
        let (kind, low) = data.first().map(|first| (first >> 4, first & 0xF))?;
        match (kind, data) {
            (SINGLE, _) => {
                let whole = single_content(data)?.to_vec();
                // A message to all servers leaves the one in progress alone.
                if !functional {
                    self.begin_anew();
                }
                Some(Received { data: whole, functional })
            }
            (FIRST, [_, second, rest @ ..]) if !functional => {
                let length = usize::from(low) << 8 | usize::from(*second);
                self.begin_anew();
                self.begin_coming(now, length, rest)
            }
            (CONSECUTIVE, [_, rest @ ..]) if !functional => self.consecutive(now, low, rest),
            (FLOW_CONTROL, [_, block_size, separation, ..]) if !functional => {
                self.flow_control(now, low, (*block_size, *separation));
                None
            }
            _ => None,
        }
    }

    pub(crate) fn wake(&mut self, now: Timestamp) {
        if self.going.as_ref().is_some_and(|going| going.due <= now) {
            self.go_on(now);
        }
        let Some(coming) = &mut self.coming else { return };
        if coming.answer_at <= now {
            coming.answer_at = Timestamp::MAX;
            coming.due = now + self.settings.n_cr;
            let answer =
                [FLOW_CONTROL << 4 | CONTINUE, self.settings.block_size, self.settings.st_min];
            self.push(self.id(), &answer);
        } else if coming.due <= now {
            self.end_coming("no consecutive frame within N_Cr");
        }
    }

    /// Time of the next wake-up if nothing arrives before.
    pub(crate) fn next_wakeup(&self) -> Timestamp {
        let going = self.going.as_ref().map_or(Timestamp::MAX, |going| going.due);
        let coming = self.coming.as_ref();
        going.min(coming.map_or(Timestamp::MAX, |coming| coming.due.min(coming.answer_at)))
    }

    pub(crate) fn transmit(&mut self) -> Option<CanFrame> {
        self.ready.pop_front()
    }

    /// True if nothing is being sent.
    pub(crate) fn is_idle(&self) -> bool {
        self.going.is_none() && self.ready.is_empty()
    }

    /// True while a message in several frames is sent.
    pub(crate) const fn is_sending(&self) -> bool {
        self.going.is_some()
    }

    /// True while a message in several frames arrives.
    pub(crate) const fn is_receiving(&self) -> bool {
        self.coming.is_some()
    }

    /// Why a message was not sent or received; each reason once.
    pub(crate) const fn failure(&mut self) -> Option<&'static str> {
        self.failure.take()
    }

    /// Number of messages not sent or received.
    pub(crate) const fn failures(&self) -> u64 {
        self.failures
    }

    const fn id(&self) -> Id {
        match self.end {
            End::Server => self.settings.response,
            End::Client => self.settings.request,
        }
    }

    const fn fail(&mut self, why: &'static str) {
        self.failure = Some(why);
        self.failures += 1;
    }

    /// The content of a single frame with this data, if it fits.
    fn single(&self, data: &[u8]) -> Option<Vec<u8>> {
        let length = data.len() as u8;
        let head = match data.len() {
            0..DATA_BYTES_MAX => vec![SINGLE << 4 | length],
            // The escape sequence of CAN FD: a length of its own.
            bytes if bytes + 2 <= self.settings.frame_bytes() && self.settings.fd.is_some() => {
                vec![SINGLE << 4, length]
            }
            _ => return None,
        };
        Some([&head, data].concat())
    }

    /// Queues a frame with this content, padded.
    fn push(&mut self, id: Id, content: &[u8]) {
        let frame = match self.settings.fd {
            None => {
                let mut data = content.to_vec();
                if let Some(padding) = self.settings.padding {
                    data.resize(DATA_BYTES_MAX, padding);
                }
                CanFrame::new(id, &data)
            }
            Some(_) => {
                let least = if self.settings.padding.is_some() { DATA_BYTES_MAX } else { 0 };
                let length = fd_length(content.len().max(least)).unwrap_or(content.len());
                let mut data = content.to_vec();
                data.resize(length, self.settings.padding.unwrap_or(FD_PADDING));
                CanFrame::fd(id, FdFlags { bit_rate_switch: true, error_state: false }, &data)
            }
        };
        self.ready.extend(frame);
    }
}

/// The data of a single frame, unless its length is wrong.
fn single_content(frame: &[u8]) -> Option<&[u8]> {
    match (frame.first()? & 0xF, frame.len()) {
        (0, bytes) if bytes > DATA_BYTES_MAX => {
            let length = usize::from(*frame.get(1)?);
            frame.get(2..2 + length).filter(|data| data.len() >= DATA_BYTES_MAX)
        }
        (0, _) => None,
        (length, _) => frame.get(1..1 + usize::from(length)),
    }
}
