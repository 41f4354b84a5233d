//! Decodes the traffic of a run's lines into messages and signals.
//!
//! The codecs of the controller decode the base's six messages, on CAN and on its serial line; its layout decodes those
//! of the user's own device. Packets of gyros and tables are not decoded: their contents are in the states and the
//! observations.

use super::base::{self, Overheard};
use super::forms::{MessageForm, forms};
use described::{Decoder, Description, Sender};
use plan::Rig;
use record::{Device, Record};
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

/// A node of a rig that sends messages.
#[derive(Debug)]
struct Voice {
    device: Device,
    /// The other ends of its line.
    beside: Vec<Device>,
    name: String,
    /// Index of its first message among the forms.
    first: usize,
    decoder: Decoder,
}

#[derive(Debug)]
enum Hearing {
    None,
    Base(Box<Overheard>),
    /// The user's own device: what it sends, and what is sent to it.
    Device {
        device: Box<Decoder>,
        host: Box<Decoder>,
    },
    Rig(Vec<Voice>),
}

impl Ears {
    pub const fn deaf() -> Self {
        Self { forms: Vec::new(), hearing: Hearing::None }
    }

    pub fn of_base() -> Self {
        Self { forms: base::forms(), hearing: Hearing::Base(Box::default()) }
    }

    pub fn of_device(description: &Arc<Description>) -> Self {
        let layout = description.layout();
        let decoder = |sender| Box::new(layout.decoder_for(sender));
        Self {
            forms: forms(layout),
            hearing: Hearing::Device {
                device: decoder(Sender::Device),
                host: decoder(Sender::Host),
            },
        }
    }

    pub fn of_rig(rig: &Rig) -> Self {
        let mut all = Vec::new();
        let mut decoders = Vec::new();
        for speaker in &rig.speakers {
            let Some(device) = Device::of_speaker(rig, speaker) else { continue };
            let decoder = speaker.layout.decoder_for(speaker.sender);
            let (name, first) = (speaker.node.clone(), all.len());
            let beside = Device::beside(rig, speaker);
            decoders.push(Voice { device, beside, name, first, decoder });
            all.extend(forms(&speaker.layout));
        }
        Self { forms: all, hearing: Hearing::Rig(decoders) }
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
            Hearing::Device { device: of_device, host } => {
                let decoder = match device == Device::Device {
                    true => of_device,
                    false => {
                        record.overheard(of_device);
                        host
                    }
                };
                record.messages(decoder, &mut |decoded| {
                    told(device.name(), decoded.message, decoded.values.to_vec());
                });
            }
            Hearing::Rig(voices) => {
                for voice in voices {
                    if voice.beside.contains(&device) {
                        record.overheard(&mut voice.decoder);
                    }
                    if voice.device != device {
                        continue;
                    }
                    record.messages(&mut voice.decoder, &mut |decoded| {
                        told(&voice.name, voice.first + decoded.message, decoded.values.to_vec());
                    });
                }
            }
        }
    }
}
