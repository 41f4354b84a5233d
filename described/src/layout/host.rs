//! What the host of several devices on one line sends.

use super::alike::alike;
use super::message::Message;
use super::{Layout, Medium, Sender};
use crate::canopen::NODE;

impl Layout {
    /// What these devices on one line hear from their host. A message that each of them hears in a form of its own is called
    /// `NODE.MESSAGE`.
    ///
    /// # Errors
    /// Two different messages that look the same: each device needs an address of its own.
    pub fn of_host(devices: &[(&str, &Self)]) -> Result<Self, String> {
        let all: Vec<(&str, &Message)> = (devices.iter())
            .flat_map(|(node, layout)| layout.messages.iter().map(|message| (*node, message)))
            .filter(|(_, message)| message.sender == Sender::Host)
            .collect();
        let mut messages: Vec<Message> = Vec::new();
        for (node, message) in &all {
            if messages.iter().any(|known| is_same(known, message)) {
                continue;
            }
            let mut other = all.iter().filter(|(_, other)| alike(message, other).is_some());
            if let Some((whose, other)) = other.find(|(_, other)| !is_same(message, other)) {
                let (name, other) = (&message.name, &other.name);
                return Err(format!(
                    "`{name}` of `{node}` and `{other}` of `{whose}` look the same"
                ));
            }
            let mut message = (*message).clone();
            let mut alike = all.iter().filter(|(_, other)| other.name == message.name);
            if alike.any(|(_, other)| !is_same(&message, other)) {
                message.name = format!("{node}.{}", message.name);
            }
            // One for all: an NMT command is for every node until it says which.
            let signals = message.signals.iter_mut();
            signals.filter(|signal| signal.name == NODE).for_each(|signal| signal.start = 0.0);
            messages.push(message);
        }
        let medium = devices.first().map_or(Medium::Can, |(_, layout)| layout.medium);
        Ok(Self::new(medium, messages))
    }
}

/// Whether a line carries both as one.
fn is_same(message: &Message, other: &Message) -> bool {
    match (message.can_id(), other.can_id()) {
        (None, None) => message.carrier == other.carrier && message.signals == other.signals,
        (of_one, of_other) => of_one == of_other,
    }
}
