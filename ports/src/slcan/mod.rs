//! CAN frames as lines on a serial line ([`wire::slcan`]), from both ends.
//!
//! * [`SlcanHost`]: uses an adapter on a serial port.
//! * [`SlcanAdapter`]: emulates an adapter on a pty. The program that opens its other side has a CAN bus without CAN
//!   in the kernel, or, with `slcand`, an interface of the kernel whose error state is controlled from here.

mod adapter;
mod host;
#[cfg(test)]
mod tests;

pub use adapter::SlcanAdapter;
pub use host::SlcanHost;

use wire::packet::BYTES_MAX;
use wire::serial::SerialSettings;

/// Default settings of an adapter's port. Assumption: a USB adapter accepts any rate, and those with a UART often have
/// this one.
pub const USUAL: SerialSettings = SerialSettings::new_8n1(115_200);

/// Shortest line that becomes an event: `e0` and its end.
const EVENT_BYTES_MIN: usize = 3;
/// Maximum number of events in one read.
const EVENTS_MAX: usize = BYTES_MAX / EVENT_BYTES_MIN + 1;

/// Sends whole lines to a serial line. The rest of a line that found only partial room goes before the next, so that the
/// other side reads nothing but frames, however late it reads.
#[derive(Debug, Default)]
struct Lines {
    owed: Vec<u8>,
}

impl Lines {
    /// `send` returns how many bytes found room. Returns `false` if nothing of the line did. What did not goes with the
    /// next line or with [the rest](Self::finish).
    fn send(&mut self, line: &[u8], mut send: impl FnMut(&[u8]) -> usize) -> bool {
        if !self.finish(&mut send) {
            return false;
        }
        let taken = send(line);
        if taken > 0 {
            self.owed.extend_from_slice(line.get(taken..).unwrap_or_default());
        }
        taken > 0
    }

    /// Sends the rest of the last line; `false` if it still finds no room.
    fn finish(&mut self, mut send: impl FnMut(&[u8]) -> usize) -> bool {
        if !self.owed.is_empty() {
            let taken = send(&self.owed);
            self.owed.drain(..taken.min(self.owed.len()));
        }
        self.owed.is_empty()
    }
}
