//! SLCAN: CAN frames as ASCII lines over a serial line, both ends.
//!
//! The protocol of the Lawicel CAN232 and CANUSB adapters (*CANUSB manual*, *CAN232 manual*), which most
//! low-cost adapters speak and the Linux line discipline `slcan` expects. A line is ended by CR; the answer
//! is CR for done, BEL for refused, or a line:
//!
//! | from the host | meaning | answer |
//! |---|---|---|
//! | `S0` to `S8` | bit rate, closed only | CR |
//! | `s011C` | registers BTR0 and BTR1 of an SJA1000, closed only | CR |
//! | `O`, `L` | open, open listen-only; closed and with a bit rate only | CR |
//! | `C` | close; open only | CR |
//! | `t1232AA55`, `r1232` | send a data or remote frame, 11 bits of identifier | `z` CR |
//! | `T0123ABCD2AA55`, `R0123ABCD2` | the same with 29 bits | `Z` CR |
//! | `F` | read and clear the status flags; open only | `F04` CR |
//! | `Z0`, `Z1` | timestamps off, on; closed only | CR |
//! | `V`, `N` | version, serial number | `V1013` CR, `NA123` CR |
//!
//! The adapter sends frames in the same form, with four more digits if timestamps are on: milliseconds, from 0 to
//! [`TIMESTAMP_WRAP_MS`]. The Linux driver (`drivers/net/can/slcan/slcan-core.c`) also accepts two lines of newer
//! adapters: `sp130000`, the controller's state (`a`ctive, `w`arning, `p`assive, `b`us-off) with the receive and the
//! transmit error counter; and `e2ab`, a count of errors and a letter for each ([`BusErrors`]).
//!
//! Newer adapters send CAN FD frames as lines that begin with `d`, `D`, `b` or `B`. They are recognised, counted as
//! unsupported and otherwise ignored.
//!
//! [`CommandDecoder`] and [`Adapter`] are the adapter's end, [`AnswerDecoder`] the host's.
//!
//! **Loss.** Every CR and every BEL ends a line, whatever precedes it. After garbage without one the first line is
//! lost, and the second is understood; one corrupted byte costs at most [`LOST_BYTES_MAX`]. An LF at the start of a
//! line is ignored, so that a terminal with CR LF line ends works. A line has no checksum: a digit changed to another
//! digit goes unnoticed.

mod adapter;
mod answer;
mod bit_rate;
mod bus_report;
mod command;
mod decode;
mod frame_line;
mod hex;
mod line;
mod text;

pub use adapter::{Adapter, AdapterCounters, Channel, Identity, OUTPUT_LINES_MAX, TransmitFull};
pub use answer::{Answer, StatusFlags, parse_answer};
pub use bit_rate::{BitRate, BitTiming};
pub use bus_report::{BusErrors, StateReport};
pub use command::{Command, parse_command};
pub use decode::{AnswerDecoder, CommandDecoder, LineCounters};
pub use frame_line::ReceivedFrame;
pub use text::{TEXT_BYTES_MAX, Text};

use crate::packet::BYTES_MAX;

/// The longest line of a classic frame, without its terminator: an extended data frame of eight bytes with a
/// timestamp, `T1111222281122334455667788EA5F`.
pub const LINE_BYTES_MAX: usize = 30;

/// The longest line of a CAN FD frame, without its terminator: `D`, 8 digits of identifier, one of length, 128 of data
/// and 4 of timestamp. Such lines are ignored.
pub const FD_LINE_BYTES_MAX: usize = 142;

/// Maximum loss by one corrupted byte in a stream of classic lines: if it was a terminator, the line before it and the
/// line after it.
pub const LOST_BYTES_MAX: usize = 2 * (LINE_BYTES_MAX + 1);

/// A timestamp of an adapter wraps to zero after this many milliseconds (manual: 0 to 0xEA5F).
pub const TIMESTAMP_WRAP_MS: u16 = 60_000;

const _: () = assert!(LINE_BYTES_MAX < BYTES_MAX, "a line and its terminator fit a packet");

/// Ends a line; alone from the adapter: done.
pub const CR: u8 = b'\r';

/// Refused.
pub const BEL: u8 = 0x07;

/// Reason why a line was not understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineError {
    /// Not a line of the protocol.
    Malformed,
    /// Longer than [`LINE_BYTES_MAX`], and not a CAN FD frame.
    Overlong,
    /// A CAN FD frame.
    Unsupported,
}

#[cfg(test)]
mod tests;
