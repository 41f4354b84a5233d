//! Traffic and losses of a port.

use std::ops::Add;

/// Declares counts, with their names and their sum.
///
/// ```ignore
/// counters! {
///     /// Bytes received from the line.
///     bytes_in,
/// }
/// ```
macro_rules! counters {
    ($($(#[$about:meta])* $name:ident,)+) => {
        /// Counts of a port since it was first opened. Counts that a medium does not have stay zero; each field names
        /// its media.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct Counters {
            $($(#[$about])* pub $name: u64,)+
        }

        impl Counters {
            /// Names and counts, for tables and records.
            pub const fn rows(&self) -> [(&'static str, u64); [$(stringify!($name)),+].len()] {
                [$((stringify!($name), self.$name)),+]
            }
        }

        impl Add for Counters {
            type Output = Self;

            /// The sum of two ports, or of a port and its underlying line.
            fn add(self, other: Self) -> Self {
                Self { $($name: self.$name.saturating_add(other.$name),)+ }
            }
        }
    };
}

counters! {
    /// Bytes received from the line, including that of slcan.
    bytes_in,
    /// Bytes sent to the line.
    bytes_out,
    /// Frames received, including remote requests.
    frames_in,
    /// Frames sent to the interface.
    frames_out,
    /// Bytes to send that found no room, or no port.
    overrun_bytes,
    /// Frames to send that found no room (`ENOBUFS`), an interface that is down, a closed adapter, or no port.
    overrun_frames,
    /// Received frames dropped because the socket's receive queue was full, or the kernel's queue before it
    /// (SocketCAN).
    receive_dropped_frames,
    /// Bytes received with a framing or parity error (serial ports with a UART).
    line_errors,
    /// Breaks received (serial ports with a UART).
    breaks,
    /// Events of the bus received: error frames, and changes of an adapter's error state.
    error_frames,
    /// CAN FD frames among those received (SocketCAN).
    fd_frames,
    /// Received frames that are not passed on: of an invalid length, or CAN FD frames (slcan).
    unsupported_frames,
    /// Lines that do not follow the slcan protocol (slcan).
    malformed_lines,
    /// Commands and frames refused by the adapter, here or on the other side (slcan).
    refused,
    /// Number of returns after a loss of the port or an interface that was down.
    returns,
}

impl Counters {
    /// True if all traffic crossed the port intact, as far as the system reports losses.
    pub const fn all_crossed(&self) -> bool {
        self.overrun_bytes == 0
            && self.overrun_frames == 0
            && self.receive_dropped_frames == 0
            && self.line_errors == 0
            && self.unsupported_frames == 0
            && self.malformed_lines == 0
    }
}
