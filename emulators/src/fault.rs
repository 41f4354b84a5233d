//! Switches of an emulator: which of its faults are on.

use crate::random::RandomStream;

/// The faults of a device that are on, each known by a number that whoever switches gives it.
#[derive(Debug, Clone)]
pub struct Switches<F> {
    on: Vec<Switch<F>>,
}

/// One fault that is on.
#[derive(Debug, Clone)]
pub(crate) struct Switch<F> {
    number: usize,
    pub(crate) fault: F,
    /// Random numbers of its own.
    pub(crate) chance: RandomStream,
    /// How often it has changed what the device does.
    pub(crate) acted: u64,
}

impl<F> Switches<F> {
    /// None is on.
    pub(crate) const fn new() -> Self {
        Self { on: Vec::new() }
    }

    /// None is on.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.on.is_empty()
    }

    pub(crate) fn switch_on(&mut self, number: usize, fault: F, chance: RandomStream) {
        self.on.push(Switch { number, fault, chance, acted: 0 });
    }

    /// How often it has acted, and the fault, where it was on.
    pub(crate) fn switch_off(&mut self, number: usize) -> Option<(u64, F)> {
        let place = self.on.iter().position(|switch| switch.number == number)?;
        let switch = self.on.remove(place);
        Some((switch.acted, switch.fault))
    }

    /// How often the fault of this number has acted.
    pub(crate) fn acted(&self, number: usize) -> u64 {
        let found = self.on.iter().find(|switch| switch.number == number);
        found.map_or(0, |switch| switch.acted)
    }

    /// Those that are on, in the order in which they were switched on.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Switch<F>> {
        self.on.iter()
    }

    /// The same, to be counted.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Switch<F>> {
        self.on.iter_mut()
    }
}
