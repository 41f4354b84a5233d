//! Packets put together again, by whoever listens.

use wire::can::CanFrame;
use wire::j1939::{Extent, GLOBAL, Identifier, PACKET_BYTES, Transport};

/// Messages that are under way at once; the oldest makes room for another. Assumption: one a node and a few to single ones.
const UNDER_WAY_MAX: usize = 64;

/// The messages that are under way on a bus.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reassembly {
    under_way: Vec<UnderWay>,
}

#[derive(Debug, Clone)]
struct UnderWay {
    from: Identifier,
    extent: Extent,
    /// The next packet.
    next: u8,
    data: Vec<u8>,
}

/// What a frame was to the messages under way.
pub(crate) enum Heard {
    /// Nothing that is of use by itself.
    Nothing,
    /// A packet that came out of turn.
    Stray,
    /// The last packet of a message of this group; as a frame of it would have been.
    Whole(Identifier, Vec<u8>),
}

impl Reassembly {
    pub(crate) fn reset(&mut self) {
        self.under_way.clear();
    }

    /// Takes a frame of the transport. Messages that nobody `wants`, as frames of theirs would be, are passed over.
    pub(crate) fn frame(
        &mut self,
        frame: &CanFrame,
        wants: impl FnOnce(Identifier) -> bool,
    ) -> Heard {
        let Some((from, said)) = Transport::decode(frame) else { return Heard::Nothing };
        let is_it = |one: &UnderWay| {
            one.from.source == from.source && one.from.destination == from.destination
        };
        match said {
            Transport::Announce(extent) | Transport::RequestToSend { extent, .. } => {
                self.under_way.retain(|one| !is_it(one));
                if wants(Identifier { group: extent.group, ..from }) {
                    if self.under_way.len() >= UNDER_WAY_MAX {
                        self.under_way.remove(0);
                    }
                    let data = Vec::with_capacity(usize::from(extent.bytes));
                    self.under_way.push(UnderWay { from, extent, next: 1, data });
                }
                Heard::Nothing
            }
            Transport::Data { number, bytes } => {
                let Some(place) = self.under_way.iter().position(is_it) else {
                    return Heard::Nothing;
                };
                let one = &mut self.under_way[place];
                match number.cmp(&one.next) {
                    // Sent again.
                    std::cmp::Ordering::Less => return Heard::Nothing,
                    // To one node it may be sent again, to everybody it is not.
                    std::cmp::Ordering::Greater => {
                        if from.destination == GLOBAL {
                            self.under_way.swap_remove(place);
                        }
                        return Heard::Stray;
                    }
                    std::cmp::Ordering::Equal => {}
                }
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
                // Either end may break it off.
                self.under_way.retain(|one| {
                    let other_way =
                        one.from.source == from.destination && one.from.destination == from.source;
                    !is_it(one) && !other_way
                });
                Heard::Nothing
            }
            Transport::ClearToSend { .. } | Transport::Acknowledge(_) => Heard::Nothing,
        }
    }
}
