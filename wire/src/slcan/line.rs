//! Lines ended by CR or BEL, collected in a bounded buffer.

use super::{BEL, CR, LINE_BYTES_MAX, LineError, frame_line};

const LF: u8 = b'\n';

/// Terminator of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Terminator {
    CarriageReturn,
    Bell,
}

#[derive(Debug, Clone, Default)]
pub(super) struct LineBuffer {
    bytes: [u8; LINE_BYTES_MAX],
    /// Number of received bytes; more than the buffer holds for an overlong line.
    length: usize,
}

impl LineBuffer {
    /// Takes one byte; returns the line, empty or not, when a terminator ends it.
    #[inline]
    pub(super) fn push(&mut self, byte: u8) -> Option<(Result<&[u8], LineError>, Terminator)> {
        let terminator = match byte {
            CR => Terminator::CarriageReturn,
            BEL => Terminator::Bell,
            LF if self.length == 0 => return None,
            _ => {
                if let Some(place) = self.bytes.get_mut(self.length) {
                    *place = byte;
                }
                self.length = self.length.saturating_add(1);
                return None;
            }
        };
        let length = core::mem::take(&mut self.length);
        let line = self.bytes.get(..length).ok_or_else(|| {
            if frame_line::is_fd(&self.bytes, length) {
                LineError::Unsupported
            } else {
                LineError::Overlong
            }
        });
        Some((line, terminator))
    }
}
