//! What an end of a line sends and is not a valid message of it: counted for remarks, and for plans that judge it.

use crate::Rig;
use crate::line::EndId;
use crate::rig::Ear;
use wire::can::CanFrame;

impl Ear {
    /// What was not a valid message of its end so far: bytes outside of messages, frames that are too short, messages with a
    /// wrong checksum.
    pub(crate) fn damage(&self) -> u64 {
        let spoilt = self.decoder.spoilt().map(|(_, count)| count);
        let wrong = self.oddities.wrong_checksums.values();
        self.decoder.damaged() + spoilt.chain(wrong.copied()).sum::<u64>()
    }
}

impl Rig {
    /// Counts a remote request, or a frame of an end that sends no such message; returns whether it was unexpected.
    #[cold]
    pub(crate) fn is_unexpected(&mut self, line: usize, from: EndId, frame: &CanFrame) -> bool {
        let id = frame.id();
        let is_here = |ear: &Ear| ear.line == line;
        let is_its = |ear: &Ear| is_here(ear) && ear.decoder.takes(id);
        if frame.is_remote()
            && let Some(ear) = self.ears.iter_mut().find(|ear| is_its(ear))
        {
            // CiA 301 has such requests, for PDOs and of node guarding.
            let is_odd = ear.decoder.layout().dictionary().is_none();
            if is_odd {
                ear.oddities.requested.count(id);
            }
            return is_odd;
        }
        let at = |ear: &Ear| is_here(ear) && ear.end == from;
        if !self.ears.iter().any(at) {
            let is_of_port = from != EndId::STRANGER && self.is_away(line, from);
            let owner = self.ears.iter_mut().find(|ear| is_of_port && is_its(ear));
            return owner.map(|ear| ear.oddities.doubled.count(id)).is_some();
        }
        // A node may have several layouts on one line. A client of diagnostics asks on a channel that a node of the line
        // declares.
        let is_asked = |ear: &Ear| is_here(ear) && ear.decoder.layout().is_asked_by(id);
        if self.ears.iter().any(|ear| (at(ear) && ear.decoder.takes(id)) || is_asked(ear)) {
            return false;
        }
        let sender = self.ears.iter_mut().find(|ear| at(ear));
        sender.map(|ear| ear.oddities.unexpected.count(id)).is_some()
    }
}
