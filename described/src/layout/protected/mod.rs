//! Applies the counter and the checksum in a file to the signals of a message.

mod end_to_end;
#[cfg(test)]
pub(crate) mod tests;

use super::message::{Carrier, Message, Protected};
use super::signal::{Signal, Storage};
use super::{Carried, Layout};
use crate::bits::BitField;
use crate::error::{FileError, Mistake, Read};
use crate::file::{ChecksumTable, CounterTable, ProtectionTable};
use crate::hint;
use crate::place::{Place, given};
use crate::protection::{Checksum, Counter, FrameSum, Protection, Seal};
use std::collections::BTreeMap;

impl Layout {
    /// The layout with counters and checksums in messages, as given in the `line`-th `[[line]]` of a rig file. `file`
    /// is the rig file's name in error messages, and `text` its content.
    ///
    /// # Errors
    /// With the place of the first mistake.
    pub fn protected(
        self,
        (file, text, line): (&str, &str, usize),
        tables: &BTreeMap<String, ProtectionTable>,
    ) -> Result<Self, FileError> {
        let place = Place::file().key("line").index(line).key("message");
        let names: Vec<String> = self.messages().iter().map(|known| known.name.clone()).collect();
        if let Some(name) = tables.keys().find(|name| !names.contains(name)) {
            let mistake = Mistake::new(place.key(name).name(), format!("no message `{name}`"));
            return Err(mistake.help(hint::proposal(name, &names)).located(file, text));
        }
        for (name, table) in tables {
            let lacks = self.lacks(name, table, &place.key(name));
            lacks.map_err(|mistake| mistake.located(file, text))?;
        }
        let changed = self.changed(|_, message| match tables.get(&message.name) {
            Some(table) => message.protect(table, &place.key(&message.name)),
            None => Ok(()),
        });
        changed.map_err(|mistake| mistake.located(file, text))
    }

    /// Explains a counter or a checksum in a signal that was left out of the message.
    pub(crate) fn lacks(&self, message: &str, table: &ProtectionTable, place: &Place) -> Read {
        let counter = table.counter.as_ref().map(|one| (("counter", "signal"), &one.signal));
        let checksum = table.checksum.as_ref().map(|one| (("checksum", "signal"), &one.signal));
        let counted = table.e2e.as_ref().map(|one| (("e2e", "counter"), &one.counter));
        let summed = table.e2e.as_ref().map(|one| (("e2e", "checksum"), &one.checksum));
        let of = self.messages().iter().find(|known| known.name == message);
        let has =
            |signal: &str| of.is_some_and(|of| of.signals.iter().any(|one| one.name == signal));
        for ((table, key), signal) in [counter, checksum, counted, summed].into_iter().flatten() {
            if has(signal) {
                continue;
            }
            if let Some(note) = self.left_out(&format!("{message}.{signal}")) {
                let text = format!("`{message}` has no usable signal `{signal}`");
                return Err(Mistake::new(place.key(table).key(key), text).help(note.to_string()));
            }
        }
        Ok(())
    }

    /// The first message for which both layouts state a counter or a checksum, and not the same one; with the word for
    /// it. What a receiver tolerates may differ.
    pub fn contradicts(&self, other: &Self) -> Option<(&str, &'static str)> {
        let frame = |message: &Message| match message.carrier {
            Carrier::Frame { id, .. } => Some(id),
            _ => None,
        };
        self.messages().iter().find_map(|message| {
            let id = frame(message)?;
            let twin = other.messages().iter().find(|twin| frame(twin) == Some(id))?;
            let (one, two) = (message.protected.as_ref()?, twin.protected.as_ref()?);
            let what = one.protection.contradicts(&two.protection)?;
            Some((&*message.name, what))
        })
    }
}

impl Message {
    /// Applies the protection given in a table at `place`, if any.
    pub(crate) fn protect(&mut self, table: &ProtectionTable, place: &Place) -> Read {
        let Some(first) = given!(table; counter, checksum, e2e) else { return Ok(()) };
        if matches!(self.carrier, Carrier::Line(_)) {
            let text = format!("`{first}` has no meaning in a line of text");
            return Err(Mistake::new(place.key(first).name(), text));
        }
        if table.e2e.is_some() && first != "e2e" {
            let text = format!("`{}` has a `{first}` and an `e2e`", self.name);
            return Err(Mistake::new(place.key(first).name(), text)
                .help("`e2e` says which signals its counter and its checksum are"));
        }
        if let Some(e2e) = &table.e2e {
            self.protected = Some(self.end_to_end(e2e, &place.key("e2e"))?);
            return Ok(());
        }
        let counter = table.counter.as_ref();
        let counter = counter.map(|counter| self.counter(counter, &place.key("counter")));
        let counter = counter.transpose()?;
        let sum = table.checksum.as_ref();
        let sum = sum.map(|sum| self.sum(sum, &place.key("checksum"))).transpose()?;
        if let (Some((one, _)), Some((other, _))) = (&counter, &sum)
            && one == other
        {
            let text = format!("`{}` is the counter already", self.signals[*one].name);
            return Err(Mistake::new(place.key("checksum").key("signal"), text));
        }
        self.protected = Some(Protected {
            counter: counter.as_ref().map(|(signal, _)| *signal),
            checksum: sum.as_ref().map(|(signal, _)| *signal),
            protection: Protection {
                counter: counter.map(|(_, counter)| counter),
                seal: sum.map(|(_, sum)| Seal::Sum(sum)),
            },
        });
        Ok(())
    }

    fn counter(&self, table: &CounterTable, place: &Place) -> Read<(usize, Counter)> {
        let (signal, field) = self.bits_of(&table.signal, &place.key("signal"))?;
        let bits = field.length();
        let most = u64::MAX >> (u64::BITS - bits);
        let mut greatest = self.signals[signal].greatest_number().unwrap_or(most).min(most);
        if let Some(modulo) = table.modulo {
            // `modulo = 256` for an 8-bit counter: the numbers go up to 255.
            greatest = modulo.checked_sub(1).filter(|last| (1..=most).contains(last)).ok_or_else(
                || {
                    let text =
                        format!("a counter modulo {modulo} in `{}` of {bits} bits", table.signal);
                    Mistake::new(place.key("modulo"), text)
                        .help(format!("from 2 to {}", u128::from(most) + 1))
                },
            )?;
        }
        let within = |key: &str, number: u64, least: u64| {
            let mistake = || {
                Mistake::new(
                    place.key(key),
                    format!("the counter `{}` cannot have {number} as its `{key}`", table.signal),
                )
                .help(format!("from {least} to {greatest}"))
            };
            (least..=greatest).contains(&number).then_some(number).ok_or_else(mistake)
        };
        let first = within("first", table.first.unwrap_or(0), 0)?;
        let step = within("step", table.step.unwrap_or(1), 1)?;
        let max_delta = table.max_delta.map(|most| within("max_delta", most, 1)).transpose()?;
        Ok((signal, Counter { field, first, step, greatest, max_delta }))
    }

    fn sum(&self, table: &ChecksumTable, place: &Place) -> Read<(usize, FrameSum)> {
        let checksum = Checksum::at(&table.crc, &place.key("crc"))?;
        let (signal, field) = self.bits_of(&table.signal, &place.key("signal"))?;
        let bits = 8 * checksum.length();
        if field.length() as usize != bits {
            let (name, found) = (&table.signal, field.length());
            let text = format!("`{}` has {bits} bits, and `{name}` has {found}", table.crc);
            return Err(Mistake::new(place.key("signal"), text));
        }
        let length = self.payload().len();
        let covers = table.bytes.map(|(first, last)| match first <= last && last < length {
            true => Ok(first..last + 1),
            false => Err(Mistake::new(
                place.key("bytes"),
                format!("`{}` has no bytes {first} to {last}", self.name),
            )
            .help(format!("the first and the last byte, from 0 to {}", length.saturating_sub(1)))),
        });
        let covers = covers.transpose()?;
        let (before, behind) = (table.prepend.clone(), table.append.clone());
        Ok((signal, FrameSum { checksum, field, covers, before, behind }))
    }

    /// The position of a signal that can hold protection, and its bits relative to [`Message::payload`].
    fn bits_of(&self, name: &str, place: &Place) -> Read<(usize, BitField)> {
        let Some(index) = self.signals.iter().position(|known| known.name == name) else {
            let names: Vec<&str> = self.signals.iter().map(|known| known.name.as_str()).collect();
            let text = format!("`{}` has no signal `{name}`", self.name);
            return Err(Mistake::new(place.clone(), text).help(hint::proposal(name, &names)));
        };
        let signal: &Signal = &self.signals[index];
        let refuse = |what: &str| Mistake::new(place.clone(), format!("`{name}` {what}"));
        match (signal.storage, &signal.carried) {
            (_, Carried::When(_)) => {
                Err(refuse("is multiplexed, and what protects a message is in each"))
            }
            (Storage::Bits { field, coding }, Carried::Always) if !coding.is_float() => {
                Ok((index, field.behind(self.payload().start)))
            }
            _ => Err(refuse("is no whole number")),
        }
    }
}
