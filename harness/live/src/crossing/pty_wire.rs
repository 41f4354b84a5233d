//! A serial line as a pty with both ends in this process.

use super::wait::{LIMIT, READS_MAX, readable, shown_bytes};
use ports::pty::{Ends, PtyError};
use rig::crossing::{CrossingFailure, How, Toward};
use rustix::io::Errno;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;
use wire::packet::{BYTES_MAX, Packet};

/// Bytes per read: more than any packet, to detect surplus bytes.
const HEARD_BYTES_MAX: usize = 2 * BYTES_MAX;

/// A pty: the device is on its master, its host on its slave.
#[derive(Debug)]
pub(super) struct PtyWire {
    line: Arc<str>,
    ends: Ends,
    limit: Duration,
}

impl PtyWire {
    /// # Errors
    /// When the system has no pty to give.
    pub(super) fn open(line: Arc<str>) -> Result<Self, PtyError> {
        Ok(Self { line, ends: Ends::open()?, limit: LIMIT })
    }

    /// A wire on these ends with the time limit `limit`.
    #[cfg(test)]
    pub(super) fn of(line: Arc<str>, ends: Ends, limit: Duration) -> Self {
        Self { line, ends, limit }
    }

    /// Carries a packet, and replaces it with what was read at the other end.
    ///
    /// # Errors
    /// When it does not come out, or comes out changed.
    pub(super) fn carry(&self, toward: Toward, packet: &mut Packet) -> Result<(), CrossingFailure> {
        let (near, far) = match toward {
            Toward::Device => (&self.ends.slave, &self.ends.master),
            Toward::Host => (&self.ends.master, &self.ends.slave),
        };
        *packet = self
            .pass(near, far, packet.as_slice())
            .map_err(|how| self.failure("bytes", toward, how))?;
        Ok(())
    }

    /// A failure of what the bytes on this line carry, such as a frame.
    pub(super) fn failure(&self, goods: &str, toward: Toward, how: How) -> CrossingFailure {
        CrossingFailure::new(goods, &self.line, toward, &self.ends.path, how)
    }

    fn pass(&self, near: &OwnedFd, far: &OwnedFd, sent: &[u8]) -> Result<Packet, How> {
        let length = sent.len();
        // Nothing else is under way, so the pty has room for a packet.
        let taken = rustix::io::retry_on_intr(|| rustix::io::write(near, sent))
            .map_err(|cause| How::Write(cause.into()))?;
        if taken < length {
            return Err(How::Full { taken, length });
        }
        let mut buffer = [0; HEARD_BYTES_MAX];
        let mut count = 0;
        for _ in 0..READS_MAX {
            if count >= length {
                break;
            }
            match rustix::io::read(far, &mut buffer[count..]) {
                Ok(more @ 1..) => count += more,
                Err(Errno::AGAIN | Errno::INTR) => {
                    if !readable(far, self.limit).map_err(How::Read)? {
                        break;
                    }
                }
                Ok(0) => return Err(How::Read(Errno::PIPE.into())),
                Err(cause) => return Err(How::Read(cause.into())),
            }
        }
        let heard = &buffer[..count];
        if heard.len() < length && sent.starts_with(heard) {
            let limit_s = self.limit.as_secs_f64();
            let (heard, sent) = (shown_bytes(heard), shown_bytes(sent));
            return Err(How::Late { heard, sent, limit_s });
        }
        match Packet::from_slice(heard) {
            Some(packet) if heard == sent => Ok(packet),
            _ => Err(How::Changed { sent: shown_bytes(sent), heard: shown_bytes(heard) }),
        }
    }
}
