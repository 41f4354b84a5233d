//! A started program as a device.

use crate::family::{Family, Given, Outside};
use crate::frame;
use crate::link::{Change, SentFrame};
use crate::output::Kept;
use crate::processor::Place;
use crate::serial_line::SerialLine;
use crate::state::{Ended, State};
use std::collections::VecDeque;
use tempfile::TempDir;
use wire::device::{Device, PortId, Transmit};
use wire::packet::{BYTES_MAX, Packet};
use wire::time::{Span, Timestamp};

/// What waits to be fetched with [`transmit`](Device::transmit); more is lost and counted.
const OUTBOX_MAX: usize = 65_536;
const SIGTERM: u32 = 15;

/// What stands behind a port.
#[derive(Debug)]
pub(crate) enum Port {
    Serial(SerialLine),
    /// By its number among the interfaces.
    Can(usize),
}

/// The ports, and what came out of them.
#[derive(Debug)]
pub(crate) struct Lines {
    ports: Vec<Port>,
    outbox: VecDeque<(PortId, Transmit)>,
    lost: u64,
}

impl Lines {
    pub(crate) fn new(ports: Vec<Port>) -> Self {
        Self { ports, outbox: VecDeque::new(), lost: 0 }
    }
}

fn put(outbox: &mut VecDeque<(PortId, Transmit)>, lost: &mut u64, port: usize, what: Transmit) {
    if outbox.len() < OUTBOX_MAX {
        outbox.push_back((PortId(port as u8), what));
    } else {
        *lost = lost.saturating_add(1);
    }
}

impl Outside for Lines {
    fn frame(&mut self, sent: &SentFrame) {
        let is_it = |port: &Port| matches!(port, Port::Can(number) if *number == sent.interface);
        let port = self.ports.iter().position(is_it);
        match (port, frame::decode(&sent.frame)) {
            (Some(port), Some(frame)) => {
                put(&mut self.outbox, &mut self.lost, port, Transmit::Frame(frame));
            }
            _ => self.lost = self.lost.saturating_add(1),
        }
    }

    fn serial(&mut self, number: usize, change: Change) {
        let lines = self.ports.iter_mut().filter_map(|port| match port {
            Port::Serial(line) => Some(line),
            Port::Can(_) => None,
        });
        let Some(line) = lines.into_iter().nth(number) else { return };
        match change {
            Change::Opened => line.opened(),
            Change::Cooked(is_cooked) => line.set_cooked(is_cooked),
        }
    }

    fn paused(&mut self) {
        let Self { ports, outbox, lost } = self;
        for (number, port) in ports.iter_mut().enumerate() {
            let Port::Serial(line) = port else { continue };
            line.read(|bytes| {
                for piece in bytes.chunks(BYTES_MAX) {
                    if let Some(packet) = Packet::from_slice(piece) {
                        put(outbox, lost, number, Transmit::Bytes(packet));
                    }
                }
            });
        }
    }
}

/// A program in virtual time. It runs when it is [woken](Device::wake) or something [arrives](Device::receive), until all
/// of its threads and processes wait. Dropping it kills what is left of it.
#[derive(Debug)]
pub struct Lockstep {
    family: Option<Family>,
    lines: Lines,
    kept: Kept,
    now: Timestamp,
    next: Timestamp,
    ended: Option<Ended>,
    misdirected: u64,
    /// Where the shim and the socket are; goes last.
    _folder: TempDir,
    _place: Option<Place>,
}

impl Lockstep {
    pub(crate) fn new(
        family: Result<Family, Ended>,
        lines: Lines,
        kept: Kept,
        (folder, place): (TempDir, Option<Place>),
    ) -> Self {
        let (family, ended) = match family {
            Ok(family) => (Some(family), None),
            Err(ended) => (None, Some(ended)),
        };
        let next = if ended.is_none() { Timestamp::ZERO } else { Timestamp::MAX };
        let now = Timestamp::ZERO;
        let (_folder, _place) = (folder, place);
        Self { family, lines, kept, now, next, ended, misdirected: 0, _folder, _place }
    }

    /// How the program stands.
    pub fn state(&self) -> State<'_> {
        match &self.ended {
            Some(ended) => State::Ended(ended),
            None if self.next == Timestamp::MAX => State::WaitsForEver,
            None => State::Running,
        }
    }

    /// Why it runs no longer; `None` while it does.
    pub fn ended(&self) -> Option<&Ended> {
        self.ended.as_ref()
    }

    /// The end of what it wrote to its standard output and error, at most 1 KiB, without control characters.
    pub fn last_words(&self) -> String {
        self.kept.last_words()
    }

    /// What found no room: bytes that the program did not read in time, frames and bytes that nobody fetched, frames
    /// that are none of classic CAN, and what was sent to a port that is none.
    pub fn lost(&self) -> u64 {
        let unread = self.lines.ports.iter().map(|port| match port {
            Port::Serial(line) => line.lost(),
            Port::Can(_) => 0,
        });
        unread.sum::<u64>().saturating_add(self.lines.lost).saturating_add(self.misdirected)
    }

    /// The numbers of its processes, as the system has them.
    pub fn pids(&self) -> Vec<i32> {
        self.family.iter().flat_map(Family::pids).collect()
    }

    /// Sends it SIGTERM and lets it run until it has ended, for at most `limit` of virtual time; then kills it. What it still
    /// sends is to be fetched as ever; what would arrive meanwhile does not.
    pub fn stop(&mut self, now: Timestamp, limit: Span) {
        let end = now + limit;
        self.run(now, Given { signal: SIGTERM, ..Given::default() });
        while self.ended.is_none() && self.next <= end {
            self.wake(self.next);
        }
        let status = match (&self.ended, &mut self.family) {
            (Some(Ended::Exited(status)), _) => Some(*status),
            (None, Some(family)) => family.kill(),
            _ => None,
        };
        if let Some(status) = status {
            self.end(Ended::Stopped(status));
        }
    }

    fn end(&mut self, why: Ended) {
        self.ended = Some(why);
        self.next = Timestamp::MAX;
        // With it goes all that is left of the program.
        self.family = None;
        self.lines.paused();
        self.kept.hand_on();
    }

    fn run(&mut self, now: Timestamp, given: Given) {
        self.now = self.now.max(now);
        let Some(family) = &mut self.family else { return };
        let given = Given { now: self.now.as_nanos(), ..given };
        match family.run(&given, &mut self.lines) {
            Ok(()) => {
                self.next = Timestamp::from_nanos(family.deadline());
                self.kept.hand_on();
            }
            Err(why) => self.end(why),
        }
    }
}

impl Device for Lockstep {
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        let given = match (self.lines.ports.get_mut(usize::from(port.0)), what) {
            (Some(Port::Serial(line)), Transmit::Bytes(bytes)) => {
                let bytes_came = line.write(bytes.as_slice());
                Given { bytes_came, ..Given::default() }
            }
            (Some(Port::Can(interface)), Transmit::Frame(frame)) => {
                let frame = frame::encode(frame);
                let sent = SentFrame { interface: *interface, is_local: false, frame };
                Given { frame: Some(sent), ..Given::default() }
            }
            _ => {
                self.misdirected = self.misdirected.saturating_add(1);
                return;
            }
        };
        self.run(now, given);
    }

    fn wake(&mut self, now: Timestamp) {
        self.run(now, Given::default());
    }

    fn next_wakeup(&self) -> Timestamp {
        self.next
    }

    fn transmit(&mut self, _now: Timestamp) -> Option<(PortId, Transmit)> {
        self.lines.outbox.pop_front()
    }
}
