//! A pty as a port of a bench: with a persistent name and with counts.

use super::{Pty, PtyLink};
use crate::Counters;
use crate::error::{PortError, PortLost};
use std::path::Path;
use wire::packet::{BYTES_MAX, Packet};

/// This side of a pty pair. The other side is opened by [its path](Self::far_path), which stays the same, any number
/// of times; this side is never lost by that.
#[derive(Debug)]
pub struct PtyPort {
    pty: Pty,
    /// Kept for its removal on drop.
    _link: Option<PtyLink>,
    far_path: String,
    counters: Counters,
}

impl PtyPort {
    /// A new pair, optionally with a symbolic link to its other side. Must be called within a tokio runtime with IO
    /// enabled.
    ///
    /// # Errors
    /// If the system has no pty available, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, PortError> {
        let pty = Pty::open()?;
        let link = link.map(|link| PtyLink::make(link, pty.path())).transpose()?;
        let far_path = match &link {
            Some(link) => link.path().to_string_lossy().into_owned(),
            None => pty.path().to_owned(),
        };
        Ok(Self { pty, _link: link, far_path, counters: Counters::default() })
    }

    /// The path for the other side: the link if there is one, otherwise `/dev/pts/...`.
    pub fn far_path(&self) -> &str {
        &self.far_path
    }

    /// Whether the other side has been opened, as far as the system tells.
    pub fn was_opened(&self) -> bool {
        self.pty.was_opened()
    }

    /// The pair itself, to read the rate set by the other side or to reset the line.
    pub const fn pty(&mut self) -> &mut Pty {
        &mut self.pty
    }

    /// Waits for at least one byte. May be cancelled without loss.
    ///
    /// # Errors
    /// The system's error; a port closed on the other side is not an error.
    pub async fn receive(&mut self) -> Result<Packet, PortLost> {
        let mut buffer = [0; BYTES_MAX];
        loop {
            let count = match self.pty.read(&mut buffer).await {
                Ok(count) => count,
                Err(cause) => return Err(PortLost::from_tty(&cause)),
            };
            self.counters.bytes_in += count as u64;
            let heard = buffer.get(..count).and_then(Packet::from_slice);
            if let Some(packet) = heard.filter(|packet| !packet.is_empty()) {
                return Ok(packet);
            }
        }
    }

    /// Sends bytes at once, and returns how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let taken = self.pty.write(bytes);
        self.counters.overrun_bytes += (bytes.len() - taken) as u64;
        self.counters.bytes_out += taken as u64;
        taken
    }

    pub const fn counters(&self) -> Counters {
        self.counters
    }
}
