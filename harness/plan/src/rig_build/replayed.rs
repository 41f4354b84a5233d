//! Nodes of a rig file whose part a log plays.

use super::{Builder, Parts};
use crate::replayed::{channel_of, said_on};
use crate::rig::{NodePart, NodeTable, ReplayTable};
use crate::speakers::Speaker;

impl Builder<'_> {
    pub(super) fn replayed<P: Parts>(
        &self,
        number: usize,
        replay: &ReplayTable,
        (node, lines): (&NodeTable, &[usize]),
        parts: &mut P,
    ) -> Result<NodePart, P::Error> {
        let source = self.library.open_beside(self.source, &replay.log)?;
        let log = parts.log(&source)?;
        let mut said = Vec::new();
        for (port, line) in lines.iter().enumerate() {
            let Some(declared) = self.line(*line) else { continue };
            let named = replay.channel.as_deref();
            let channel = channel_of(&log, &declared.name, declared.medium, named);
            let channel = channel.map_err(|known| {
                let line = &declared.name;
                let message = format!("which channel of {} is the line `{line}`?", source.origin);
                let help = format!("`channel = ...`, one of: {}", known.join(", "));
                self.mistake(("node", number, "replay"), message, Some(help))
            })?;
            let speaks = |one: &&Speaker| one.node == node.name.as_str() && one.line == *line;
            let words = self.rig.speakers.iter().find(speaks);
            let words = words.map(|speaker| (&speaker.layout, speaker.sender));
            let port = u8::try_from(port).unwrap_or(u8::MAX);
            said.extend(said_on(&log, channel, words).map(|(at, what)| (at, port, what)));
        }
        if said.is_empty() {
            let message = format!("`{}` says nothing in {}", node.name, source.origin);
            return Err(self.mistake(("node", number, "replay"), message, None).into());
        }
        said.sort_by_key(|(at, ..)| *at);
        Ok(NodePart::Replayed(said.into()))
    }
}
