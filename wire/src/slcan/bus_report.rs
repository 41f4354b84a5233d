//! Bus reports of newer adapters, understood by the Linux driver.

use super::hex::parse_decimal;
use crate::can_error::{
    BusState, CanErrorEvent, ControllerProblems, ErrorCounters, ProtocolErrors, ProtocolLocation,
    ProtocolViolation,
};
use crate::packet::Packet;

/// The largest error counter that three digits hold.
const COUNTER_MAX: u16 = 999;

/// The controller's state and its error counters: `s`, a letter, three digits of the receive and three of
/// the transmit error counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateReport {
    /// The state.
    pub state: BusState,
    /// The counters; sent as at most 999.
    pub counters: ErrorCounters,
}

impl StateReport {
    pub(super) fn push_to(&self, packet: &mut Packet) {
        let letter = match self.state {
            BusState::Active => b'a',
            BusState::Warning => b'w',
            BusState::Passive => b'p',
            BusState::BusOff => b'b',
        };
        packet.extend(&[b's', letter]);
        for counter in [self.counters.rx, self.counters.tx] {
            let counter = counter.min(COUNTER_MAX);
            packet.extend(
                &[counter / 100, counter / 10 % 10, counter % 10].map(|digit| b'0' + digit as u8),
            );
        }
    }

    pub(super) fn parse(line: &[u8]) -> Option<Self> {
        let [b's', letter, rx @ .., tx_100, tx_10, tx_1] = line else { return None };
        let state = match letter {
            b'a' => BusState::Active,
            b'w' => BusState::Warning,
            b'p' => BusState::Passive,
            b'b' => BusState::BusOff,
            _ => return None,
        };
        if rx.len() != 3 {
            return None;
        }
        let tx = parse_decimal(&[*tx_100, *tx_10, *tx_1])?;
        Some(Self { state, counters: ErrorCounters { tx, rx: parse_decimal(rx)? } })
    }
}

/// Converts as the Linux driver does: the side with the larger counter is the one with errors. The driver passes on a
/// state only when it changes, and omits the counters at bus-off.
impl From<StateReport> for CanErrorEvent {
    fn from(report: StateReport) -> Self {
        let StateReport { state, counters } = report;
        let (tx, rx) = (counters.tx >= counters.rx, counters.rx >= counters.tx);
        let sides = |transmit, receive| match (tx, rx) {
            (true, true) => transmit | receive,
            (true, false) => transmit,
            _ => receive,
        };
        let controller = match state {
            BusState::Active => Some(ControllerProblems::ACTIVE),
            BusState::Warning => {
                Some(sides(ControllerProblems::TX_WARNING, ControllerProblems::RX_WARNING))
            }
            BusState::Passive => {
                Some(sides(ControllerProblems::TX_PASSIVE, ControllerProblems::RX_PASSIVE))
            }
            BusState::BusOff => None,
        };
        Self {
            controller,
            bus_off: state == BusState::BusOff,
            counters: Some(counters),
            ..Self::default()
        }
    }
}

bitflags::bitflags! {
    /// Errors on the bus: `e`, the number of letters, and one letter per error.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct BusErrors: u8 {
        /// `a`: no acknowledgement.
        const ACKNOWLEDGEMENT = 1 << 0;
        /// `b`: a dominant bit was read as recessive.
        const BIT0 = 1 << 1;
        /// `B`: a recessive bit was read as dominant.
        const BIT1 = 1 << 2;
        /// `c`: wrong checksum.
        const CRC = 1 << 3;
        /// `f`: a bit of fixed form has the wrong value.
        const FORM = 1 << 4;
        /// `o`: the controller lost a received frame.
        const RX_OVERRUN = 1 << 5;
        /// `O`: the controller lost a frame to be sent.
        const TX_OVERRUN = 1 << 6;
        /// `s`: six equal bits where stuffing forbids them.
        const STUFF = 1 << 7;
    }
}

/// The letter of each bit.
const LETTERS: [(u8, BusErrors); 8] = [
    (b'a', BusErrors::ACKNOWLEDGEMENT),
    (b'b', BusErrors::BIT0),
    (b'B', BusErrors::BIT1),
    (b'c', BusErrors::CRC),
    (b'f', BusErrors::FORM),
    (b'o', BusErrors::RX_OVERRUN),
    (b'O', BusErrors::TX_OVERRUN),
    (b's', BusErrors::STUFF),
];

impl BusErrors {
    pub(super) fn push_to(&self, packet: &mut Packet) {
        packet.extend(&[b'e', b'0' + self.bits().count_ones() as u8]);
        for (letter, error) in LETTERS {
            if self.contains(error) {
                packet.push(letter);
            }
        }
    }

    pub(super) fn parse(line: &[u8]) -> Option<Self> {
        let [b'e', count @ b'0'..=b'8', letters @ ..] = line else { return None };
        if letters.len() != usize::from(count - b'0') {
            return None;
        }
        letters.iter().try_fold(Self::empty(), |errors, letter| {
            let (_, error) = LETTERS.into_iter().find(|(known, _)| known == letter)?;
            Some(errors | error)
        })
    }
}

/// Converts as the Linux driver does.
impl From<BusErrors> for CanErrorEvent {
    fn from(errors: BusErrors) -> Self {
        let mut protocol = ProtocolViolation::default();
        for (error, violation) in [
            (BusErrors::BIT0, ProtocolErrors::BIT0),
            (BusErrors::BIT1, ProtocolErrors::BIT1),
            (BusErrors::CRC, ProtocolErrors::BIT),
            (BusErrors::FORM, ProtocolErrors::FORM),
            (BusErrors::STUFF, ProtocolErrors::STUFF),
        ] {
            protocol.errors.set(violation, errors.contains(error));
        }
        // Only one place can be named. The driver names that of the last letter, which in the order of letters here is
        // the checksum's.
        if errors.contains(BusErrors::CRC) {
            protocol.location = ProtocolLocation::CRC_SEQUENCE;
        } else if errors.contains(BusErrors::ACKNOWLEDGEMENT) {
            protocol.location = ProtocolLocation::ACKNOWLEDGEMENT_SLOT;
        }
        let mut controller = ControllerProblems::empty();
        controller.set(ControllerProblems::RX_OVERFLOW, errors.contains(BusErrors::RX_OVERRUN));
        controller.set(ControllerProblems::TX_OVERFLOW, errors.contains(BusErrors::TX_OVERRUN));
        Self {
            controller: (!controller.is_empty()).then_some(controller),
            protocol: Some(protocol),
            no_acknowledgement: errors.contains(BusErrors::ACKNOWLEDGEMENT),
            bus_error: true,
            ..Self::default()
        }
    }
}
