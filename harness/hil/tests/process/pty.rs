//! A pty whose far end the process opens as its serial port, and a thread that emulates the device.

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::os::fd::OwnedFd;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Polling interval of a device.
const TICK: Duration = Duration::from_millis(1);

/// The device's end of the line.
pub struct Line(OwnedFd);

impl Line {
    /// Reads the bytes that have arrived since the last call.
    pub fn read(&mut self) -> Vec<u8> {
        let (mut all, mut buffer) = (Vec::new(), [0; 1024]);
        while let Ok(count @ 1..) = rustix::io::read(&self.0, &mut buffer) {
            all.extend_from_slice(&buffer[..count]);
        }
        all
    }

    /// Writes bytes to the line; bytes that find no room are lost, as on a real line.
    pub fn write(&mut self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.0, bytes);
    }
}

/// A device on a pty. Dropping it hangs the line up.
pub struct Device {
    /// Port for the process to open.
    pub port: String,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    // Kept open, so that the line stays raw while no other process has it open.
    _slave: OwnedFd,
}

impl Device {
    /// Calls `step` once a millisecond with the line and the number of the call.
    pub fn spawn(mut step: impl FnMut(&mut Line, u64) + Send + 'static) -> Self {
        // Close-on-exec: a master that the process inherited would never hang up.
        let master =
            openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        rustix::io::ioctl_fionbio(&master, true).unwrap();
        let port = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(port.as_str(), flags, Mode::empty()).unwrap();
        let mut termios = tcgetattr(&slave).unwrap();
        termios.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &termios).unwrap();
        let (stop, stopped) = channel();
        let thread = std::thread::spawn(move || {
            let mut line = Line(master);
            for tick in 0.. {
                step(&mut line, tick);
                if stopped.recv_timeout(TICK) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
            }
        });
        Self { port, stop: Some(stop), thread: Some(thread), _slave: slave }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
