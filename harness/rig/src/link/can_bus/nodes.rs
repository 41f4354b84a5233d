//! The nodes of a bus that count errors, and how they go bus-off and recover.

use super::confinement::{ErrorCounters, ErrorState, RECESSIVE_BITS};
use crate::link::end_id::EndId;
use std::collections::VecDeque;
use wire::time::{Span, Timestamp};

/// Most changes of state that wait to be taken; beyond that the oldest is dropped.
pub const CHANGES_MAX: usize = 64;
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateChange {
    pub node: EndId,
    pub state: ErrorState,
    pub counters: ErrorCounters,
}

/// The nodes, and how long the bus has been idle.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    nodes: Vec<(EndId, ErrorCounters)>,
    changes: VecDeque<StateChange>,
    /// Start of the idle time, minus the part already credited to bus-off nodes.
    idle_since: Option<Timestamp>,
    bit: Span,
}

impl Nodes {
    pub(super) fn new(nodes: &[EndId], idle_since: Option<Timestamp>, bit: Span) -> Self {
        let nodes = nodes.iter().map(|node| (*node, ErrorCounters::default())).collect();
        Self { nodes, changes: VecDeque::new(), idle_since, bit }
    }

    pub(super) fn has_change(&self) -> bool {
        !self.changes.is_empty()
    }

    pub(super) fn change(&mut self) -> Option<StateChange> {
        self.changes.pop_front()
    }

    /// Error counters of a node; zero if it does not count errors.
    pub(super) fn counters(&self, node: EndId) -> ErrorCounters {
        let found = self.nodes.iter().find(|(of, _)| *of == node);
        found.map_or_else(Default::default, |(_, counters)| *counters)
    }

    pub(super) fn state(&self, node: EndId) -> ErrorState {
        self.counters(node).state()
    }

    /// Whether all possible receivers of a frame of `from` are bus-off. A node that is alone on its bus is received by
    /// the record, as without faults.
    pub(super) fn nobody_hears(&self, from: EndId) -> bool {
        let mut others = self.nodes.iter().filter(|(node, _)| *node != from).peekable();
        others.peek().is_some() && others.all(|(_, counters)| counters.state() == ErrorState::Off)
    }

    pub(super) fn idle_from(&mut self, now: Timestamp) {
        self.idle_since.get_or_insert(now);
    }

    pub(super) fn busy(&mut self) {
        self.idle_since = None;
    }

    /// Counts the end of a frame of `from` at each node. The end itself is one recessive sequence.
    pub(super) fn count(&mut self, from: EndId, destroyed: bool) {
        let Self { nodes, changes, .. } = self;
        for (node, counters) in nodes {
            let before = counters.state();
            counters.recessive(1);
            match (*node == from, destroyed) {
                (true, true) => counters.transmit_error(),
                (true, false) => counters.transmit_success(),
                (false, true) => counters.receive_error(),
                (false, false) => counters.receive_success(),
            }
            note(changes, *node, before, *counters);
        }
    }

    /// Credits the idle time until `now`; the bus may stay idle.
    pub(super) fn idle_until(&mut self, now: Timestamp) {
        let Self { nodes, changes, idle_since: Some(since), bit } = self else { return };
        let sequence = *bit * RECESSIVE_BITS;
        let sequences = (now - *since).as_nanos() / sequence.as_nanos();
        *since += sequence * sequences;
        for (node, counters) in nodes {
            let before = counters.state();
            counters.recessive(u32::try_from(sequences).unwrap_or(u32::MAX));
            note(changes, *node, before, *counters);
        }
    }

    pub(super) fn recovers_at(&self) -> Timestamp {
        let Some(since) = self.idle_since else { return Timestamp::MAX };
        let at = self.nodes.iter().map(|(_, counters)| counters.recovers_at(since, self.bit));
        at.min().unwrap_or(Timestamp::MAX)
    }
}

fn note(
    changes: &mut VecDeque<StateChange>,
    node: EndId,
    before: ErrorState,
    counters: ErrorCounters,
) {
    let state = counters.state();
    if state == before {
        return;
    }
    if changes.len() == CHANGES_MAX {
        changes.pop_front();
    }
    changes.push_back(StateChange { node, state, counters });
}

#[cfg(test)]
mod tests {
    use super::{EndId, Nodes, Span};

    const A: EndId = EndId(0);
    const B: EndId = EndId(1);

    #[test]
    fn a_node_alone_is_heard_and_one_among_those_that_are_off_is_not() {
        let bit = Span::from_micros(2);
        assert!(!Nodes::new(&[A], None, bit).nobody_hears(A));
        let mut two = Nodes::new(&[A, B], None, bit);
        assert!(!two.nobody_hears(A));
        (0..32).for_each(|_| two.count(B, true));
        assert!(two.nobody_hears(A) && !two.nobody_hears(B));
    }
}
