//! Switches for deliberate faults: of a device, a line or a person.

use crate::random::RandomStream;
use std::slice::{Iter, IterMut};

/// Active faults, each under the number that the caller chose when switching it on. `C` is the source of their random
/// numbers.
#[derive(Debug, Clone)]
pub struct Switches<F, C = RandomStream> {
    on: Vec<Switch<F, C>>,
}

/// An active fault.
#[derive(Debug, Clone)]
pub struct Switch<F, C = RandomStream> {
    number: usize,
    /// The fault, with its state.
    pub fault: F,
    /// Its random numbers.
    pub chance: C,
    /// How often it has acted.
    pub acted: u64,
}

impl<F, C> Default for Switches<F, C> {
    fn default() -> Self {
        Self { on: Vec::new() }
    }
}

impl<F, C> Switches<F, C> {
    /// True if no fault is active.
    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.on.is_empty()
    }

    /// Adds a fault, which has not acted yet.
    pub fn switch_on(&mut self, number: usize, fault: F, chance: C) -> Option<&mut Switch<F, C>> {
        self.on.push(Switch { number, fault, chance, acted: 0 });
        self.on.last_mut()
    }

    /// Removes the faults `number`; returns how often they have acted, and the last of them, if any was active.
    pub fn switch_off(&mut self, number: usize) -> Option<(u64, F)> {
        let mut acted = 0;
        let of_number = self.on.extract_if(.., |switch| switch.number == number);
        let last = of_number.inspect(|switch| acted += switch.acted).last()?;
        Some((acted, last.fault))
    }

    /// The active faults, in the order of activation.
    pub fn iter(&self) -> Iter<'_, Switch<F, C>> {
        self.on.iter()
    }

    /// The active faults, mutable for counting.
    pub fn iter_mut(&mut self) -> IterMut<'_, Switch<F, C>> {
        self.on.iter_mut()
    }

    /// The faults `number`.
    pub fn numbered(&mut self, number: usize) -> impl Iterator<Item = &mut Switch<F, C>> {
        self.on.iter_mut().filter(move |switch| switch.number == number)
    }
}
