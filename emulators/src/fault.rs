//! Switches for the faults of an emulator.

use crate::random::RandomStream;

/// Active faults of a device, each under the number that the caller chose when switching it on.
#[derive(Debug, Clone)]
pub struct Switches<F> {
    on: Vec<Switch<F>>,
}

#[derive(Debug, Clone)]
pub(crate) struct Switch<F> {
    number: usize,
    pub(crate) fault: F,
    pub(crate) chance: RandomStream,
    /// How often it has changed the device's behaviour.
    pub(crate) acted: u64,
}

impl<F> Switches<F> {
    pub(crate) const fn new() -> Self {
        Self { on: Vec::new() }
    }

    /// True if no fault is active.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.on.is_empty()
    }

    pub(crate) fn switch_on(&mut self, number: usize, fault: F, chance: RandomStream) {
        self.on.push(Switch { number, fault, chance, acted: 0 });
    }

    /// Removes the fault; returns how often it has acted, and the fault itself, if it was active.
    pub(crate) fn switch_off(&mut self, number: usize) -> Option<(u64, F)> {
        let place = self.on.iter().position(|switch| switch.number == number)?;
        let switch = self.on.remove(place);
        Some((switch.acted, switch.fault))
    }

    /// How often the fault `number` has acted.
    pub(crate) fn acted(&self, number: usize) -> u64 {
        let found = self.on.iter().find(|switch| switch.number == number);
        found.map_or(0, |switch| switch.acted)
    }

    /// The active faults, in the order of activation.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Switch<F>> {
        self.on.iter()
    }

    /// The active faults, mutable for counting.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Switch<F>> {
        self.on.iter_mut()
    }
}
