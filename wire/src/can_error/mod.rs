//! Error reports of a CAN controller: SocketCAN's error frames.
//!
//! An error frame has the flag [`ERROR_FLAG`] in its identifier, a bit for each class that it reports, and eight bytes
//! of detail (`linux/can/error.h`). [`CanErrorEvent`] is one decoded frame.

mod detail;
mod display;
mod kind;
mod state;

pub use detail::{
    ControllerProblems, ProtocolErrors, ProtocolLocation, ProtocolViolation, Transceiver,
};
pub use kind::ErrorKind;
pub use state::BusState;

use serde::{Deserialize, Serialize};

/// Marks an error frame among others (`CAN_ERR_FLAG` of `linux/can.h`).
pub const ERROR_FLAG: u32 = 0x2000_0000;

/// The classes of an error frame (`CAN_ERR_MASK`).
const CLASS_MASK: u32 = 0x1FFF_FFFF;

const TX_TIMEOUT: u32 = 0x001;
const LOST_ARBITRATION: u32 = 0x002;
const CONTROLLER: u32 = 0x004;
const PROTOCOL: u32 = 0x008;
const TRANSCEIVER: u32 = 0x010;
const NO_ACKNOWLEDGEMENT: u32 = 0x020;
const BUS_OFF: u32 = 0x040;
const BUS_ERROR: u32 = 0x080;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;
const KNOWN: u32 = 0x3FF;

/// The error counters of a controller (ISO 11898-1, fault confinement).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ErrorCounters {
    /// Transmit error counter. It counts up to 256, which is bus-off.
    pub tx: u16,
    /// Receive error counter.
    pub rx: u16,
}

/// One error frame. It can report several problems at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CanErrorEvent {
    /// A frame was not sent within the driver's time-out.
    pub tx_timeout: bool,
    /// Arbitration was lost in this bit of the frame; 0 if the bit is unknown.
    pub lost_arbitration: Option<u8>,
    /// Problems of the controller's buffers or error state; empty if unspecified.
    pub controller: Option<ControllerProblems>,
    /// A protocol rule was violated.
    pub protocol: Option<ProtocolViolation>,
    /// The transceiver sees a broken wire or a short circuit.
    pub transceiver: Option<Transceiver>,
    /// No node acknowledged a frame.
    pub no_acknowledgement: bool,
    /// The controller left the bus.
    pub bus_off: bool,
    /// An error on the bus; comes with most of the others.
    pub bus_error: bool,
    /// The controller came back from bus-off.
    pub restarted: bool,
    /// The error counters, if the frame contains them.
    pub counters: Option<ErrorCounters>,
    /// Bits of unknown classes.
    pub unknown_classes: u32,
}

impl CanErrorEvent {
    /// Decodes an error frame: its identifier, with or without [`ERROR_FLAG`], and its data. Missing bytes count as
    /// zero.
    pub fn decode(id: u32, data: &[u8]) -> Self {
        let classes = id & CLASS_MASK;
        let has = |class| classes & class != 0;
        let byte = |place: usize| data.get(place).copied().unwrap_or_default();
        Self {
            tx_timeout: has(TX_TIMEOUT),
            lost_arbitration: has(LOST_ARBITRATION).then(|| byte(0)),
            controller: has(CONTROLLER).then(|| ControllerProblems::from_bits_retain(byte(1))),
            protocol: has(PROTOCOL).then(|| ProtocolViolation {
                errors: ProtocolErrors::from_bits_retain(byte(2)),
                location: ProtocolLocation(byte(3)),
            }),
            transceiver: has(TRANSCEIVER).then(|| Transceiver(byte(4))),
            no_acknowledgement: has(NO_ACKNOWLEDGEMENT),
            bus_off: has(BUS_OFF),
            bus_error: has(BUS_ERROR),
            restarted: has(RESTARTED),
            counters: has(COUNTERS)
                .then(|| ErrorCounters { tx: byte(6).into(), rx: byte(7).into() }),
            unknown_classes: classes & !KNOWN,
        }
    }

    /// The controller's state after this event; `None` if the event does not report it.
    pub fn bus_state(&self) -> Option<BusState> {
        if self.bus_off {
            return Some(BusState::BusOff);
        }
        let problems = self.controller.unwrap_or_default();
        if problems.intersects(ControllerProblems::TX_PASSIVE | ControllerProblems::RX_PASSIVE) {
            Some(BusState::Passive)
        } else if problems
            .intersects(ControllerProblems::TX_WARNING | ControllerProblems::RX_WARNING)
        {
            Some(BusState::Warning)
        } else if self.restarted || problems.contains(ControllerProblems::ACTIVE) {
            Some(BusState::Active)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests;
