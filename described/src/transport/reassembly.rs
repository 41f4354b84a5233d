//! Reassembles packets on the listener's side.

use wire::can::CanFrame;
use wire::j1939::{Extent, GLOBAL, Identifier, PACKET_BYTES, Transport};

/// Maximum number of messages in progress; a new one replaces the oldest. Assumption: one per node and a few to single
/// nodes.
const UNDER_WAY_MAX: usize = 64;

/// The messages in progress on a bus.
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

/// Effect of a frame on the messages in progress.
pub(crate) enum Heard {
    /// Nothing complete.
    Nothing,
    /// A packet out of sequence.
    Stray,
    /// The last packet of a message; with the identifier that a single frame of its group would have.
    Whole(Identifier, Vec<u8>),
}

impl Reassembly {
    pub(crate) fn reset(&mut self) {
        self.under_way.clear();
    }

    /// Takes a frame of the transport. `wants` receives the identifier that a single frame would have; messages that
    /// it rejects are ignored.
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
                    // A repetition.
                    std::cmp::Ordering::Less => return Heard::Nothing,
                    // A packet to one node may be repeated, a broadcast is not.
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
                // Either end may abort.
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
