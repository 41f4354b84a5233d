//! What a multiplexer selects.

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
    pub(super) fn meets(&self, other: &Self) -> bool {
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
