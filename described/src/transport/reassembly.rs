//! Reassembles packets on the listener's side.

use super::NEXT_PACKET;
use std::cmp::Ordering;
use wire::can::CanFrame;
use wire::j1939::{Extent, GLOBAL, Identifier, PACKET_BYTES, Transport};
use wire::time::Timestamp;

/// Maximum number of messages in progress; a new one replaces the oldest. Assumption: one per node and a few to single
/// nodes.
const UNDER_WAY_MAX: usize = 64;

/// The messages in progress on a bus.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reassembly {
    now: Timestamp,
    under_way: Vec<UnderWay>,
}

#[derive(Debug, Clone)]
struct UnderWay {
    from: Identifier,
    extent: Extent,
    /// The next packet.
    next: u8,
    /// When the announcement or the last packet came.
    at: Timestamp,
    data: Vec<u8>,
    /// Counted as damage already: the rest of it is not counted again.
    is_broken: bool,
}

impl UnderWay {
    fn is_broadcast(&self) -> bool {
        self.from.destination == GLOBAL
    }

    /// Whether this is the first sign that it will not be whole.
    fn breaks(&mut self) -> bool {
        !std::mem::replace(&mut self.is_broken, true)
    }
}

/// Effect of a frame on the messages in progress.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Heard {
    /// Nothing complete.
    Nothing,
    /// A frame that no rule of the transport allows here, or a message that will not be whole.
    Stray,
    /// The last packet of a message; with the identifier that a single frame of its group would have.
    Whole(Identifier, Vec<u8>),
}

impl Heard {
    const fn stray_if(is_stray: bool) -> Self {
        if is_stray { Self::Stray } else { Self::Nothing }
    }
}

impl Reassembly {
    pub(crate) fn reset(&mut self) {
        self.under_way.clear();
    }

    /// It is `now`. Returns how many messages to everybody will not be whole any more, because their next packet is later than
    /// T1: of one to a single node, the receiver says when to go on.
    pub(crate) fn late(&mut self, now: Timestamp) -> u64 {
        self.now = now;
        let is_late = |one: &&mut UnderWay| one.is_broadcast() && now > one.at + NEXT_PACKET;
        let late = self.under_way.iter_mut().filter(is_late);
        late.map(|one| u64::from(one.breaks())).sum()
    }

    /// Ends the message that this frame aborts, whichever end of it that is.
    pub(crate) fn aborted(&mut self, frame: &CanFrame) {
        let Some((from, Transport::Abort { .. })) = Transport::decode(frame) else { return };
        let ends = [(from.source, from.destination), (from.destination, from.source)];
        self.under_way.retain(|one| !ends.contains(&(one.from.source, one.from.destination)));
    }

    /// Takes a frame of the transport.
    pub(crate) fn frame(&mut self, frame: &CanFrame) -> Heard {
        // One that the standard does not know, such as 3 packets for 14 bytes.
        let Some((from, said)) = Transport::decode(frame) else { return Heard::Stray };
        let is_it = |one: &UnderWay| {
            one.from.source == from.source && one.from.destination == from.destination
        };
        let place = self.under_way.iter().position(is_it);
        match said {
            Transport::Announce(extent) | Transport::RequestToSend { extent, .. } => {
                let before = place.map(|place| self.under_way.remove(place));
                if self.under_way.len() >= UNDER_WAY_MAX {
                    self.under_way.remove(0);
                }
                let data = Vec::with_capacity(usize::from(extent.bytes));
                let one = UnderWay { from, extent, next: 1, at: self.now, data, is_broken: false };
                self.under_way.push(one);
                // A request that nobody answered is repeated.
                let is_cut =
                    |mut one: UnderWay| (one.is_broadcast() || one.next > 1) && one.breaks();
                Heard::stray_if(before.is_some_and(is_cut))
            }
            Transport::Data { number, bytes } => {
                let Some(place) = place else { return Heard::Stray };
                let one = &mut self.under_way[place];
                match number.cmp(&one.next) {
                    // A repetition.
                    Ordering::Less => return Heard::Nothing,
                    // A packet to one node may be repeated, a broadcast is not.
                    Ordering::Greater if one.is_broadcast() => {
                        return Heard::stray_if(one.breaks());
                    }
                    Ordering::Greater => return Heard::Stray,
                    Ordering::Equal if one.is_broken => return Heard::Nothing,
                    Ordering::Equal => {}
                }
                one.at = self.now;
                let left = usize::from(one.extent.bytes) - one.data.len();
                one.data.extend_from_slice(&bytes[..left.min(PACKET_BYTES)]);
                if one.next < one.extent.packets() {
                    one.next += 1;
                    return Heard::Nothing;
                }
                let one = self.under_way.swap_remove(place);
                Heard::Whole(Identifier { group: one.extent.group, ..from }, one.data)
            }
            Transport::Abort { .. } => {
                self.aborted(frame);
                Heard::Nothing
            }
            Transport::ClearToSend { .. } | Transport::Acknowledge(_) => Heard::Nothing,
        }
    }
}
