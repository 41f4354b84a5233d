//! Layouts of CANopen devices: frames whose signals are objects.

use super::Sender;
use super::message::{Carrier, Message};
use super::number::{Coding, Scale};
use super::signal::{Signal, Storage};
use super::{Layout, Medium};
use crate::bits::BitField;
use crate::canopen::Dictionary;
use std::sync::Arc;
use wire::can::Id;

impl Layout {
    pub(crate) fn of_canopen(messages: Vec<Message>, dictionary: Arc<Dictionary>) -> Self {
        let layout = Self::new(Medium::Can, messages).noting(dictionary.notes.clone());
        Self { dictionary: Some(dictionary), ..layout }
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
