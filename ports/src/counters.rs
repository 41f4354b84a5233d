//! Traffic and losses of a port.

use std::ops::Add;

/// Counts of a port since it was first opened. Counts that a medium does not have stay zero; each field names its
/// media.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Bytes received from the line, including that of slcan.
    pub bytes_in: u64,
    /// Bytes sent to the line.
    pub bytes_out: u64,
    /// Frames received, including remote requests.
    pub frames_in: u64,
    /// Frames sent to the interface.
    pub frames_out: u64,
    /// Bytes to send that found no room, or no port.
    pub overrun_bytes: u64,
    /// Frames to send that found no room (`ENOBUFS`), an interface that is down, a closed adapter, or no port.
    pub overrun_frames: u64,
    /// Received frames dropped because the socket's receive queue was full, or the kernel's queue before it
    /// (SocketCAN).
    pub receive_dropped_frames: u64,
    /// Bytes received with a framing or parity error (serial ports with a UART).
    pub line_errors: u64,
    /// Breaks received (serial ports with a UART).
    pub breaks: u64,
    /// Events of the bus received: error frames, and changes of an adapter's error state.
    pub error_frames: u64,
    /// CAN FD frames among those received (SocketCAN).
    pub fd_frames: u64,
    /// Received frames that are not passed on: of an invalid length, or CAN FD frames (slcan).
    pub unsupported_frames: u64,
    /// Lines that do not follow the slcan protocol (slcan).
    pub malformed_lines: u64,
    /// Commands and frames refused by the adapter, here or on the other side (slcan).
    pub refused: u64,
    /// Number of returns after a loss of the port or an interface that was down.
    pub returns: u64,
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

    /// Names and counts, for tables and records.
    pub const fn rows(&self) -> [(&'static str, u64); 15] {
        [
            ("bytes_in", self.bytes_in),
            ("bytes_out", self.bytes_out),
            ("frames_in", self.frames_in),
            ("frames_out", self.frames_out),
            ("overrun_bytes", self.overrun_bytes),
            ("overrun_frames", self.overrun_frames),
            ("receive_dropped_frames", self.receive_dropped_frames),
            ("line_errors", self.line_errors),
            ("breaks", self.breaks),
            ("error_frames", self.error_frames),
            ("fd_frames", self.fd_frames),
            ("unsupported_frames", self.unsupported_frames),
            ("malformed_lines", self.malformed_lines),
            ("refused", self.refused),
            ("returns", self.returns),
        ]
    }
}

impl Add for Counters {
    type Output = Self;

    /// The sum of two ports, or of a port and its underlying line.
    fn add(self, other: Self) -> Self {
        Self {
            bytes_in: self.bytes_in.saturating_add(other.bytes_in),
            bytes_out: self.bytes_out.saturating_add(other.bytes_out),
            frames_in: self.frames_in.saturating_add(other.frames_in),
            frames_out: self.frames_out.saturating_add(other.frames_out),
            overrun_bytes: self.overrun_bytes.saturating_add(other.overrun_bytes),
            overrun_frames: self.overrun_frames.saturating_add(other.overrun_frames),
            receive_dropped_frames: self
                .receive_dropped_frames
                .saturating_add(other.receive_dropped_frames),
            line_errors: self.line_errors.saturating_add(other.line_errors),
            breaks: self.breaks.saturating_add(other.breaks),
            error_frames: self.error_frames.saturating_add(other.error_frames),
            fd_frames: self.fd_frames.saturating_add(other.fd_frames),
            unsupported_frames: self.unsupported_frames.saturating_add(other.unsupported_frames),
            malformed_lines: self.malformed_lines.saturating_add(other.malformed_lines),
            refused: self.refused.saturating_add(other.refused),
            returns: self.returns.saturating_add(other.returns),
        }
    }
}
