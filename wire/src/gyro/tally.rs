//! Counting, shared by all decoders.

use super::Counters;

/// The counters of one decoder, and its lock state.
///
/// Every received byte ends in exactly one place: in a good frame, in [`Counters::bytes_discarded`], or waiting in the
/// decoder.
#[derive(Debug, Clone)]
pub(super) struct Tally {
    counters: Counters,
    locked: bool,
}

impl Tally {
    /// No input yet, out of lock.
    pub(super) const fn new() -> Self {
        let counters = Counters {
            frames: 0,
            checksum_errors: 0,
            malformed: 0,
            bytes_discarded: 0,
            resyncs: 0,
        };
        Self { counters, locked: false }
    }

    pub(super) const fn counters(&self) -> Counters {
        self.counters
    }

    pub(super) const fn is_locked(&self) -> bool {
        self.locked
    }

    /// Counts a good frame; the first one after a loss of lock is a resync, the very first one is not.
    #[inline]
    pub(super) fn good_frame(&mut self) {
        if !self.locked {
            self.locked = true;
            if self.counters.frames > 0 {
                self.counters.resyncs = self.counters.resyncs.saturating_add(1);
            }
        }
        self.counters.frames = self.counters.frames.saturating_add(1);
    }

    pub(super) fn checksum_error(&mut self) {
        self.counters.checksum_errors = self.counters.checksum_errors.saturating_add(1);
    }

    pub(super) fn malformed(&mut self) {
        self.counters.malformed = self.counters.malformed.saturating_add(1);
    }

    pub(super) fn discard(&mut self, bytes: usize) {
        self.counters.bytes_discarded = self.counters.bytes_discarded.saturating_add(bytes as u64);
    }

    pub(super) fn lose_lock(&mut self) {
        self.locked = false;
    }
}
