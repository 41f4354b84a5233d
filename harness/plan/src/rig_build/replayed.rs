//! Nodes of a rig file that are replayed from a log.

use super::{Builder, Cause};
use crate::replayed::{Channels, Words};
use crate::rig::{NodePart, NodeTable, ReplayTable};
use crate::speakers::Speaker;
use std::path::Path;

/// Ends of the names of logs in binary formats.
const BINARY: [&str; 4] = ["blf", "mf4", "pcap", "pcapng"];

impl<E: Cause> Builder<'_, E> {
    pub(super) fn replayed(
        &mut self,
        number: usize,
        replay: &ReplayTable,
        (node, lines): (&NodeTable, &[usize]),
    ) -> Result<NodePart, E> {
        let end = Path::new(&replay.log).extension().unwrap_or_default();
        if BINARY.iter().any(|one| end.eq_ignore_ascii_case(one)) {
            let message =
                format!("`{}` is no text, and only a log that is text plays a node", replay.log);
            let help = "candump (.log), Vector ASC (.asc) or PEAK TRC (.trc): `hil log convert` writes it as one";
            let help = Some(help.to_owned());
            return Err(self.mistake(("node", number, "replay"), message, help).into());
        }
        let source = self.beside(&replay.log, ("node", number, "replay"))?;
        let (log, notes) = (self.parts.log)(&source)?;
        self.rig.notes.extend(notes.into_iter().map(|note| format!("{}: {note}", source.origin)));
        let words = |line: &usize| {
            let speaks = |one: &&Speaker| one.node == node.name.as_str() && one.line == *line;
            let words = self.rig.speakers.iter().find(speaks);
            let words = words.map(|speaker| Words::Of(&speaker.layout, speaker.sender, &[]));
            Some((self.line(*line)?, words.unwrap_or(Words::All)))
        };
        let named = |_: &str| replay.channel.as_deref();
        let channels = Channels { log: &log, named: &named, lines: &[] };
        let said = channels.part(lines.iter().map(words));
        let said = said.map_err(|(line, known)| {
            if known.is_empty() {
                let message = format!("{} holds no frames and no bytes", source.origin);
                return self.mistake(("node", number, "replay"), message, None);
            }
            let message = format!("which channel of {} is the line `{line}`?", source.origin);
            let help = format!("`channel = ...`, one of: {}", known.join(", "));
            self.mistake(("node", number, "replay"), message, Some(help))
        })?;
        if said.is_empty() {
            let message = format!("`{}` says nothing in {}", node.name, source.origin);
            return Err(self.mistake(("node", number, "replay"), message, None).into());
        }
        Ok(NodePart::Replayed(said))
    }
}
