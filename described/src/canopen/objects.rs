//! The values of the objects while the device runs.

use super::abort::Abort;
use super::dictionary::{APPLICATION, Dictionary, unsigned};
use super::pdo;
use crate::clipped::{Clipped, Counts};
use std::sync::Arc;

/// Error register, and its history (CiA 301, 7.5.2.2 and 7.5.2.4).
const ERROR_REGISTER: u16 = 0x1001;
pub(super) const ERROR_HISTORY: u16 = 0x1003;

/// What the device does beside the protocol.
pub(crate) trait Application {
    /// The value of the object at this place of the dictionary, in its unit; `None` for one that only masters change.
    fn value(&self, place: usize) -> Option<f64>;

    /// A master has written the object; `false` if its value is an expression.
    fn set(&mut self, place: usize, value: f64) -> bool;

    /// The error codes, each with whether its condition holds.
    fn errors(&self) -> Vec<(u16, bool)>;
}

/// The current bytes of all objects.
#[derive(Debug, Clone)]
pub(super) struct Objects {
    pub(super) dictionary: Arc<Dictionary>,
    pub(super) values: Vec<Vec<u8>>,
    /// The object of the communication that was written last.
    pub(super) changed: Option<u16>,
    clipped: Counts,
    not_finite: u64,
}

impl Objects {
    pub(super) fn new(dictionary: Arc<Dictionary>) -> Self {
        Self {
            values: dictionary.start(),
            dictionary,
            changed: None,
            clipped: Counts::default(),
            not_finite: 0,
        }
    }

    /// Takes over the counts of those before.
    pub(super) fn count_on(&mut self, before: Self) {
        (self.clipped, self.not_finite) = (before.clipped, before.not_finite);
    }

    /// Sets the objects of the communication to their values at power-on.
    pub(super) fn reset_communication(&mut self) {
        let each = self.values.iter_mut().zip(&self.dictionary.entries);
        for (value, entry) in each.filter(|(_, entry)| entry.index < APPLICATION) {
            value.clone_from(&entry.start);
        }
    }

    pub(super) fn setting(&self, index: u16, sub: u8) -> Option<u64> {
        self.dictionary.setting(&self.values, index, sub)
    }

    /// Number of bytes of an object that can be written.
    pub(super) fn length(&self, (index, sub): (u16, u8)) -> Result<usize, Abort> {
        let entry = self.dictionary.find(index, sub)?;
        if !entry.writable {
            return Err(Abort::READ_ONLY);
        }
        Ok(if entry.number().is_some() { entry.kind.bytes() } else { usize::MAX })
    }

    /// The bytes of the object at this place now. A value out of its range is the nearest one in it.
    pub(super) fn current(&mut self, place: usize, application: &dyn Application) -> &[u8] {
        let entry = &self.dictionary.entries[place];
        let value = application.value(place);
        self.not_finite += u64::from(value.is_some_and(|value| !value.is_finite()));
        let value = value.filter(|value| value.is_finite());
        // Equal numbers may be different bytes: 64 bits are more than a double has.
        if let Some(value) = value.filter(|value| entry.value(&self.values[place]) != Some(*value))
        {
            let (least, greatest) = entry.range();
            let inside = value.clamp(least, greatest);
            if let Some(bytes) = entry.bytes(inside) {
                // A value that rounds to the end of the range is in it.
                if entry.bytes(value).as_ref() != Some(&bytes) {
                    self.clipped.add(place, value, inside);
                }
                self.values[place] = bytes;
            }
        }
        &self.values[place]
    }

    pub(super) fn read(
        &mut self,
        (index, sub): (u16, u8),
        application: &dyn Application,
    ) -> Result<Vec<u8>, Abort> {
        let place = self.dictionary.position(index, sub)?;
        if !self.dictionary.entries[place].readable {
            return Err(Abort::WRITE_ONLY);
        }
        // What the history does not hold cannot be read (CiA 301, 7.5.2.4).
        if index == ERROR_HISTORY && u64::from(sub) > self.setting(ERROR_HISTORY, 0).unwrap_or(0) {
            return Err(Abort::NO_DATA);
        }
        Ok(self.current(place, application).to_vec())
    }

    pub(super) fn write(
        &mut self,
        (index, sub): (u16, u8),
        bytes: &[u8],
        application: &mut dyn Application,
    ) -> Result<(), Abort> {
        let place = self.dictionary.position(index, sub)?;
        let entry = &self.dictionary.entries[place];
        entry.check(bytes)?;
        if (index, sub) == (ERROR_HISTORY, 0) && unsigned(bytes) != 0 {
            return Err(Abort::RANGE);
        }
        pdo::check(&self.dictionary, &self.values, (index, sub), bytes)?;
        if let Some(value) = entry.value(bytes)
            && !application.set(place, value)
        {
            return Err(Abort::READ_ONLY);
        }
        self.values[place] = bytes.to_vec();
        if index < APPLICATION {
            self.changed = Some(index);
        }
        Ok(())
    }

    fn set(&mut self, (index, sub): (u16, u8), number: u64) {
        if let Ok(place) = self.dictionary.position(index, sub) {
            let bytes = self.dictionary.entries[place].kind.bytes();
            self.values[place] = number.to_le_bytes()[..bytes].to_vec();
        }
    }

    pub(super) const fn not_finite(&self) -> u64 {
        self.not_finite
    }

    /// The objects of which values were clipped to the range.
    pub(super) fn clipped(&self) -> impl Iterator<Item = Clipped<'_>> {
        self.clipped.all().into_iter().map(|(place, count, farthest)| {
            let entry = &self.dictionary.entries[place];
            let (name, range) = (entry.name().to_owned(), entry.range());
            Clipped { name, range, unit: entry.unit(), count, farthest }
        })
    }

    pub(super) fn set_error_register(&mut self, register: u8) {
        self.set((ERROR_REGISTER, 0), register.into());
    }

    /// Puts an error at the beginning of the history.
    pub(super) fn remember_error(&mut self, code: u16) {
        let room = (1..=u8::MAX - 1)
            .take_while(|sub| self.dictionary.position(ERROR_HISTORY, *sub).is_ok())
            .count() as u8;
        let known = self.setting(ERROR_HISTORY, 0).unwrap_or(0);
        for sub in (1..room).rev() {
            let moved = self.setting(ERROR_HISTORY, sub).unwrap_or(0);
            self.set((ERROR_HISTORY, sub + 1), moved);
        }
        self.set((ERROR_HISTORY, 1), code.into());
        self.set((ERROR_HISTORY, 0), (known + 1).min(room.into()));
    }
}
