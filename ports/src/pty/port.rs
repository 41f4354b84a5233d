//! A pty as a port of a bench: with a name that lasts, and with counts.

use super::{Pty, PtyLink};
use crate::Counters;
use crate::error::{PortError, PortLost};
use std::path::Path;
use wire::packet::{BYTES_MAX, Packet};

/// A pty pair, this side of it. The other side is opened by [its path](Self::far_path), which stays the
/// same however often that happens; this side is never lost by it.
#[derive(Debug)]
pub struct PtyPort {
    pty: Pty,
    /// Held for its removal.
    _link: Option<PtyLink>,
    far_path: String,
    counters: Counters,
}

impl PtyPort {
    /// A new pair, with a symbolic link to its far side where one is wanted. Called within a tokio
    /// runtime that has IO enabled.
    ///
    /// # Errors
    /// When the system has no pty to give, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, PortError> {
        let pty = Pty::open()?;
        let link = link.map(|link| PtyLink::make(link, pty.path())).transpose()?;
        let far_path = match &link {
            Some(link) => link.path().to_string_lossy().into_owned(),
            None => pty.path().to_owned(),
        };
        Ok(Self { pty, _link: link, far_path, counters: Counters::default() })
    }

    /// What the other side opens: the link where there is one, else `/dev/pts/...`.
    pub fn far_path(&self) -> &str {
        &self.far_path
    }

    /// The pair itself, to look at the rate that the other side has set, or to reset the line.
    pub const fn pty(&mut self) -> &mut Pty {
        &mut self.pty
    }

    /// Waits for bytes; at least one. May be called off without losing any.
    ///
    /// # Errors
    /// What the system reports; a port that is closed on the other side is none.
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

    /// Puts bytes on the line at once, and says how many found room. The others are lost and counted.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let taken = self.pty.write(bytes);
        self.counters.overrun_bytes += (bytes.len() - taken) as u64;
        self.counters.bytes_out += taken as u64;
        taken
    }

    /// What has crossed it.
    pub const fn counters(&self) -> Counters {
        self.counters
    }
}
