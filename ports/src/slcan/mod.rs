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
use wire::slcan::CR;

/// Default settings of an adapter's port. Assumption: a USB adapter accepts any rate, and those with a UART often have
/// this one.
pub const USUAL: SerialSettings = SerialSettings::new_8n1(115_200);

/// Shortest line that becomes an event: `e0` and its end.
const EVENT_BYTES_MIN: usize = 3;
/// Maximum number of events in one read.
const EVENTS_MAX: usize = BYTES_MAX / EVENT_BYTES_MIN + 1;

/// Turns a truncated line into one that cannot be taken for a frame: not a digit, and an end. An end alone is not
/// enough: the Linux driver takes missing digits from the preceding line.
const SPOILED: &[u8] = b"!\r";

/// Sends whole lines to a serial line. A line that found only partial room is terminated before the next, so that the
/// other side does not join the two.
#[derive(Debug, Default)]
struct Lines {
    owed: &'static [u8],
}

impl Lines {
    /// `send` returns how many bytes found room. Returns `false` if the line does not arrive. A line that lacks only
    /// its end does arrive, with the next one or with [the rest](Self::finish).
    fn send(&mut self, line: &[u8], mut send: impl FnMut(&[u8]) -> usize) -> bool {
        if !self.finish(&mut send) {
            return false;
        }
        let taken = send(line);
        let rest = line.get(taken..).unwrap_or_default();
        self.owed = match rest {
            _ if taken == 0 => b"",
            [] => b"",
            [CR] => b"\r",
            _ => SPOILED,
        };
        taken > 0 && rest.len() <= 1
    }

    /// Terminates a truncated last line; `false` if it still finds no room.
    fn finish(&mut self, mut send: impl FnMut(&[u8]) -> usize) -> bool {
        if !self.owed.is_empty() {
            let taken = send(self.owed);
            self.owed = self.owed.get(taken..).unwrap_or_default();
        }
        self.owed.is_empty()
    }
}
