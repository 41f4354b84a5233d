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
        let decoder = speaker.layout.decoder_for(speaker.sender);
        Some(Self::new(Device::of_node(rig, node, speaker.line), others.collect(), decoder))
    }

    /// The device under which the end is recorded.
    pub const fn who(&self) -> Device {
        self.who
    }

    /// Passes on each message that the record completes.
    pub fn hear(&mut self, record: &Record, each: &mut impl FnMut(Decoded<'_>)) {
        match &record.kind {
            RecordKind::Bytes(bytes) if record.device == self.who => {
                self.decoder.bytes(bytes, each);
            }
            RecordKind::Bytes(bytes) if self.beside.contains(&record.device) => {
                self.decoder.overhear(bytes);
            }
            RecordKind::Frame(frame) if record.device == self.who => {
                self.decoder.frame(frame).into_iter().for_each(each);
            }
            _ => {}
        }
    }
}
