//! Errors that are taken off a signal before it is sent, as a firmware would do it.

use super::Device;
use super::sending::{Correction, Seen};
use crate::layout::Sender;
use crate::steps::{Memory, Steps};

impl Device {
    /// From now on `steps` are done with every value of the signal, noise and all, before it is sent; none any more
    /// where there are none.
    ///
    /// # Errors
    /// Says what the device does not send or does not know.
    pub fn correct(&mut self, signal: &str, steps: Option<&Steps>) -> Result<(), String> {
        let (sending, place) =
            self.place_of(signal).ok_or_else(|| format!("the device sends no `{signal}`"))?;
        let steps = steps.map(|steps| steps.read(|name| self.seen(name))).transpose()?;
        let corrections = &mut self.senders[sending].corrections;
        corrections.retain(|(known, _)| *known != place);
        corrections
            .extend(steps.map(|steps| (place, Correction { steps, memory: Memory::default() })));
        Ok(())
    }

    /// The message among those that it sends, and the place in it, of a signal.
    fn place_of(&self, name: &str) -> Option<(usize, usize)> {
        let (message, place) = self.description.layout().sent_signal(Sender::Device, name)?;
        let sent = &self.description.model.sent;
        sent.iter().position(|one| one.message == message).map(|sending| (sending, place))
    }

    /// What a firmware sees under a name: its own, what it hears, or what it sends.
    fn seen(&self, name: &str) -> Result<Seen, String> {
        let model = &self.description.model;
        let heard = || {
            let (message, signal) = self.description.layout().signal(name)?;
            model.variables.signal(message, signal)
        };
        if let Some(slot) = model.variables.inner(name).or_else(heard) {
            return Ok(Seen::Slot(slot));
        }
        let sent = self.place_of(name).map(|(sending, place)| Seen::Sent { sending, place });
        sent.ok_or_else(|| format!("the device knows no `{name}`"))
    }
}
