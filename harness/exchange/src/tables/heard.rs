//! Decodes the traffic of a run's lines into messages and signals.
//!
//! The codecs of the controller decode the base's six messages, on CAN and on its serial line; layouts decode those of all
//! other nodes. Packets of gyros and tables are not decoded: their contents are in the states and the observations.

use super::base::{self, Overheard};
use super::forms::{MessageForm, forms};
use described::{Layout, Sender};
use plan::Rig;
use record::header::Header;
use record::{Device, Ear, Record};

/// The line of the robot's base.
const BASE_LINE: &str = "base";

#[derive(Debug, Clone, PartialEq)]
pub struct Heard<'a> {
    pub who: &'a str,
    /// The line that it was sent on, if it has a name.
    pub line: Option<&'a str>,
    /// Index in [`Ears::forms`].
    pub index: usize,
    pub form: &'a MessageForm,
    /// One value per signal, in its unit; `None` for a signal that this message does not carry.
    pub values: Vec<Option<f64>>,
}

/// Decodes the traffic of a run's lines.
#[derive(Debug, Default)]
pub struct Ears {
    forms: Vec<MessageForm>,
    /// Of the robot's base and its controller; their messages are the first among the forms.
    base: Option<Box<Overheard>>,
    voices: Vec<Voice>,
}

/// An end of a line that sends messages.
#[derive(Debug)]
struct Voice {
    ear: Ear,
    /// Index of its first message among the forms.
    first: usize,
}

impl Ears {
    pub fn deaf() -> Self {
        Self::default()
    }

    /// Of the robot's base and its controller alone.
    pub fn of_base() -> Self {
        Self { forms: base::forms(), base: Some(Box::default()), voices: Vec::new() }
    }

    /// Of all that speak on the lines of a rig, what the plan sends to its only device included.
    pub fn of_rig(rig: &Rig) -> Self {
        let mut ears = if rig.robot.is_some() { Self::of_base() } else { Self::default() };
        for speaker in &rig.speakers {
            let Some(ear) = Ear::of(rig, speaker) else { continue };
            let first = ears.forms.len();
            ears.add(ear, &speaker.layout);
            for form in &mut ears.forms[first..] {
                let mut others = rig.speakers.iter().filter(|other| other.line != speaker.line);
                let is_elsewhere =
                    others.any(|other| other.messages().any(|sent| sent.name == form.name));
                form.line = is_elsewhere.then(|| speaker.line_name.clone());
            }
        }
        if let Some(description) = rig.device() {
            let layout = description.layout();
            let decoder = layout.decoder_for(Sender::Host);
            ears.add(Ear::new(Device::Plan, vec![Device::Device], decoder), layout);
        }
        ears
    }

    fn add(&mut self, ear: Ear, layout: &Layout) {
        self.voices.push(Voice { ear, first: self.forms.len() });
        self.forms.extend(forms(layout));
    }

    pub fn forms(&self) -> &[MessageForm] {
        &self.forms
    }

    /// Passes on each message that a record completes; `header` is that of the records.
    pub fn take(&mut self, record: &Record, header: &Header, each: &mut dyn FnMut(&Heard<'_>)) {
        let Self { forms, base, voices } = self;
        let (who, line) = (header.name_of(record.device), header.line_of(record.device));
        let mut told = |index: usize, values: Vec<Option<f64>>| {
            if let Some(form) = forms.get(index) {
                each(&Heard { who, line, index, form, values });
            }
        };
        // Other nodes on other lines may have its identifiers.
        if let Some(base) = base.as_mut().filter(|_| line.is_none_or(|line| line == BASE_LINE)) {
            base.take(record, &mut told);
        }
        let is_forged = Ear::is_forged(voices.iter().map(|voice| &voice.ear), record);
        for Voice { ear, first } in voices {
            ear.hear(record, is_forged, &mut |decoded| {
                told(*first + decoded.message, decoded.values.to_vec());
            });
        }
    }
}
