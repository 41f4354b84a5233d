//! Network management: states, heartbeats and node guarding (CiA 301, 7.2.8 and 7.3.2).

use super::objects::Objects;
use wire::time::{Span, Timestamp};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Its boot-up message has not been sent.
    Initialising = 0,
    Stopped = 4,
    Operational = 5,
    PreOperational = 127,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    Go(State),
    ResetNode,
    ResetCommunication,
}

/// Commands and states, with their numbers in messages.
pub(super) const COMMANDS: [(i64, &str); 5] = [
    (1, "start"),
    (2, "stop"),
    (128, "pre_operational"),
    (129, "reset_node"),
    (130, "reset_communication"),
];
pub(super) const STATES: [(i64, &str); 4] =
    [(0, "boot_up"), (4, "stopped"), (5, "operational"), (127, "pre_operational")];

impl Command {
    /// The command in a message, if it is for this node.
    pub(super) fn of(data: &[u8], node_id: u8) -> Option<Self> {
        let [command, node, ..] = *data else { return None };
        if node != 0 && node != node_id {
            return None;
        }
        Some(match command {
            1 => Self::Go(State::Operational),
            2 => Self::Go(State::Stopped),
            128 => Self::Go(State::PreOperational),
            129 => Self::ResetNode,
            130 => Self::ResetCommunication,
            _ => return None,
        })
    }
}

/// Another node whose heartbeats the device awaits.
#[derive(Debug, Clone)]
pub(super) struct Consumed {
    node: u8,
    time: Span,
    /// Never until its first heartbeat.
    pub(super) due: Timestamp,
    pub(super) is_lost: bool,
}

/// The nodes of the consumer heartbeat time, 1016h.
pub(super) fn consumed(objects: &Objects) -> Vec<Consumed> {
    let values = (1..=0x7F).map_while(|sub| objects.setting(0x1016, sub));
    let known = values.map(|value| ((value >> 16) as u8, (value & 0xFFFF) as i64));
    let known = known.filter(|(node, ms)| (1..=127).contains(node) && *ms > 0);
    known
        .map(|(node, ms)| Consumed {
            node,
            time: Span::from_millis(ms),
            due: Timestamp::MAX,
            is_lost: false,
        })
        .collect()
}

impl Consumed {
    /// Takes a heartbeat; returns whether it ends a loss.
    pub(super) fn hear(&mut self, now: Timestamp, node: u8) -> bool {
        if node != self.node {
            return false;
        }
        self.due = now + self.time;
        std::mem::take(&mut self.is_lost)
    }

    /// Returns whether its heartbeat has just failed to come.
    pub(super) fn is_overdue(&mut self, now: Timestamp) -> bool {
        let is_overdue = self.due <= now;
        if is_overdue {
            (self.due, self.is_lost) = (Timestamp::MAX, true);
        }
        is_overdue
    }
}

/// When a device that awaits a heartbeat in vain leaves the operational state: the error behaviour, 1029h sub 1.
pub(super) fn after_error(objects: &Objects, state: State) -> State {
    match (objects.setting(0x1029, 1).unwrap_or(0), state) {
        (0, State::Operational) => State::PreOperational,
        (2, State::Operational | State::PreOperational) => State::Stopped,
        _ => state,
    }
}
