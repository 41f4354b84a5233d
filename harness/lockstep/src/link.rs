//! Protocol between the shim of one process and the harness, over a local stream socket.

use crate::frame::FRAME_BYTES;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::time::Duration;
use wire::serial::{Parity, SerialSettings};

/// Time limit of a read, after which the caller checks whether the process is still alive.
pub(crate) const PATIENCE: Duration = Duration::from_millis(100);

const HEAD_BYTES: usize = 16;
/// An interface, whether other processes receive the frame, and the frame.
const SENT_BYTES: usize = 8 + FRAME_BYTES;
const READ_BYTES: usize = 4_096;

/// Base of the shim's CAN interface numbers (`INDEX_BASE`).
const INDEX_BASE: u32 = 1_000;

/// A frame on the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SentFrame {
    /// Index of the declared interface, from zero.
    pub interface: usize,
    /// From a process of the program: other processes of the program receive it. Toward a process: it comes from
    /// another process of the program.
    pub is_local: bool,
    /// As in `linux/can.h`.
    pub frame: [u8; FRAME_BYTES],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Message {
    /// It has joined the lockstep, with this process id.
    Hello {
        pid: i32,
    },
    /// All of its threads wait.
    Idle {
        deadline: i64,
        progressed: bool,
        /// None of its threads goes on unless another does; the number of those that wait for each other, without
        /// those that wait for the end of a child.
        stuck: Option<u32>,
    },
    /// It is about to start a process, and already has this many without their own link.
    Fork {
        others: usize,
    },
    /// It has started one with this process id, negative on failure.
    Forked {
        pid: i32,
    },
    /// It is about to replace itself with another program.
    Exec,
    /// The replacement failed.
    ExecFailed,
    Frame(SentFrame),
    /// It did something with one of its serial ports.
    Serial(usize, Change),
    /// It asks what has not yet left one of its serial ports.
    Unsent(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    /// The port was opened.
    Opened,
    /// The settings changed: with a line discipline or without, with error marks (`PARMRK`) or without.
    Settled {
        is_cooked: bool,
        is_marked: bool,
    },
    Framed(SerialSettings),
    /// This number of bytes was written in one call.
    Wrote(usize),
}

/// What a program wrote to a serial port and has not left it yet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Unsent {
    /// When the last byte will have left.
    pub until: i64,
    pub bytes: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reading {
    Message(Message),
    /// Nothing within [`PATIENCE`].
    Silence,
    /// The other end is closed, or sent something invalid.
    End,
}

/// What the clocks of a program show.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Clocks {
    /// Nanoseconds since the start of the run.
    pub now: i64,
    /// Nanoseconds by which the wall clock has been set since then.
    pub realtime_ahead: i64,
}

/// Inputs for a process when it may run.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    pub clocks: Clocks,
    /// Signal to raise, or zero.
    pub signal: u32,
    /// Whether bytes have been put on a serial line.
    pub bytes_came: bool,
    /// Frames for its CAN sockets.
    pub frames: Vec<SentFrame>,
}

#[derive(Debug)]
pub(crate) struct Link {
    stream: UnixStream,
    buffer: Vec<u8>,
    /// Bytes of the buffer that have been consumed.
    taken: usize,
    out: Vec<u8>,
}

impl Link {
    pub(crate) fn new(stream: UnixStream) -> io::Result<Self> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE * 10))?;
        Ok(Self { stream, buffer: Vec::new(), taken: 0, out: Vec::new() })
    }

    pub(crate) fn read(&mut self) -> Reading {
        loop {
            let rest = self.buffer.get(self.taken..).unwrap_or_default();
            match parse(rest) {
                Parsed::Whole(message, bytes) => {
                    self.taken += bytes;
                    return Reading::Message(message);
                }
                Parsed::Wrong => return Reading::End,
                Parsed::Partial => {}
            }
            self.buffer.drain(..self.taken);
            self.taken = 0;
            let start = self.buffer.len();
            self.buffer.resize(start + READ_BYTES, 0);
            let result = self.stream.read(self.buffer.get_mut(start..).unwrap_or_default());
            self.buffer.truncate(start + *result.as_ref().unwrap_or(&0));
            match result {
                Ok(0) => return Reading::End,
                Ok(_) => {}
                Err(cause) => match cause.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => return Reading::Silence,
                    ErrorKind::Interrupted => {}
                    _ => return Reading::End,
                },
            }
        }
    }

    /// Sends the configuration to a new process: lines of a word and its value.
    pub(crate) fn configure(&mut self, text: &str) -> io::Result<()> {
        self.out.clear();
        self.out.extend((text.len() as u32).to_ne_bytes());
        self.out.extend(text.as_bytes());
        self.stream.write_all(&self.out)
    }

    pub(crate) fn run(&mut self, turn: &Turn) -> io::Result<()> {
        self.out.clear();
        let bytes_came = u32::from(turn.bytes_came);
        for word in [1, turn.frames.len() as u32, turn.signal, bytes_came] {
            self.out.extend(word.to_ne_bytes());
        }
        self.out.extend(turn.clocks.now.to_ne_bytes());
        self.out.extend(turn.clocks.realtime_ahead.to_ne_bytes());
        for sent in &turn.frames {
            self.out.extend((sent.interface as u32 + INDEX_BASE).to_ne_bytes());
            self.out.extend(u32::from(sent.is_local).to_ne_bytes());
            self.out.extend(sent.frame);
        }
        self.stream.write_all(&self.out)
    }

    pub(crate) fn answer(&mut self, may: bool) -> io::Result<()> {
        self.out.clear();
        self.out.extend((if may { 2u32 } else { 3 }).to_ne_bytes());
        self.out.extend([0; 28]);
        self.stream.write_all(&self.out)
    }

    pub(crate) fn tell_unsent(&mut self, unsent: Unsent) -> io::Result<()> {
        self.out.clear();
        for word in [2, 0, 0, unsent.bytes] {
            self.out.extend(word.to_ne_bytes());
        }
        self.out.extend(unsent.until.to_ne_bytes());
        self.out.extend([0; 8]);
        self.stream.write_all(&self.out)
    }
}

enum Parsed {
    Whole(Message, usize),
    Partial,
    Wrong,
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_ne_bytes)
}

fn parse(bytes: &[u8]) -> Parsed {
    let head = || {
        let argument = bytes.get(8..16)?.try_into().ok().map(i64::from_ne_bytes)?;
        Some((word(bytes, 0)?, word(bytes, 4)?, argument))
    };
    let Some((kind, flag, argument)) = head() else { return Parsed::Partial };
    let pid = i32::try_from(argument).unwrap_or(-1);
    let message = match kind {
        // A greeting and a frame include the space of a frame.
        1 | 7 => {
            let Some(sent) = bytes.get(HEAD_BYTES..HEAD_BYTES + SENT_BYTES) else {
                return Parsed::Partial;
            };
            let message = if kind == 1 { Some(Message::Hello { pid }) } else { frame_of(sent) };
            return message
                .map_or(Parsed::Wrong, |message| Parsed::Whole(message, HEAD_BYTES + SENT_BYTES));
        }
        2 => Message::Idle {
            deadline: argument,
            progressed: flag & 1 != 0,
            stuck: (flag & 2 != 0).then_some(flag >> 2),
        },
        3 => Message::Fork { others: usize::try_from(argument).unwrap_or(usize::MAX) },
        4 => Message::Forked { pid },
        5 => Message::Exec,
        6 => Message::ExecFailed,
        8 => Message::Serial(flag as usize, Change::Opened),
        9 => {
            let (is_cooked, is_marked) = (argument & 1 != 0, argument & 2 != 0);
            Message::Serial(flag as usize, Change::Settled { is_cooked, is_marked })
        }
        10 => Message::Serial(flag as usize, Change::Wrote(usize::try_from(argument).unwrap_or(0))),
        11 => Message::Serial(flag as usize, Change::Framed(framing(argument))),
        12 => Message::Unsent(flag as usize),
        _ => return Parsed::Wrong,
    };
    Parsed::Whole(message, HEAD_BYTES)
}

/// As the shim packs it in `serial_framed`.
const fn framing(packed: i64) -> SerialSettings {
    SerialSettings {
        baud: packed as u32,
        data_bits: (packed >> 32 & 0xF) as u8,
        parity: match packed >> 36 & 0xF {
            1 => Parity::Odd,
            2 => Parity::Even,
            _ => Parity::None,
        },
        stop_bits: (packed >> 40 & 0xF) as u8,
    }
}

fn frame_of(sent: &[u8]) -> Option<Message> {
    let interface = word(sent, 0)?.checked_sub(INDEX_BASE)? as usize;
    let frame = sent.get(8..8 + FRAME_BYTES)?.try_into().ok()?;
    Some(Message::Frame(SentFrame { interface, is_local: word(sent, 4)? != 0, frame }))
}
