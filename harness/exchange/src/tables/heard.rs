//! Decodes the traffic of a run's lines into messages and signals.
//!
//! The codecs of the controller decode the base's six messages, on CAN and on its serial line; its layout decodes those
//! of the user's own device. Packets of gyros and tables are not decoded: their contents are in the states and the
//! observations.

use super::base::{self, Overheard};
use super::forms::{MessageForm, forms};
use described::{Description, Sender};
use plan::Rig;
use record::{Device, Ear, Record};
use std::sync::Arc;

#[derive(Debug, Clone, PartialEq)]
pub struct Heard<'a> {
    pub device: Device,
    pub who: &'a str,
    /// Index in [`Ears::forms`].
    pub index: usize,
    pub form: &'a MessageForm,
    /// One value per signal, in its unit; `None` for a signal that this message does not carry.
    pub values: Vec<Option<f64>>,
}

/// Decodes the traffic of a run's lines.
#[derive(Debug)]
pub struct Ears {
    forms: Vec<MessageForm>,
    hearing: Hearing,
}

/// An end of a line that sends messages.
#[derive(Debug)]
struct Voice {
    ear: Ear,
    name: String,
    /// Index of its first message among the forms.
    first: usize,
}

#[derive(Debug)]
enum Hearing {
    None,
    Base(Box<Overheard>),
    Rig(Vec<Voice>),
}

impl Ears {
    pub const fn deaf() -> Self {
        Self { forms: Vec::new(), hearing: Hearing::None }
    }

    pub fn of_base() -> Self {
        Self { forms: base::forms(), hearing: Hearing::Base(Box::default()) }
    }

    /// Of the user's own device: what it sends, and what the plan sends to it.
    pub fn of_device(description: &Arc<Description>) -> Self {
        let layout = description.layout();
        let voice = |who: Device, other: Device, sender| {
            let ear = Ear::new(who, vec![other], layout.decoder_for(sender));
            Voice { ear, name: who.name().to_owned(), first: 0 }
        };
        let device = voice(Device::Device, Device::Plan, Sender::Device);
        let host = voice(Device::Plan, Device::Device, Sender::Host);
        Self { forms: forms(layout), hearing: Hearing::Rig(vec![device, host]) }
    }

    pub fn of_rig(rig: &Rig) -> Self {
        let mut all = Vec::new();
        let mut voices = Vec::new();
        for speaker in &rig.speakers {
            let Some(ear) = Ear::of(rig, speaker) else { continue };
            voices.push(Voice { ear, name: speaker.node.clone(), first: all.len() });
            all.extend(forms(&speaker.layout));
        }
        Self { forms: all, hearing: Hearing::Rig(voices) }
    }

    pub fn forms(&self) -> &[MessageForm] {
        &self.forms
    }

    /// Passes on each message that a record completes.
    pub fn take(&mut self, record: &Record, each: &mut dyn FnMut(&Heard<'_>)) {
        let forms = &self.forms;
        let device = record.device;
        let mut told = |who: &str, index: usize, values: Vec<Option<f64>>| {
            if let Some(form) = forms.get(index) {
                each(&Heard { device, who, index, form, values });
            }
        };
        match &mut self.hearing {
            Hearing::None => {}
            Hearing::Base(base) => {
                base.take(record, &mut |index, values| told(device.name(), index, values));
            }
            Hearing::Rig(voices) => {
                for Voice { ear, name, first } in voices {
                    ear.hear(record, &mut |decoded| {
                        told(name, *first + decoded.message, decoded.values.to_vec());
                    });
                }
            }
        }
    }
}
