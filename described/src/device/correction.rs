//! Corrections applied to a signal before it is sent, as in a firmware.

use super::Device;
use crate::expression::TIME;
use crate::layout::Sender;
use crate::steps::{Memory, Procedure, Steps};

#[derive(Debug, Clone)]
pub(super) struct Correction {
    steps: Procedure<Seen>,
    pub(super) memory: Memory,
}

/// The source of a correction's input.
#[derive(Debug, Clone, Copy)]
enum Seen {
    Slot(usize),
    /// A signal of this or another message, as last sent.
    Sent {
        sending: usize,
        place: usize,
    },
}

impl Device {
    /// Applies `steps` to every value of the signal, noise included, before it is sent; `None` removes them.
    ///
    /// # Errors
    /// If the device does not send the signal or does not know an input.
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

    /// The index of a signal's message among the sent ones, and its position in it.
    fn place_of(&self, name: &str) -> Option<(usize, usize)> {
        let (message, place) = self.description.layout().sent_signal(Sender::Device, name)?;
        let sent = &self.description.model.sent;
        sent.iter().position(|one| one.message == message).map(|sending| (sending, place))
    }

    /// The value that a firmware sees under a name: an internal, a received or a sent one.
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

    /// Applies the corrections of a message to its values.
    pub(super) fn take_errors_off(&mut self, index: usize, values: &mut [f64]) {
        // Taken out of the device, so that they can read what else was sent.
        let mut corrections = std::mem::take(&mut self.senders[index].corrections);
        for (place, Correction { steps, memory }) in &mut corrections {
            let (now, value) = (self.dynamics.get(TIME), values[*place]);
            values[*place] = steps.next(memory, now, value, |seen| match *seen {
                Seen::Slot(slot) => self.dynamics.get(slot),
                Seen::Sent { sending, place } => self.senders[sending].last[place],
            });
        }
        self.senders[index].corrections = corrections;
    }
}
