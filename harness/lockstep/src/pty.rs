//! A serial line: a pty whose one side the program opens under a name that we choose.

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::os::fd::OwnedFd;

/// Bytes read at once.
const READ_BYTES: usize = 4_096;

/// The harness's side of a serial line.
#[derive(Debug)]
pub(crate) struct Pty {
    master: OwnedFd,
    /// Open for as long as the line is: it does not hang up when the program closes its side.
    _slave: OwnedFd,
    path: String,
    lost: u64,
}

impl Pty {
    /// A new line, raw on both sides.
    pub(crate) fn open() -> Result<Self, Errno> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let path = name.into_string().map_err(|_| Errno::ILSEQ)?;
        let ours = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(path.as_str(), ours, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        rustix::fs::fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK)?;
        Ok(Self { master, _slave: slave, path, lost: 0 })
    }

    /// Its real name, which differs between runs.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// Puts bytes on the line. What finds no room is lost and counted, as in a UART whose buffer nobody empties.
    pub(crate) fn write(&mut self, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            match rustix::io::write(&self.master, rest) {
                Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
                Err(Errno::INTR) => {}
                Ok(0) | Err(_) => break,
            }
        }
        self.lost = self.lost.saturating_add(rest.len() as u64);
    }

    /// Gives `take` all that the program wrote.
    pub(crate) fn read(&mut self, mut take: impl FnMut(&[u8])) {
        let mut buffer = [0; READ_BYTES];
        loop {
            match rustix::io::read(&self.master, &mut buffer) {
                Ok(count @ 1..) => take(buffer.get(..count).unwrap_or_default()),
                Err(Errno::INTR) => {}
                Ok(0) | Err(_) => return,
            }
        }
    }

    /// Bytes that found no room.
    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }
}
