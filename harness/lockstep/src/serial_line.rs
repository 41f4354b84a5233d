//! A serial line: a pty, which keeps the program's settings, and a local socket, which carries the bytes while the
//! settings have no line discipline. A pty passes bytes on through a kernel thread, which would dominate the run time.

use crate::link::Unsent;
use crate::pace::Pace;
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use wire::serial::SerialSettings;
use wire::time::Timestamp;

/// First byte of a mark.
const MARK: u8 = 0xFF;
const READ_BYTES: usize = 4_096;

#[derive(Debug)]
pub(crate) struct SerialLine {
    master: OwnedFd,
    /// Kept open for the life of the line, so that it does not hang up when the program closes its side.
    _slave: OwnedFd,
    path: String,
    listener: UnixListener,
    /// One socket for each open descriptor of the program.
    ways: Vec<UnixStream>,
    is_cooked: bool,
    is_marked: bool,
    /// As the program set its UART last; `None` until then.
    framing: Option<SerialSettings>,
    pace: Pace,
    /// Bytes of a write that the program has not reported yet: they were taken while it waited in the middle of the
    /// call.
    early: usize,
    lost: u64,
}

impl SerialLine {
    /// Opens a line, raw on both sides and with the rate of these settings until the program sets another; the shim
    /// expects the socket at `socket`.
    pub(crate) fn open(socket: &Path, line: Option<SerialSettings>) -> io::Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let path = name.into_string().map_err(io::Error::other)?;
        let ours = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(path.as_str(), ours, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        if let Some(line) = line {
            settings.set_speed(line.baud)?;
        }
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        rustix::fs::fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK)?;
        let listener = UnixListener::bind(socket)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            master,
            _slave: slave,
            path,
            listener,
            ways: Vec::new(),
            is_cooked: false,
            is_marked: false,
            framing: None,
            pace: Pace::of(line),
            early: 0,
            lost: 0,
        })
    }

    /// Its real name, which differs between runs.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// Accepts the socket after the program has opened the port.
    pub(crate) fn opened(&mut self) {
        let accepted = self.listener.accept();
        if let Ok((way, _)) = accepted
            && way.set_nonblocking(true).is_ok()
        {
            self.ways.push(way);
        }
    }

    /// Takes new settings: with or without line discipline, with or without error marks.
    pub(crate) fn settled(&mut self, is_cooked: bool, is_marked: bool) {
        self.is_cooked = is_cooked;
        self.is_marked = is_marked;
    }

    pub(crate) const fn framed(&mut self, framing: SerialSettings) {
        self.framing = Some(framing);
    }

    /// What the program has set of its UART; `None` if nothing.
    pub(crate) const fn framing(&self) -> Option<SerialSettings> {
        self.framing
    }

    /// What the program has written and has not left by `now`.
    pub(crate) fn unsent(&self, now: Timestamp) -> Unsent {
        self.pace.unsent(now)
    }

    /// Puts bytes on the line; returns whether they went through the pty. What finds no room is lost and counted, as in
    /// a full UART buffer; bytes before the program has opened the line are not counted.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> bool {
        let Self { master, ways, lost, .. } = self;
        if self.is_cooked {
            put(bytes, lost, |rest| Ok(rustix::io::write(&*master, rest)?));
            return true;
        }
        // PARMRK in termios(3): a byte that could be taken for a mark is doubled.
        let marked: Vec<u8>;
        let mut bytes = bytes;
        if self.is_marked && bytes.contains(&MARK) {
            let doubled = |byte: &u8| std::iter::repeat_n(*byte, 1 + usize::from(*byte == MARK));
            marked = bytes.iter().flat_map(doubled).collect();
            bytes = &marked;
        }
        for way in ways {
            put(bytes, lost, |rest| way.write(rest));
        }
        false
    }

    /// Passes `count` bytes, written in one call, to `take`.
    pub(crate) fn read_one(&mut self, now: Timestamp, count: usize, mut take: impl FnMut(&[u8])) {
        let Self { ways, pace, early, .. } = self;
        let before = (*early).min(count);
        *early -= before;
        let mut left = count - before;
        for way in ways {
            let mut buffer = [0; READ_BYTES];
            while let Some(room @ [_, ..]) = buffer.get_mut(..left.min(READ_BYTES)) {
                match way.read(room) {
                    Ok(count @ 1..) => {
                        take(room.get(..count).unwrap_or_default());
                        pace.send(now, count);
                        left -= count;
                    }
                    Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                    Ok(0) | Err(_) => break,
                }
            }
        }
    }

    /// Passes the remaining bytes of the program to `take`.
    pub(crate) fn read(&mut self, now: Timestamp, mut take: impl FnMut(&[u8])) {
        let Self { master, ways, pace, early, .. } = self;
        let mut take = |bytes: &[u8]| {
            pace.send(now, bytes.len());
            take(bytes);
        };
        let mut take_early = |bytes: &[u8]| {
            *early += bytes.len();
            take(bytes);
        };
        ways.retain_mut(|way| get(&mut take_early, |room| way.read(room)));
        if self.is_cooked {
            get(&mut take, |room| Ok(rustix::io::read(&*master, room)?));
        }
    }

    /// Number of bytes that found no room.
    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }
}

fn put(bytes: &[u8], lost: &mut u64, mut write: impl FnMut(&[u8]) -> io::Result<usize>) {
    let mut rest = bytes;
    while !rest.is_empty() {
        match write(rest) {
            Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            // Closed: no reader misses anything.
            Err(cause) if cause.kind() == ErrorKind::BrokenPipe => return,
            Ok(0) | Err(_) => break,
        }
    }
    *lost = lost.saturating_add(rest.len() as u64);
}

/// Reads until there is no more; returns whether more may come later.
fn get(take: &mut impl FnMut(&[u8]), mut read: impl FnMut(&mut [u8]) -> io::Result<usize>) -> bool {
    let mut buffer = [0; READ_BYTES];
    loop {
        match read(&mut buffer) {
            Ok(0) => return false,
            Ok(count) => {
                take(buffer.get(..count).unwrap_or_default());
                // A read that returned less than requested has emptied the socket.
                if count < READ_BYTES {
                    return true;
                }
            }
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            Err(cause) => return cause.kind() == ErrorKind::WouldBlock,
        }
    }
}
