//! The messages of a rig's node on a line, out of its record.

use super::{Device, Record, RecordKind};
use described::{Decoded, Decoder};
use plan::{Rig, Speaker};

/// Decodes what one end of a line sends.
#[derive(Debug, Clone)]
pub struct Ear {
    who: Device,
    /// The other ends of the line: answers that look the same are told apart by what they ask.
    beside: Vec<Device>,
    decoder: Decoder,
}

impl Ear {
    /// Hears `who`, beside whom the others are on the line.
    pub const fn new(who: Device, beside: Vec<Device>, decoder: Decoder) -> Self {
        Self { who, beside, decoder }
    }

    /// Hears a speaker of the rig; `None` if no node has its name.
    pub fn of(rig: &Rig, speaker: &Speaker) -> Option<Self> {
        let node = rig.nodes.iter().position(|node| node.name == speaker.node)?;
        let on_line = rig.ends().filter(|(_, line)| *line == speaker.line);
        let others = on_line.filter(|(other, _)| *other != node);
        let others = others.map(|(other, line)| Device::of_node(rig, other, line));
        let others = others.chain(rig.bus_of(speaker.line).map(Device::stranger));
        let decoder = speaker.layout.decoder_for(speaker.sender);
        Some(Self::new(Device::of_node(rig, node, speaker.line), others.collect(), decoder))
    }

    /// The device under which the end is recorded.
    pub const fn who(&self) -> Device {
        self.who
    }

    /// Whether a record is of a frame that none of the ears of its sender takes: one of nobody in the rig, or one with
    /// another node's identifier. A bus does not tell who sent it, so that it counts as that node's.
    pub fn is_forged<'a>(ears: impl IntoIterator<Item = &'a Self>, record: &Record) -> bool {
        let RecordKind::Frame(frame) = &record.kind else { return false };
        let mut own = ears.into_iter().filter(|ear| ear.who == record.device);
        // A remote request has the identifier of another node's message, which it asks for.
        !frame.is_remote() && !own.any(|ear| ear.decoder.takes(frame.id()))
    }

    /// Passes on each message that the record completes, also if it is [forged](Self::is_forged).
    pub fn hear(&mut self, record: &Record, is_forged: bool, each: &mut impl FnMut(Decoded<'_>)) {
        let is_its = record.device == self.who;
        let is_beside = || self.beside.contains(&record.device);
        match &record.kind {
            RecordKind::Bytes(bytes) if is_its => {
                self.decoder.bytes(bytes, each);
            }
            RecordKind::Bytes(bytes) if is_beside() => {
                self.decoder.overhear(bytes);
            }
            RecordKind::Frame(frame) if is_its || (is_forged && is_beside()) => {
                self.decoder.at(record.at).frame(frame).into_iter().for_each(each);
            }
            _ => {}
        }
    }
}
