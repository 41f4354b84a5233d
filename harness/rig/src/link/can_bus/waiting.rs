//! Frames that wait for the bus, in the order of arbitration.

use crate::link::end_id::EndId;
use std::collections::VecDeque;
use wire::can::{CanFrame, Id};

/// By priority; of equals the first that was sent is first, so that a node's own frames keep their order. A babbling
/// node lets a thousand frames wait: nothing here looks at all of them to send one.
#[derive(Debug, Clone, Default)]
pub(super) struct Waiting(VecDeque<(EndId, CanFrame)>);

impl Waiting {
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Behind those of its priority.
    pub(super) fn push(&mut self, from: EndId, frame: CanFrame) {
        let own = priority(&frame);
        let place = self.0.partition_point(|(_, other)| priority(other) <= own);
        self.0.insert(place, (from, frame));
    }

    /// A frame that was destroyed, before those of its priority.
    pub(super) fn push_again(&mut self, from: EndId, frame: CanFrame) {
        let place = self.begin(priority(&frame));
        self.0.insert(place, (from, frame));
    }

    fn begin(&self, own: u64) -> usize {
        self.0.partition_point(|(_, other)| priority(other) < own)
    }

    /// The place of the first frame of a node that may send.
    pub(super) fn first(&self, may: impl Fn(EndId) -> bool) -> Option<usize> {
        self.0.iter().position(|(node, _)| may(*node))
    }

    pub(super) fn at(&self, place: usize) -> (EndId, CanFrame) {
        self.0[place]
    }

    pub(super) fn take(&mut self, place: usize) -> Option<(EndId, CanFrame)> {
        self.0.remove(place)
    }

    /// Whether a frame of this node has this identifier.
    pub(super) fn has(&self, of: EndId, id: Id) -> bool {
        let alike = self.0.range(self.begin(rank(id))..);
        let mut alike = alike.take_while(|(_, frame)| frame.id() == id);
        alike.any(|(node, _)| *node == of)
    }

    pub(super) fn count(&self, of: EndId) -> usize {
        self.0.iter().filter(|(node, _)| *node == of).count()
    }

    /// Forgets the frames of a node; returns how many.
    pub(super) fn forget(&mut self, of: EndId) -> usize {
        let before = self.0.len();
        self.0.retain(|(node, _)| *node != of);
        before - self.0.len()
    }
}

fn priority(frame: &CanFrame) -> u64 {
    rank(frame.id())
}

/// Lower wins. A standard identifier beats an extended one with the same leading bits.
fn rank(id: Id) -> u64 {
    match id {
        Id::Standard(id) => u64::from(id.as_raw()) << 19,
        Id::Extended(id) => {
            let raw = u64::from(id.as_raw());
            (raw >> 18) << 19 | 1 << 18 | (raw & 0x3_ffff)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{CanFrame, EndId, Waiting};
    use proptest::prelude::*;
    use wire::can::{ExtendedId, Id, StandardId};

    fn id() -> impl Strategy<Value = Id> {
        let standard = (0u16..4).prop_map(|raw| Id::Standard(StandardId::new(raw).unwrap()));
        let extended = (0u32..4)
            .prop_map(|raw| Id::Extended(ExtendedId::new((raw & 1) << 18 | raw >> 1).unwrap()));
        prop_oneof![standard, extended]
    }

    /// The identifier field as the bus sees it: 11 bits, then SRR and IDE or RTR and IDE, then 18 bits.
    fn field(id: Id) -> (u32, bool, u32) {
        match id {
            Id::Standard(id) => (id.as_raw().into(), false, 0),
            Id::Extended(id) => (id.as_raw() >> 18, true, id.as_raw() & 0x3_ffff),
        }
    }

    proptest! {
        #[test]
        fn it_is_the_stable_order_of_the_identifiers(
            sent in prop::collection::vec((0u8..3, id(), any::<bool>()), 0..20),
        ) {
            let (mut waiting, mut expected) = (Waiting::default(), Vec::new());
            for (number, (node, id, again)) in sent.into_iter().enumerate() {
                let node = EndId(node);
                let frame = CanFrame::new(id, &[number as u8]).unwrap();
                if again {
                    waiting.push_again(node, frame);
                    expected.insert(0, (node, frame));
                } else {
                    waiting.push(node, frame);
                    expected.push((node, frame));
                }
                prop_assert!(waiting.has(node, id));
                prop_assert_eq!(
                    waiting.has(EndId(7), id) || waiting.has(EndId(2), id),
                    expected.iter().any(|(node, frame)| *node == EndId(2) && frame.id() == id)
                );
            }
            expected.sort_by_key(|(_, frame)| field(frame.id()));
            let first = expected.iter().position(|(node, _)| *node != EndId(0));
            prop_assert_eq!(waiting.first(|node| node != EndId(0)), first);
            prop_assert_eq!(waiting.count(EndId(1)), waiting.clone().forget(EndId(1)));
            let order: Vec<_> = std::iter::from_fn(|| waiting.take(0)).collect();
            prop_assert_eq!(order, expected);
        }
    }
}
