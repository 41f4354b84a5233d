//! What was said on the lines of a run, understood: messages and their signals.
//!
//! The base's six messages are read by the codecs that the controller itself uses, on CAN and on its serial line; those of a
//! device of the user's own by its layout. Packets of gyros and tables are not read: what was in them stands in the
//! states and the observations.

use super::base::{self, Overheard};
use described::{Decoder, Description, Layout, Sender};
use plan::Rig;
use record::{Device, Record};
use std::sync::Arc;

/// A signal of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalForm {
    /// Its name in the layout.
    pub name: String,
    /// Unit of its values; empty where it has none.
    pub unit: String,
    /// What it is.
    pub doc: String,
    /// Names of values, as far as the layout has any, by the values in its unit.
    pub names: Vec<(f64, String)>,
}

/// A message of a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct MessageForm {
    /// Its name in the layout.
    pub name: String,
    /// What it is.
    pub doc: String,
    /// Its signals.
    pub signals: Vec<SignalForm>,
}

/// A message that was sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard<'a> {
    /// Who sent it.
    pub device: Device,
    /// The same, by name.
    pub who: &'a str,
    /// Its place among [`Ears::forms`].
    pub index: usize,
    /// Which message it is.
    pub form: &'a MessageForm,
    /// A value a signal, in its unit; none where this one does not carry it.
    pub values: Vec<Option<f64>>,
}

/// The messages of a layout.
fn forms(layout: &Layout) -> Vec<MessageForm> {
    let signal = |signal: &described::Signal| SignalForm {
        name: signal.name.clone(),
        unit: signal.unit.clone(),
        doc: signal.doc.clone(),
        names: signal.names().map(|(name, value)| (value, name.to_owned())).collect(),
    };
    let form = |message: &described::Message| MessageForm {
        name: message.name.clone(),
        doc: message.doc.clone(),
        signals: message.signals.iter().map(signal).collect(),
    };
    layout.messages().iter().map(form).collect()
}

/// Understands what crosses the lines of a run.
#[derive(Debug)]
pub struct Ears {
    forms: Vec<MessageForm>,
    hearing: Hearing,
}

/// A node of a rig that says something.
#[derive(Debug)]
struct Voice {
    device: Device,
    name: String,
    /// Where its messages begin among the forms.
    first: usize,
    decoder: Decoder,
}

#[derive(Debug)]
enum Hearing {
    /// Nobody says what the messages are.
    None,
    /// The robot's base.
    Base(Box<Overheard>),
    /// A device of the user's own: what it sends, and what is sent to it.
    Device { device: Box<Decoder>, host: Box<Decoder> },
    /// Nodes of a rig.
    Rig(Vec<Voice>),
}

impl Ears {
    /// Understands nothing.
    pub const fn deaf() -> Self {
        Self { forms: Vec::new(), hearing: Hearing::None }
    }

    /// Understands the robot's base.
    pub fn of_base() -> Self {
        Self { forms: base::forms(), hearing: Hearing::Base(Box::default()) }
    }

    /// Understands a device by its layout.
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

    /// Understands the nodes of a rig.
    pub fn of_rig(rig: &Rig) -> Self {
        let mut all = Vec::new();
        let mut decoders = Vec::new();
        for speaker in &rig.speakers {
            let Some(device) = Device::of_speaker(rig, speaker) else { continue };
            let decoder = speaker.layout.decoder_for(speaker.sender);
            let (name, first) = (speaker.node.clone(), all.len());
            decoders.push(Voice { device, name, first, decoder });
            all.extend(forms(&speaker.layout));
        }
        Self { forms: all, hearing: Hearing::Rig(decoders) }
    }

    /// All messages that may be heard.
    pub fn forms(&self) -> &[MessageForm] {
        &self.forms
    }

    /// Hands over each message that a record completes.
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
                let decoder = if device == Device::Device { of_device } else { host };
                record.messages(decoder, &mut |decoded| {
                    told(device.name(), decoded.message, decoded.values.to_vec());
                });
            }
            Hearing::Rig(voices) => {
                for voice in voices.iter_mut().filter(|voice| voice.device == record.device) {
                    record.messages(&mut voice.decoder, &mut |decoded| {
                        told(&voice.name, voice.first + decoded.message, decoded.values.to_vec());
                    });
                }
            }
        }
    }
}
