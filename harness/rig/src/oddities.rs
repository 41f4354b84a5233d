//! What is odd about the messages of one end of a line, counted for the remarks at the end of a run.

use described::{Decoded, Verdict};
use plan::identifiers::Identifiers;
use std::collections::BTreeMap;

/// What is odd about the messages of one end of a line.
#[derive(Debug, Clone, Default)]
pub(crate) struct Oddities {
    /// How often each signal was out of its range, by message and signal.
    pub(crate) out_of_range: BTreeMap<(usize, usize), u64>,
    /// Messages with a wrong checksum, by message.
    pub(crate) wrong_checksums: BTreeMap<usize, u64>,
    /// Frames that are none of its messages.
    pub(crate) unexpected: Identifiers,
    /// Frames from a port with its identifiers, although this run sends its messages.
    pub(crate) doubled: Identifiers,
    /// Remote requests for its messages.
    pub(crate) requested: Identifiers,
}

impl Oddities {
    #[inline]
    pub fn see(&mut self, decoded: &Decoded<'_>) {
        for signal in decoded.out_of_range() {
            *self.out_of_range.entry((decoded.message, signal)).or_default() += 1;
        }
        if decoded.verdict == Some(Verdict::WrongChecksum) {
            *self.wrong_checksums.entry(decoded.message).or_default() += 1;
        }
    }
}
