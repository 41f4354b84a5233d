//! One end of a line or bus: how fast it goes where the medium itself has no pace, and what goes wrong.
//!
//! Faults are of the link and of what leaves the device; the device behind it knows nothing of them.

use crate::link::SerialLine;
use emulators::random::RandomStream;
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// Outputs that wait to be handed to the port; more are dropped and counted.
pub const READY_MAX: usize = 256;
/// CAN identifiers whose last frame is kept, to be sent again by [`LinkFault::Stuck`]. The base has two.
const LAST_FRAMES_MAX: usize = 8;

/// What a device sends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Output {
    /// On a serial line.
    Bytes(Packet),
    /// On a CAN bus.
    Frame(CanFrame),
}

/// What makes bytes take their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// The medium itself: a UART, a bus.
    Medium,
    /// A pty has none: bytes are held back as a line of these settings would.
    Line(SerialSettings),
}

/// What goes wrong with all that a device sends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LinkFault {
    /// Nothing gets through: a broken wire.
    Silent,
    /// In place of each output the last one before the fault, of a CAN device the last of each
    /// identifier: an output register that no one fills any more.
    Stuck,
    /// Each byte, on a bus each frame, is lost with this probability.
    Drop {
        /// Within 0 to 1.
        share: f64,
    },
    /// Each output comes later by this, and none is lost: a converter that buffers, a device that is slow to
    /// answer.
    Delay {
        /// How much later.
        by: Span,
    },
}

/// What faults have done so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinkCounters {
    /// Outputs that a silent link swallowed.
    pub silenced: u64,
    /// Outputs in whose place an earlier one was sent.
    pub stuck: u64,
    /// Bytes or frames lost one by one.
    pub lost: u64,
    /// Outputs that came later.
    pub delayed: u64,
    /// Outputs and inputs for which a queue had no room.
    pub overflowed: u64,
}

/// The end of a line or bus that belongs to a device.
#[derive(Debug)]
pub struct Link {
    lines: Option<Lines>,
    /// Outputs that come later, and when.
    held: VecDeque<(Timestamp, Output)>,
    ready: VecDeque<Output>,
    fault: Option<(LinkFault, Timestamp)>,
    chance: RandomStream,
    last_bytes: Option<Packet>,
    last_frames: Vec<CanFrame>,
    counters: LinkCounters,
}

/// Both directions of a line that is paced here.
#[derive(Debug)]
struct Lines {
    to_device: SerialLine,
    from_device: SerialLine,
}

impl Link {
    /// A link without faults; `device` and `seed` key its random numbers.
    pub fn new(pace: Pace, seed: u64, device: &str) -> Self {
        Self {
            lines: match pace {
                Pace::Medium => None,
                Pace::Line(settings) => Some(Lines {
                    to_device: SerialLine::new(settings),
                    from_device: SerialLine::new(settings),
                }),
            },
            held: VecDeque::new(),
            ready: VecDeque::new(),
            fault: None,
            chance: RandomStream::new(seed, device, "link loss"),
            last_bytes: None,
            last_frames: Vec::new(),
            counters: LinkCounters::default(),
        }
    }

    /// From now on this goes wrong, before `until`; in place of what went wrong so far.
    pub fn set_fault(&mut self, fault: LinkFault, until: Timestamp) {
        self.fault = Some((fault, until));
    }

    /// Nothing goes wrong any more.
    pub fn clear_fault(&mut self) {
        self.fault = None;
    }

    /// Bytes from the port: at once for the device where the medium has a pace, else none yet.
    pub fn receive(&mut self, now: Timestamp, bytes: Packet) -> Option<Packet> {
        match &mut self.lines {
            None => Some(bytes),
            Some(lines) => {
                lines.to_device.send(now, bytes);
                None
            }
        }
    }

    /// Bytes that have come through to the device by `now`.
    pub fn arrived(&mut self, now: Timestamp) -> Option<Packet> {
        self.lines.as_mut()?.to_device.arrived(now)
    }

    /// The device sends.
    pub fn send(&mut self, now: Timestamp, output: Output) {
        let Some(output) = self.through_fault(now, output) else { return };
        let by = match self.fault {
            Some((LinkFault::Delay { by }, _)) => by,
            _ => Span::ZERO,
        };
        // What comes later is not overtaken, not even once the fault is over.
        let behind = self.held.back().map_or(now, |(at, _)| now.max(*at));
        let at = behind.max(now + by);
        if at == now {
            self.put_out(now, output);
        } else if self.held.len() < READY_MAX {
            self.counters.delayed += 1;
            self.held.push_back((at, output));
        } else {
            self.counters.overflowed += 1;
        }
    }

    fn put_out(&mut self, now: Timestamp, output: Output) {
        match (&mut self.lines, output) {
            (Some(lines), Output::Bytes(bytes)) => lines.from_device.send(now, bytes),
            (_, output) => self.make_ready(output),
        }
    }

    /// Takes what was held back, and what has left the device's line by `now`.
    pub fn wake(&mut self, now: Timestamp) {
        while let Some((at, output)) = self.held.front().copied().filter(|(at, _)| *at <= now) {
            self.held.pop_front();
            self.put_out(at, output);
        }
        while let Some(bytes) = self.lines.as_mut().and_then(|lines| lines.from_device.arrived(now))
        {
            self.make_ready(Output::Bytes(bytes));
        }
    }

    /// The next for the port.
    pub fn transmit(&mut self) -> Option<Output> {
        self.ready.pop_front()
    }

    /// When something is through next, in either direction.
    pub fn next_wakeup(&self) -> Timestamp {
        let lines = self.lines.as_ref().map_or(Timestamp::MAX, |lines| {
            lines.to_device.next_arrival().min(lines.from_device.next_arrival())
        });
        self.held.front().map_or(lines, |(at, _)| lines.min(*at))
    }

    /// What was lost, and why.
    pub fn counters(&self) -> LinkCounters {
        let lines = self.lines.as_ref();
        let on_lines =
            lines.map_or(0, |lines| lines.to_device.dropped() + lines.from_device.dropped());
        LinkCounters { overflowed: self.counters.overflowed + on_lines, ..self.counters }
    }

    fn make_ready(&mut self, output: Output) {
        if self.ready.len() < READY_MAX {
            self.ready.push_back(output);
        } else {
            self.counters.overflowed += 1;
        }
    }

    fn through_fault(&mut self, now: Timestamp, output: Output) -> Option<Output> {
        self.fault.take_if(|(_, until)| *until <= now);
        match self.fault {
            None => {
                self.remember(output);
                Some(output)
            }
            Some((LinkFault::Silent, _)) => {
                self.counters.silenced += 1;
                None
            }
            Some((LinkFault::Stuck, _)) => {
                self.counters.stuck += 1;
                self.last_like(output)
            }
            Some((LinkFault::Delay { .. }, _)) => {
                self.remember(output);
                Some(output)
            }
            Some((LinkFault::Drop { share }, _)) => self.thinned(output, share),
        }
    }

    fn remember(&mut self, output: Output) {
        match output {
            Output::Bytes(bytes) => self.last_bytes = Some(bytes),
            Output::Frame(frame) => {
                let mut kept = self.last_frames.iter_mut();
                if let Some(last) = kept.find(|last| last.id() == frame.id()) {
                    *last = frame;
                } else if self.last_frames.len() < LAST_FRAMES_MAX {
                    self.last_frames.push(frame);
                }
            }
        }
    }

    fn last_like(&self, output: Output) -> Option<Output> {
        match output {
            Output::Bytes(_) => self.last_bytes.map(Output::Bytes),
            Output::Frame(frame) => {
                let last = self.last_frames.iter().find(|last| last.id() == frame.id());
                last.copied().map(Output::Frame)
            }
        }
    }

    fn thinned(&mut self, output: Output, share: f64) -> Option<Output> {
        let chance = &mut self.chance;
        // Uniform over [-1, 1), here over [0, 1).
        let mut is_lost = || (chance.symmetric_uniform() + 1.0) / 2.0 < share;
        match output {
            Output::Frame(_) => {
                let lost = is_lost();
                self.counters.lost += u64::from(lost);
                (!lost).then_some(output)
            }
            Output::Bytes(bytes) => {
                let mut rest = Packet::new();
                for byte in bytes.as_slice() {
                    if is_lost() {
                        self.counters.lost += 1;
                    } else {
                        rest.push(*byte);
                    }
                }
                (!rest.is_empty()).then_some(Output::Bytes(rest))
            }
        }
    }
}

#[cfg(test)]
mod tests;
