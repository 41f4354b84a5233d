//! Multiplexing: which frames of a message carry a signal.

use super::signal::Signal;
use std::fmt;
use std::ops::RangeInclusive;

/// Which frames of a message carry a signal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Carried {
    /// All frames.
    Always,
    /// Frames that carry its multiplexer with one of these numbers.
    When(Selection),
}

impl Carried {
    pub(super) const fn selection(&self) -> Option<&Selection> {
        match self {
            Self::Always => None,
            Self::When(selection) => Some(selection),
        }
    }
}

/// Required numbers of a multiplexer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The multiplexer's position among the signals of the message.
    pub multiplexer: usize,
    /// Its numbers on the wire. Not empty.
    pub numbers: Vec<RangeInclusive<u64>>,
}

impl Selection {
    /// True if the number is one of them.
    pub fn has(&self, number: u64) -> bool {
        self.numbers.iter().any(|range| range.contains(&number))
    }

    /// True if both have a number in common.
    fn meets(&self, other: &Self) -> bool {
        let meet = |one: &RangeInclusive<u64>, another: &RangeInclusive<u64>| {
            one.start() <= another.end() && another.start() <= one.end()
        };
        self.numbers.iter().any(|one| other.numbers.iter().any(|another| meet(one, another)))
    }
}

/// `1`, `3 to 5`, or several of these.
impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, range) in self.numbers.iter().enumerate() {
            let before = if index == 0 { "" } else { " or " };
            match range.start() == range.end() {
                true => write!(f, "{before}{}", range.start())?,
                false => write!(f, "{before}{} to {}", range.start(), range.end())?,
            }
        }
        Ok(())
    }
}

/// True if the frame with these multiplexer numbers, by position, carries the signal at this position.
pub(super) fn carries(
    signals: &[Signal],
    signal: usize,
    number: &dyn Fn(usize) -> Option<u64>,
) -> bool {
    needs(signals, signal)
        .all(|selection| number(selection.multiplexer).is_some_and(|number| selection.has(number)))
}

/// The selections required for a signal to be carried, from its own upwards.
pub(super) fn needs(signals: &[Signal], signal: usize) -> impl Iterator<Item = &Selection> {
    let above = |signal: usize| signals.get(signal)?.carried.selection();
    std::iter::successors(above(signal), move |selection| above(selection.multiplexer))
}

/// The positions of two signals with a common bit, the first before the second.
pub(super) fn overlap(signals: &[Signal]) -> Option<(usize, usize)> {
    signals.iter().enumerate().find_map(|(second, signal)| {
        let clashes =
            |first: &usize| signals[*first].overlaps(signal) && !exclude(signals, *first, second);
        Some(((0..second).find(clashes)?, second))
    })
}

/// True if no frame carries both: they need different numbers of one multiplexer.
fn exclude(signals: &[Signal], one: usize, another: usize) -> bool {
    needs(signals, one).any(|selection| {
        let same = |other: &&Selection| other.multiplexer == selection.multiplexer;
        needs(signals, another).find(same).is_some_and(|other| !other.meets(selection))
    })
}
