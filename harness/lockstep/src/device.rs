//! A running program as a device.

use crate::family::Family;
use crate::frame;
use crate::link::{Change, SentFrame, Unsent};
use crate::output::Kept;
use crate::outside::{Given, Outside};
use crate::processor::Place;
use crate::serial_line::SerialLine;
use crate::state::{Ended, State};
use crate::talk::{Said, Talk};
use std::collections::VecDeque;
use std::mem;
use tempfile::TempDir;
use wire::device::{Device, PortId, Transmit};
use wire::packet::{BYTES_MAX, Packet};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};

/// Most items that wait for [`transmit`](Device::transmit); more are lost and counted.
const OUTBOX_MAX: usize = 65_536;
const SIGTERM: u32 = 15;

#[derive(Debug)]
pub(crate) enum Port {
    Serial(SerialLine),
    /// Index among the interfaces.
    Can(usize),
}

/// The ports, and what the program sent on them.
#[derive(Debug)]
pub(crate) struct Lines {
    ports: Vec<Port>,
    outbox: VecDeque<(PortId, Transmit)>,
    talk: Option<Talk>,
    lost: u64,
    now: Timestamp,
}

impl Lines {
    pub(crate) fn new(ports: Vec<Port>, talk: Option<Talk>) -> Self {
        Self { ports, outbox: VecDeque::new(), talk, lost: 0, now: Timestamp::ZERO }
    }
}

/// The serial port of this number among them, and its number among all ports.
fn serial_port(ports: &mut [Port], number: usize) -> Option<(usize, &mut SerialLine)> {
    let lines = ports.iter_mut().enumerate().filter_map(|(port, what)| match what {
        Port::Serial(line) => Some((port, line)),
        Port::Can(_) => None,
    });
    lines.into_iter().nth(number)
}

/// Queues what was written in one call, as packets.
fn put_bytes(outbox: &mut VecDeque<(PortId, Transmit)>, lost: &mut u64, port: usize, bytes: &[u8]) {
    for piece in bytes.chunks(BYTES_MAX) {
        if let Some(packet) = Packet::from_slice(piece) {
            put(outbox, lost, port, Transmit::Bytes(packet));
        }
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
        let Self { ports, outbox, lost, now, .. } = self;
        let Some((port, line)) = serial_port(ports, number) else { return };
        match change {
            Change::Opened => line.opened(),
            Change::Settled { is_cooked, is_marked } => line.settled(is_cooked, is_marked),
            Change::Framed(framing) => line.framed(framing),
            Change::Wrote(count) => {
                line.read_one(*now, count, |bytes| put_bytes(outbox, lost, port, bytes));
            }
        }
    }

    fn unsent(&mut self, number: usize) -> Unsent {
        let Self { ports, outbox, lost, now, .. } = self;
        let Some((port, line)) = serial_port(ports, number) else { return Unsent::default() };
        // What went through the pty has not been reported.
        line.read(*now, |bytes| put_bytes(outbox, lost, port, bytes));
        line.unsent(*now)
    }

    fn paused(&mut self) {
        let Self { ports, outbox, talk, lost, now } = self;
        for (number, port) in ports.iter_mut().enumerate() {
            let Port::Serial(line) = port else { continue };
            line.read(*now, |bytes| put_bytes(outbox, lost, number, bytes));
        }
        talk.iter_mut().for_each(Talk::read);
    }
}

/// A program in virtual time. It runs when it is [woken](Device::wake), and after something has
/// [arrived](Device::receive) when [`transmit`](Device::transmit) is called, until all of its threads and processes
/// wait: everything that arrives at one instant is there at once. Dropping it kills the program.
#[derive(Debug)]
pub struct Lockstep {
    family: Option<Family>,
    lines: Lines,
    kept: Kept,
    now: Timestamp,
    next: Timestamp,
    /// Inputs for which it has not run yet.
    given: Given,
    /// Whether it must run at once.
    is_due: bool,
    ended: Option<Ended>,
    misdirected: u64,
    /// Folder of the shim and the socket; dropped last.
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
        let (given, is_due) = (Given::default(), ended.is_none());
        let (_folder, _place) = (folder, place);
        Self {
            family,
            lines,
            kept,
            now,
            next,
            given,
            is_due,
            ended,
            misdirected: 0,
            _folder,
            _place,
        }
    }

    /// Current state of the program.
    pub fn state(&self) -> State<'_> {
        match &self.ended {
            Some(ended) => State::Ended(ended),
            None if self.next == Timestamp::MAX => State::WaitsForEver,
            None => State::Running,
        }
    }

    /// Why it no longer runs; `None` while it does.
    pub fn ended(&self) -> Option<&Ended> {
        self.ended.as_ref()
    }

    /// The end of its standard output and error, at most 1 KiB, without control characters.
    pub fn last_words(&self) -> String {
        self.kept.last_words()
    }

    /// Number of items lost: bytes that the program did not read in time, frames and bytes that were not fetched,
    /// error messages and invalid frames of the program, and data for a port that does not exist or carries another
    /// medium.
    pub fn lost(&self) -> u64 {
        let unread = self.lines.ports.iter().map(|port| match port {
            Port::Serial(line) => line.lost(),
            Port::Can(_) => 0,
        });
        unread.sum::<u64>().saturating_add(self.lines.lost).saturating_add(self.misdirected)
    }

    /// How the program has set the UART of a serial port; `None` if it has set nothing, and for other ports.
    pub fn framing(&self, port: PortId) -> Option<SerialSettings> {
        match self.lines.ports.get(usize::from(port.0)) {
            Some(Port::Serial(line)) => line.framing(),
            _ => None,
        }
    }

    /// Its process ids.
    pub fn pids(&self) -> Vec<i32> {
        self.family.iter().flat_map(Family::pids).collect()
    }

    /// Sends it SIGTERM and lets it run until it has ended, for at most `limit` of virtual time, then kills it. Its
    /// last outputs can be fetched as always; meanwhile nothing arrives. Returns whether it was in time.
    pub fn stop(&mut self, now: Timestamp, limit: Span) -> bool {
        let end = now + limit;
        self.given.signal = SIGTERM;
        self.run(now);
        while self.ended.is_none() && self.next <= end {
            self.wake(self.next);
        }
        let in_time = self.ended.is_some();
        let status = match (&self.ended, &mut self.family) {
            (Some(Ended::Exited(status)), _) => Some(*status),
            (None, Some(family)) => family.kill(),
            _ => None,
        };
        if let Some(status) = status {
            self.end(Ended::Stopped(status));
        }
        in_time
    }

    /// Kills it at once, as when its supply fails. What it had sent and was not fetched is lost.
    pub fn kill(&mut self) {
        if let Some(status) = self.family.as_mut().and_then(Family::kill) {
            self.end(Ended::Stopped(status));
        }
        self.lines.outbox.clear();
    }

    /// The CAN controller at a port has something to report: an error frame of `linux/can/error.h`, for the sockets whose
    /// filter asks for it. One that says bus-off takes the interface off the bus until one says that it has restarted:
    /// what the program sends meanwhile is lost.
    pub fn error_frame(&mut self, now: Timestamp, port: PortId, id: u32, data: [u8; 8]) {
        if let Some(Port::Can(interface)) = self.lines.ports.get(usize::from(port.0)) {
            let frame = frame::error(id, data);
            self.given.frames.push(SentFrame { interface: *interface, is_local: false, frame });
            self.has_come(now);
        }
    }

    /// Sets its wall clock (`CLOCK_REALTIME`), as `clock_settime` does: what waits for a time of that clock waits for
    /// another moment now; all other clocks and waits go on.
    pub fn set_wall_clock(&mut self, now: Timestamp, by: Span) {
        self.given.clocks.realtime_ahead += by.as_nanos();
        self.has_come(now);
    }

    /// Writes `bytes` to its standard input, if it [talks](crate::Program::talks); returns `false` if it does not take
    /// them.
    pub fn tell(&mut self, now: Timestamp, bytes: &[u8]) -> bool {
        let is_taken = self.lines.talk.as_mut().is_some_and(|talk| talk.tell(bytes));
        self.has_come(now);
        is_taken
    }

    /// Returns the next line of its standard output, without line ending, if it [talks](crate::Program::talks).
    pub fn said(&mut self) -> Option<Said> {
        self.lines.talk.as_mut()?.said()
    }

    fn has_come(&mut self, now: Timestamp) {
        if self.family.is_some() {
            (self.now, self.is_due) = (now, true);
        }
    }

    fn end(&mut self, why: Ended) {
        self.ended = Some(why);
        self.next = Timestamp::MAX;
        // Dropping the family kills all that is left of the program.
        self.family = None;
        self.lines.paused();
        self.kept.hand_on();
    }

    /// The clock may have been set back since the last run.
    fn run(&mut self, now: Timestamp) {
        self.now = now;
        self.is_due = false;
        let mut given = mem::take(&mut self.given);
        self.given.clocks = given.clocks;
        given.clocks.now = now.as_nanos();
        self.lines.now = now;
        let Some(family) = &mut self.family else { return };
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
        match (self.lines.ports.get_mut(usize::from(port.0)), what) {
            (Some(Port::Serial(line)), Transmit::Bytes(bytes)) => {
                self.given.bytes_came |= line.write(bytes.as_slice());
            }
            (Some(Port::Can(interface)), Transmit::Frame(frame)) => {
                let frame = frame::encode(frame);
                self.given.frames.push(SentFrame { interface: *interface, is_local: false, frame });
            }
            _ => {
                self.misdirected = self.misdirected.saturating_add(1);
                return;
            }
        }
        self.has_come(now);
    }

    fn wake(&mut self, now: Timestamp) {
        self.run(now);
    }

    fn next_wakeup(&self) -> Timestamp {
        if self.is_due { self.now } else { self.next }
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        if self.is_due {
            self.run(now);
        }
        self.lines.outbox.pop_front()
    }
}
