//! Layouts of CANopen devices: frames whose signals are objects.

use super::Sender;
use super::message::{Carrier, Message};
use super::number::{Coding, Scale};
use super::signal::{Signal, Storage};
use super::{Layout, Medium};
use crate::bits::BitField;
use crate::canopen::{Dictionary, NODE};
use std::sync::Arc;
use wire::can::Id;

impl Layout {
    pub(crate) fn of_canopen(messages: Vec<Message>, dictionary: Arc<Dictionary>) -> Self {
        let layout = Self::new(Medium::Can, messages).noting(dictionary.notes.clone());
        Self { dictionary: Some(dictionary), ..layout }
    }

    /// What a master of several CANopen devices on one line sends. A message that each of them hears by another
    /// identifier is called `NODE.MESSAGE`.
    pub fn of_master(devices: &[(&str, &Self)]) -> Self {
        let heard = |layout: &Self| {
            let messages = layout.messages.iter().filter(|one| one.sender == Sender::Host);
            messages.cloned().collect::<Vec<_>>()
        };
        let all: Vec<(&str, Message)> = (devices.iter())
            .flat_map(|(node, layout)| heard(layout).into_iter().map(|message| (*node, message)))
            .collect();
        let mut messages: Vec<Message> = Vec::new();
        for (node, message) in &all {
            let is_known = |known: &Message| known.can_id() == message.can_id();
            if messages.iter().any(is_known) {
                continue;
            }
            let mut message = message.clone();
            let mut alike = all.iter().filter(|(_, other)| other.name == message.name);
            if alike.any(|(_, other)| other.can_id() != message.can_id()) {
                message.name = format!("{node}.{}", message.name);
            }
            // One for all: an NMT command is for every node until it says which.
            let signals = message.signals.iter_mut();
            signals.filter(|signal| signal.name == NODE).for_each(|signal| signal.start = 0.0);
            messages.push(message);
        }
        Self::new(Medium::Can, messages)
    }

    /// The objects, if it is of a CANopen device.
    pub const fn dictionary(&self) -> Option<&Arc<Dictionary>> {
        self.dictionary.as_ref()
    }
}

impl Message {
    /// A message in a classic frame of this identifier and length.
    pub(crate) fn of_frame(
        name: &str,
        sender: Sender,
        (id, length): (Id, usize),
        signals: Vec<Signal>,
    ) -> Self {
        Self::new(name.to_owned(), sender, Carrier::Frame { id, length, fd: None }, signals)
    }
}

impl Signal {
    /// A signal of these bits, with all values that they can have.
    pub(crate) fn of_bits(name: &str, field: BitField, coding: Coding, scale: Scale) -> Self {
        let (least, greatest) = coding.limits(field.length());
        let range = scale.range(least, greatest);
        Self::new(name.to_owned(), range, scale, Storage::Bits { field, coding })
    }
}
