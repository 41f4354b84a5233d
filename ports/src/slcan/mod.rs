//! CAN frames as lines on a serial line ([`wire::slcan`]), from both ends.
//!
//! * [`SlcanHost`]: an adapter on a serial port is used from here.
//! * [`SlcanAdapter`]: an adapter is played here, on a pty. Who opens its far side has a CAN bus where the
//!   kernel has none, or, with `slcand`, an interface of the kernel whose error state is driven from here.

mod adapter;
mod host;
#[cfg(test)]
mod tests;

pub use adapter::SlcanAdapter;
pub use host::SlcanHost;

use wire::packet::BYTES_MAX;
use wire::serial::SerialSettings;
use wire::slcan::CR;

/// What an adapter's port is set to where nothing is said. Assumption: a USB adapter takes any rate, and
/// those with a UART are often set to this one.
pub const USUAL: SerialSettings = SerialSettings::new_8n1(115_200);

/// Shortest line that becomes an event: `e0` and its end.
const EVENT_BYTES_MIN: usize = 3;
/// Events in what is read at once.
const EVENTS_MAX: usize = BYTES_MAX / EVENT_BYTES_MIN + 1;

/// Makes a line that was cut short one that nobody takes for a frame: no digit, and an end. An end alone
/// would not do: the Linux driver takes missing digits from the line before.
const SPOILED: &[u8] = b"!\r";

/// Hands lines to a serial line whole. What is left of one that found room in part goes before the next, so
/// that the other side does not take the two for one.
#[derive(Debug, Default)]
struct Lines {
    owed: &'static [u8],
}

impl Lines {
    /// `send` says how many bytes found room. `false` when the line does not get across. One that lacks
    /// nothing but its end does, with the next or when [the rest](Self::finish) goes.
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

    /// Sends what is left of the last line; `false` when it still finds no room.
    fn finish(&mut self, mut send: impl FnMut(&[u8]) -> usize) -> bool {
        if !self.owed.is_empty() {
            let taken = send(self.owed);
            self.owed = self.owed.get(taken..).unwrap_or_default();
        }
        self.owed.is_empty()
    }
}
