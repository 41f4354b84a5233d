//! A pty pair: a serial port that another process can open, with an emulated device behind it.
//!
//! Limits of a pty: it does not pace bytes, whatever rate the other side sets, and has no framing errors. The emulated
//! line does the pacing; [`Pty::baud`] reveals a wrong rate.

mod link;
mod port;

pub use link::{LinkError, PtyLink};
pub use port::PtyPort;

use super::watch::watch;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, inotify};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("failed to {step} a pty")]
#[diagnostic(help("is devpts mounted on /dev/pts, and is there room (`sysctl kernel.pty`)?"))]
pub struct PtyError {
    step: &'static str,
    source: io::Error,
}

impl PtyError {
    /// The other side does not open.
    pub const fn other_side(source: io::Error) -> Self {
        Self { step: "open the other side of", source }
    }
}

/// A pty pair. The device's side is here; the other side is opened by [name](Self::path) like a serial port, any
/// number of times: the line does not hang up in between.
#[derive(Debug)]
pub struct Pty {
    master: AsyncFd<OwnedFd>,
    /// Open as long as the pair exists: bytes sent before the port is first opened stay raw, and reading here does not
    /// fail after it is closed.
    slave: OwnedFd,
    path: String,
    /// Readable once the other side has been opened; `None` if the system watches no more files.
    opens: Option<OwnedFd>,
    overrun_bytes: u64,
}

impl Pty {
    /// A new pair, raw on both sides. Must be called within a tokio runtime with IO enabled.
    ///
    /// # Errors
    /// If the system has no pty available.
    pub fn open() -> Result<Self, PtyError> {
        let Ends { master, slave, path } = Ends::open()?;
        let master = watch(master, Interest::READABLE)
            .map_err(|source| PtyError { step: "watch", source })?;
        let opens = opens_of(&path).ok();
        Ok(Self { master, slave, path, opens, overrun_bytes: 0 })
    }

    /// The path for the other process, such as `/dev/pts/3`.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Whether the other side has been opened, as far as the system tells.
    pub fn was_opened(&self) -> bool {
        let Some(opens) = &self.opens else { return true };
        let mut opens = [PollFd::new(opens, PollFlags::IN)];
        poll(&mut opens, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }

    /// Sends bytes at once, and returns how many found room. The others are lost and counted, as in a UART with a full
    /// buffer; this never waits.
    pub fn write(&mut self, bytes: &[u8]) -> usize {
        let mut rest = bytes;
        while !rest.is_empty() {
            match rustix::io::write(self.master.get_ref(), rest) {
                // A pty accepts less than offered only when it is full.
                Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
                Err(Errno::INTR) => {}
                Ok(0) | Err(_) => break,
            }
        }
        self.overrun_bytes = self.overrun_bytes.saturating_add(rest.len() as u64);
        bytes.len() - rest.len()
    }

    /// Bytes lost because the other side does not read.
    pub const fn overrun_bytes(&self) -> u64 {
        self.overrun_bytes
    }

    /// Waits for at least one byte from the other side. May be cancelled without loss.
    ///
    /// # Errors
    /// The system's error. A port closed on the other side is not an error.
    pub async fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        self.master
            .async_io(Interest::READABLE, |master| Ok(rustix::io::read(master, &mut *buffer)?))
            .await
    }

    /// Reads the bytes that have arrived from the other side; possibly none.
    ///
    /// # Errors
    /// The system's error.
    pub fn try_read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        match rustix::io::read(self.master.get_ref(), buffer) {
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(cause) => Err(cause.into()),
        }
    }

    /// The rate set by the other side. On a real line a rate other than the device's would give only errors.
    ///
    /// # Errors
    /// The system's error.
    pub fn baud(&self) -> io::Result<u32> {
        Ok(tcgetattr(&self.slave)?.output_speed())
    }

    /// Sets the rate returned by [`baud`](Self::baud) until the other side sets another.
    ///
    /// # Errors
    /// The system's error.
    pub fn set_baud(&mut self, baud: u32) -> Result<(), PtyError> {
        let error = |cause: Errno| PtyError { step: "set the rate of", source: cause.into() };
        let mut termios = tcgetattr(&self.slave).map_err(error)?;
        termios.set_speed(baud).map_err(error)?;
        tcsetattr(&self.slave, OptionalActions::Now, &termios).map_err(error)
    }
}

/// Both sides of a new pty, raw and non-blocking, without an event loop.
#[derive(Debug)]
pub struct Ends {
    /// The device's side.
    pub master: OwnedFd,
    /// The side that is opened like a serial port.
    pub slave: OwnedFd,
    pub path: String,
}

impl Ends {
    /// # Errors
    /// If the system has no pty available.
    pub fn open() -> Result<Self, PtyError> {
        let error = |step| move |cause: Errno| PtyError { step, source: cause.into() };
        // Closed on exec: a device under test that inherited it would keep the line from hanging up.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags).map_err(error("open"))?;
        grantpt(&master).and_then(|()| unlockpt(&master)).map_err(error("unlock"))?;
        rustix::io::ioctl_fionbio(&master, true).map_err(error("configure"))?;
        let path = ptsname(&master, Vec::new()).map_err(error("name"))?;
        let path = path.into_string().map_err(|cause| PtyError {
            step: "name",
            source: io::Error::new(io::ErrorKind::InvalidData, cause),
        })?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC | OFlags::NONBLOCK;
        let slave = rustix::fs::open(path.as_str(), flags, Mode::empty()).map_err(error("open"))?;
        make_raw(&slave).map_err(error("configure"))?;
        Ok(Self { master, slave, path })
    }
}

/// A descriptor that becomes readable when this file is opened.
fn opens_of(path: &str) -> Result<OwnedFd, Errno> {
    let opens = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK)?;
    inotify::add_watch(&opens, path, inotify::WatchFlags::OPEN)?;
    Ok(opens)
}

fn make_raw(slave: impl AsFd) -> Result<(), Errno> {
    let mut termios = tcgetattr(&slave)?;
    termios.make_raw();
    tcsetattr(&slave, OptionalActions::Now, &termios)
}

#[cfg(test)]
mod tests {
    use super::Pty;
    use rustix::fs::{Mode, OFlags};
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
    use std::future::Future;
    use std::ops::RangeInclusive;
    use std::os::fd::OwnedFd;
    use std::time::Duration;

    /// Capacity of a pty without a reader: about 20 KiB on Linux.
    const CAPACITY: RangeInclusive<usize> = 4_096..=65_536;

    fn run<T>(test: impl Future<Output = T>) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            tokio::time::timeout(Duration::from_secs(10), test).await.expect("the test ends")
        })
    }

    fn opened(pty: &Pty) -> OwnedFd {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK;
        rustix::fs::open(pty.path(), flags, Mode::empty()).unwrap()
    }

    fn all_bytes() -> Vec<u8> {
        (0..=255).collect()
    }

    #[test]
    fn every_byte_crosses_unchanged_both_ways() {
        run(async {
            let mut pty = Pty::open().unwrap();
            pty.write(&all_bytes());
            // Sent before the port was opened; the terminal's default settings would alter it.
            let port = opened(&pty);
            let mut buffer = [0; 512];
            let count = rustix::io::read(&port, &mut buffer).unwrap();
            assert_eq!(buffer[..count], all_bytes());

            rustix::io::write(&port, &all_bytes()).unwrap();
            let mut heard = Vec::new();
            while heard.len() < 256 {
                let count = pty.read(&mut buffer).await.unwrap();
                heard.extend_from_slice(&buffer[..count]);
            }
            assert_eq!(heard, all_bytes());
            assert_eq!(pty.try_read(&mut buffer).unwrap(), 0);
        });
    }

    #[test]
    fn a_port_that_nobody_reads_overruns_and_never_blocks() {
        run(async {
            let mut pty = Pty::open().unwrap();
            for _ in 0..1_000 {
                pty.write(&[7; 100]);
            }
            let taken = 100_000 - usize::try_from(pty.overrun_bytes()).unwrap();
            assert!(CAPACITY.contains(&taken), "{taken}");
            let (port, mut read, mut buffer) = (opened(&pty), 0, [0; 4_096]);
            // The rest follows from the kernel's own queue.
            while read < taken {
                match rustix::io::read(&port, &mut buffer) {
                    Ok(count) => read += count,
                    Err(rustix::io::Errno::AGAIN) => tokio::task::yield_now().await,
                    Err(cause) => panic!("{cause}"),
                }
            }
            pty.write(b"again");
            assert_eq!(100_000 - taken as u64, pty.overrun_bytes());
        });
    }

    #[test]
    fn the_port_can_be_closed_and_opened_again() {
        run(async {
            let mut pty = Pty::open().unwrap();
            assert!(!pty.was_opened());
            drop(opened(&pty));
            assert!(pty.was_opened());
            let mut buffer = [0; 16];
            assert_eq!(pty.try_read(&mut buffer).unwrap(), 0);
            let port = opened(&pty);
            rustix::io::write(&port, b"hello").unwrap();
            assert_eq!(pty.read(&mut buffer).await.unwrap(), 5);
            pty.write(b"\x04\r\n");
            assert_eq!(rustix::io::read(&port, &mut buffer).unwrap(), 3);
        });
    }

    #[test]
    fn the_other_side_sets_the_rate() {
        run(async {
            let mut pty = Pty::open().unwrap();
            let port = opened(&pty);
            pty.set_baud(9_600).unwrap();
            assert_eq!(pty.baud().unwrap(), 9_600);
            let mut termios = tcgetattr(&port).unwrap();
            termios.set_speed(115_200).unwrap();
            tcsetattr(&port, OptionalActions::Now, &termios).unwrap();
            assert_eq!(pty.baud().unwrap(), 115_200);
        });
    }

    #[test]
    fn a_wait_for_bytes_may_be_called_off() {
        run(async {
            let pty = Pty::open().unwrap();
            let mut buffer = [0; 16];
            let wait = tokio::time::timeout(Duration::from_millis(5), pty.read(&mut buffer)).await;
            assert!(wait.is_err());
            rustix::io::write(opened(&pty), b"x").unwrap();
            assert_eq!(pty.read(&mut buffer).await.unwrap(), 1);
        });
    }
}
