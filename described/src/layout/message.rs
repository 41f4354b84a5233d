//! One message: its signals, and how it is carried.

use super::checksum::Trailer;
use super::printed::Match;
use super::signal::{Carried, Signal};
use super::text::Pattern;
use super::{Decoded, EncodeError};
use wire::can::{CanFrame, DATA_BYTES_MAX, Id};
use wire::device::Transmit;
use wire::packet::{BYTES_MAX, Packet};
use wire::time::Span;

/// Who sends a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sender {
    /// The device that is described.
    Device,
    /// Whoever talks to it.
    Host,
}

/// Signals that are sent together.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Its name, unique in the layout.
    pub name: String,
    /// Who sends it.
    pub sender: Sender,
    /// How often it is sent, where that is periodic.
    pub period: Option<Span>,
    /// Its signals, in the order of the file.
    pub signals: Vec<Signal>,
    /// What the file says of it.
    pub doc: String,
    pub(super) carrier: Carrier,
}

/// What carries a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Carrier {
    /// A CAN frame with so many bytes.
    Frame { id: Id, length: usize },
    /// Bytes with a start of their own, and a checksum at the end.
    Packet { start: Vec<u8>, length: usize, trailer: Option<Trailer> },
    /// A line of text.
    Line(Pattern),
}

impl Message {
    /// Its identifier, on CAN.
    pub const fn can_id(&self) -> Option<Id> {
        match self.carrier {
            Carrier::Frame { id, .. } => Some(id),
            Carrier::Packet { .. } | Carrier::Line(_) => None,
        }
    }

    /// The place of its multiplexer among its signals.
    pub fn multiplexer(&self) -> Option<usize> {
        self.signals.iter().position(|signal| signal.carried == Carried::Multiplexer)
    }

    /// Two signals that have a bit in common.
    pub(super) fn overlap(&self) -> Option<(&Signal, &Signal)> {
        self.signals.iter().enumerate().find_map(|(index, signal)| {
            let other = self.signals[..index].iter().find(|other| signal.overlaps(other))?;
            Some((other, signal))
        })
    }

    pub(super) fn encode(&self, values: &[f64]) -> Result<Transmit, EncodeError> {
        if values.len() != self.signals.len() {
            return Err(EncodeError::Count {
                message: self.name.clone(),
                expected: self.signals.len(),
                found: values.len(),
            });
        }
        match &self.carrier {
            Carrier::Frame { id, length } => {
                let mut data = [0; DATA_BYTES_MAX];
                self.put(values, &mut data)?;
                let data = data.get(..*length);
                let frame = data.and_then(|data| CanFrame::new(*id, data));
                frame.map(Transmit::Frame).ok_or_else(|| self.too_long())
            }
            Carrier::Packet { start, length, trailer } => {
                let mut data = [0; BYTES_MAX];
                self.put(values, &mut data)?;
                let data = data.get_mut(..*length).ok_or_else(|| self.too_long())?;
                for (byte, sync) in data.iter_mut().zip(start) {
                    *byte = *sync;
                }
                if let Some(trailer) = trailer {
                    trailer.seal(data);
                }
                Packet::from_slice(data).map(Transmit::Bytes).ok_or_else(|| self.too_long())
            }
            Carrier::Line(pattern) => {
                let mut printed = Vec::with_capacity(values.len());
                for (signal, value) in self.signals.iter().zip(values) {
                    let number = signal.printed(*value);
                    printed.push(number.ok_or_else(|| self.out_of_range(signal, *value))?);
                }
                let line = pattern.write(|index| printed[index]);
                line.map(Transmit::Bytes).ok_or_else(|| self.too_long())
            }
        }
    }

    fn put(&self, values: &[f64], data: &mut [u8]) -> Result<(), EncodeError> {
        // The multiplexer first: it says which of the others this frame has.
        let mut selector = None;
        if let Some(index) = self.multiplexer() {
            let (signal, value) = (&self.signals[index], values[index]);
            if !signal.put(value, data) {
                return Err(self.out_of_range(signal, value));
            }
            selector = Some(signal.selector(data));
        }
        for (signal, value) in self.signals.iter().zip(values) {
            let carried = match signal.carried {
                Carried::Always => true,
                Carried::Multiplexer => false,
                Carried::When(page) => selector == Some(page),
            };
            if carried && !signal.put(*value, data) {
                return Err(self.out_of_range(signal, *value));
            }
        }
        Ok(())
    }

    /// The values in the bytes of a frame or packet.
    pub(super) fn values(&self, data: &[u8]) -> Vec<Option<f64>> {
        let selector = self.multiplexer().map(|index| self.signals[index].selector(data));
        self.signals
            .iter()
            .map(|signal| match signal.carried {
                Carried::When(page) if selector != Some(page) => None,
                _ => Some(signal.read(data)),
            })
            .collect()
    }

    /// What the first bytes of a serial line are to this message, and its values where it is whole.
    pub(super) fn find(&self, index: usize, data: &[u8]) -> Found {
        match &self.carrier {
            Carrier::Frame { .. } => Found::Nothing,
            Carrier::Packet { start, length, trailer } => {
                let known = start.len().min(data.len());
                if data[..known] != start[..known] {
                    return Found::Nothing;
                }
                let Some(packet) = data.get(..*length) else { return Found::Beginning };
                if trailer.is_some_and(|trailer| !trailer.holds(packet)) {
                    return Found::WrongChecksum;
                }
                let decoded = Decoded { message: index, values: self.values(packet) };
                Found::Whole(decoded, *length)
            }
            Carrier::Line(pattern) => {
                let mut numbers = Vec::with_capacity(self.signals.len());
                match pattern.read(data, &mut numbers) {
                    Match::No => Found::Nothing,
                    Match::Partial => Found::Beginning,
                    Match::Whole(length) => {
                        let physical =
                            |(number, signal): (f64, &Signal)| Some(signal.scale.physical(number));
                        let values = numbers.into_iter().zip(&self.signals).map(physical).collect();
                        Found::Whole(Decoded { message: index, values }, length)
                    }
                }
            }
        }
    }

    fn out_of_range(&self, signal: &Signal, value: f64) -> EncodeError {
        EncodeError::OutOfRange {
            signal: format!("{}.{}", self.name, signal.name),
            value,
            minimum: signal.minimum,
            maximum: signal.maximum,
            unit: signal.unit.clone(),
        }
    }

    fn too_long(&self) -> EncodeError {
        EncodeError::TooLong { message: self.name.clone() }
    }
}

/// What bytes of a serial line are to a message.
pub(super) enum Found {
    /// It does not begin here.
    Nothing,
    /// It may begin here: more bytes will tell.
    Beginning,
    /// All of it but for a checksum that is another.
    WrongChecksum,
    /// It, and how many bytes it has.
    Whole(Decoded, usize),
}
