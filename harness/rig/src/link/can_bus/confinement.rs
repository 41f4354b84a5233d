//! Fault confinement of ISO 11898-1: a node with too many errors becomes error-passive, then bus-off.

use wire::time::{Span, Timestamp};

/// A node is error-passive from this count on (ISO 11898-1: greater than 127).
pub const PASSIVE_FROM: u16 = 128;
/// A node is bus-off from this count on (ISO 11898-1: greater than 255).
pub const OFF_FROM: u16 = 256;
/// A bus-off node recovers after this many sequences of [`RECESSIVE_BITS`] recessive bits.
pub const SEQUENCES_TO_RECOVER: u32 = 128;
/// Length of such a sequence. The end of each frame is one: delimiter of the acknowledgement, end of frame (7) and
/// intermission (3).
pub const RECESSIVE_BITS: i64 = 11;
/// Added by a transmitter for an error.
const TRANSMITTER_STEP: u16 = 8;
/// Value of an error-passive receive counter after a good frame; the standard allows 119 to 127.
const REC_AFTER_PASSIVE: u16 = 127;

wire::words! {
    /// Error state of a node: what it may do.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
    pub enum ErrorState {
        /// Everything.
        #[default]
        Active = "error-active",
        /// It may send, with 8 bits of waiting after its own frames; its error flags are recessive.
        Passive = "error-passive",
        /// Nothing.
        Off = "bus-off",
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ErrorCounters {
    pub tec: u16,
    pub rec: u16,
    /// Sequences of recessive bits since the node went bus-off.
    sequences: u32,
    off: bool,
}

impl ErrorCounters {
    pub const fn state(&self) -> ErrorState {
        if self.off {
            ErrorState::Off
        } else if self.tec >= PASSIVE_FROM || self.rec >= PASSIVE_FROM {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Counts a destroyed frame of this node.
    pub fn transmit_error(&mut self) {
        self.tec = self.tec.saturating_add(TRANSMITTER_STEP);
        if self.tec >= OFF_FROM && !self.off {
            (self.off, self.sequences) = (true, 0);
        }
    }

    /// Counts a good frame of this node.
    pub fn transmit_success(&mut self) {
        self.tec = self.tec.saturating_sub(1);
    }

    /// Counts a destroyed frame of another node.
    pub fn receive_error(&mut self) {
        if !self.off {
            self.rec = self.rec.saturating_add(1);
        }
    }

    /// Counts a good frame of another node.
    pub fn receive_success(&mut self) {
        self.rec =
            if self.rec >= PASSIVE_FROM { REC_AFTER_PASSIVE } else { self.rec.saturating_sub(1) };
    }

    /// Counts recessive sequences of the bus; after enough of them both counters are zero.
    pub fn recessive(&mut self, sequences: u32) {
        if self.off {
            self.sequences = self.sequences.saturating_add(sequences);
            if self.sequences >= SEQUENCES_TO_RECOVER {
                *self = Self::default();
            }
        }
    }

    /// When the node recovers if the bus stays idle from `idle_since` on; never if it is not bus-off.
    pub fn recovers_at(&self, idle_since: Timestamp, bit: Span) -> Timestamp {
        if !self.off {
            return Timestamp::MAX;
        }
        let left = i64::from(SEQUENCES_TO_RECOVER.saturating_sub(self.sequences));
        idle_since + Span::from_nanos(left * RECESSIVE_BITS * bit.as_nanos())
    }
}

#[cfg(test)]
mod tests {
    use super::{ErrorCounters, ErrorState, SEQUENCES_TO_RECOVER, Span, Timestamp};
    use proptest::prelude::*;

    #[test]
    fn sixteen_errors_make_passive_and_thirty_two_off() {
        let mut node = ErrorCounters::default();
        for error in 1..=32u16 {
            node.transmit_error();
            assert_eq!(node.tec, 8 * error);
            let expected = match error {
                ..=15 => ErrorState::Active,
                16..=31 => ErrorState::Passive,
                _ => ErrorState::Off,
            };
            assert_eq!(node.state(), expected, "after {error}");
        }
        node.recessive(SEQUENCES_TO_RECOVER - 1);
        assert_eq!(node.state(), ErrorState::Off);
        node.recessive(1);
        assert_eq!(node, ErrorCounters::default());
    }

    #[test]
    fn an_idle_bus_at_500_kbit_s_brings_a_node_back_after_2816_us() {
        let mut node = ErrorCounters::default();
        (0..32).for_each(|_| node.transmit_error());
        let at = node.recovers_at(Timestamp::ZERO, Span::from_micros(2));
        assert_eq!(at, Timestamp::ZERO + Span::from_micros(128 * 11 * 2));
    }

    #[test]
    fn receivers_count_ones_and_come_back_from_passive_at_once() {
        let mut node = ErrorCounters::default();
        (0..200).for_each(|_| node.receive_error());
        assert_eq!((node.rec, node.state()), (200, ErrorState::Passive));
        node.receive_success();
        assert_eq!((node.rec, node.state()), (127, ErrorState::Active));
        node.receive_success();
        assert_eq!(node.rec, 126);
    }

    proptest! {
        /// +8 and -1, never below zero, until the node is bus-off; a receiver alone never is.
        #[test]
        fn the_counters_are_sums(events in prop::collection::vec(0u8..4, 0..400)) {
            let mut node = ErrorCounters::default();
            let mut tec = 0i32;
            for event in events {
                match event {
                    0 => { node.transmit_error(); tec += 8; }
                    1 => { node.transmit_success(); tec = (tec - 1).max(0); }
                    2 => node.receive_error(),
                    _ => node.receive_success(),
                }
                if tec >= 256 {
                    prop_assert_eq!(node.state(), ErrorState::Off);
                    break;
                }
                prop_assert_eq!(i32::from(node.tec), tec);
                prop_assert!(node.state() != ErrorState::Off);
            }
        }
    }
}
