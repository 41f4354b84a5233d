//! SocketCAN error frames of a changed error state, as drivers make them with `can_change_state` and `can_restart`
//! (`linux/can/error.h`).

use crate::link::{ErrorState, StateChange};
use wire::can_error::ERROR_FLAG;

const CONTROLLER: u32 = 0x004;
const BUS_OFF: u32 = 0x040;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;
const RX_PASSIVE: u8 = 0x10;
const TX_PASSIVE: u8 = 0x20;
const ACTIVE: u8 = 0x40;

/// Identifier and data of the frame for this change.
pub fn of(change: &StateChange) -> (u32, [u8; 8]) {
    let (tec, rec) = (change.counters.tec, change.counters.rec);
    let counts = |count: u16| u8::try_from(count).unwrap_or(u8::MAX);
    let (mut class, mut data) = (0, [0; 8]);
    match change.state {
        ErrorState::Off => class |= BUS_OFF,
        // Only a node that was bus-off begins again from zero; one that was error-passive has a counter of 127.
        ErrorState::Active if (tec, rec) == (0, 0) => class |= RESTARTED,
        ErrorState::Passive => {
            class |= CONTROLLER;
            // The greater counter is the cause; equal ones both are.
            data[1] |= if tec >= rec { TX_PASSIVE } else { 0 };
            data[1] |= if tec <= rec { RX_PASSIVE } else { 0 };
        }
        ErrorState::Active => {
            class |= CONTROLLER;
            data[1] = ACTIVE;
        }
    }
    // Drivers leave the counters out of the others.
    if class & CONTROLLER != 0 {
        class |= COUNTERS;
        (data[6], data[7]) = (counts(tec), counts(rec));
    }
    (ERROR_FLAG | class, data)
}

#[cfg(test)]
mod tests {
    use super::of;
    use crate::link::{EndId, ErrorCounters, StateChange};
    use wire::can_error::{BusState, CanErrorEvent};

    fn event(counters: ErrorCounters) -> CanErrorEvent {
        let change = StateChange { node: EndId(0), state: counters.state(), counters };
        let (id, data) = of(&change);
        CanErrorEvent::decode(id, &data)
    }

    #[test]
    fn each_state_has_the_frame_that_a_driver_makes() {
        let mut node = ErrorCounters::default();
        assert!(event(node).restarted, "after bus-off");
        (0..16).for_each(|_| node.transmit_error());
        let passive = event(node);
        assert_eq!(passive.bus_state(), Some(BusState::Passive));
        assert_eq!(passive.counters.map(|counters| counters.tx), Some(128));
        node.transmit_success();
        assert_eq!(event(node).bus_state(), Some(BusState::Active));
        (0..17).for_each(|_| node.transmit_error());
        assert_eq!(event(node), CanErrorEvent { bus_off: true, ..CanErrorEvent::default() });
    }
}
