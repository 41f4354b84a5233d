//! The kinds of faults as data: each with its parameters and properties.

mod declare;
pub(crate) mod schema;
mod vocabulary;

pub use vocabulary::FaultKind;

use super::Target;
use described::hint::proposal;

/// One kind of fault, as tables and campaigns need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindInfo {
    /// Its key in a plan.
    pub name: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// Its parameters in the order of [`FaultKind::values`]; the first is its severity.
    pub parameters: &'static [KindParameter],
    /// The possible targets.
    pub reach: Reach,
    /// The rule for its end.
    pub lasts: Lasts,
    /// Kinds of one switch exclude each other on one target: a device cannot be stuck and off at once.
    pub switch: Option<&'static str>,
    /// Source of the fault model.
    pub source: &'static str,
    /// The kind with a typical value of each parameter.
    pub typical: FaultKind,
}

/// One parameter of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindParameter {
    /// Its key; the unit comes last.
    pub name: &'static str,
    /// Description.
    pub doc: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Smallest and greatest value, inclusive.
    pub range: (f64, f64),
}

impl KindParameter {
    /// Whether `value` is in its range.
    pub fn takes(&self, value: f64) -> bool {
        value >= self.range.0 && value <= self.range.1
    }
}

/// The possible targets of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// A line: the bytes of a serial line, or the frames of a CAN bus.
    Line,
    /// Only a serial line.
    SerialLine,
    /// Only a CAN bus.
    CanBus,
    /// A message of a node, or part of its content.
    Message(Share),
    /// A device whose supply `hil` has in its hands: the gyro, an emulated device, a program under test that it starts.
    Powered,
    /// A device, or the host or the operator.
    Only(Target),
}

/// The part of a message that a fault changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    /// The whole message.
    Whole,
    /// Its counter.
    Counter,
    /// Its checksum.
    Checksum,
    /// One of its signals.
    Signal,
}

impl Reach {
    /// The possible targets of a fault with this reach; only the bench determines whether a target's line is a bus.
    pub const fn targets(self) -> &'static [Target] {
        match self {
            Self::Line | Self::SerialLine => {
                &[Target::Gyro, Target::Base, Target::Table, Target::Device]
            }
            Self::CanBus => &[Target::Base, Target::Device],
            Self::Powered => &[Target::Gyro, Target::Device],
            Self::Only(Target::Gyro) => &[Target::Gyro],
            Self::Only(Target::Base) => &[Target::Base],
            Self::Only(Target::Table) => &[Target::Table],
            Self::Only(Target::Host) => &[Target::Host],
            Self::Only(Target::Operator) => &[Target::Operator],
            Self::Message(_) | Self::Only(Target::Device | Target::Node(_)) => &[Target::Device],
        }
    }

    /// Whether it acts on a line, so that it can have a direction.
    pub const fn is_line(self) -> bool {
        matches!(self, Self::Line | Self::SerialLine | Self::CanBus)
    }
}

/// The rule for the end of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// The schedule ends it: its duration, or the end of the phase or the run.
    Scheduled,
    /// Its first parameter, in seconds.
    Itself,
    /// It happens in an instant.
    Instant,
}

impl FaultKind {
    /// The properties of this kind.
    pub fn info(&self) -> &'static KindInfo {
        &Self::all()[self.index()]
    }

    /// Its key in a plan.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// Whether the fault cuts the supply of that target, as for any node. The gyro is restarted by a switch of its own.
    pub fn cuts_supply_of(&self, target: Target) -> bool {
        self.info().reach == Reach::Powered && target != Target::Gyro
    }

    /// Whether the fault makes frames of its own, in whichever way.
    pub const fn makes_frames(&self) -> bool {
        matches!(self, Self::Babble { .. } | Self::BusLoad { .. })
    }

    /// Whether it depends on the other messages of a line when one gets through, or whether it does.
    pub const fn holds_up(&self) -> bool {
        let waits = matches!(
            self,
            Self::LostArbitration { .. } | Self::BitErrors { .. } | Self::Delay { .. }
        );
        let is_packed_anew =
            matches!(self, Self::Repeat { .. } | Self::Stall { .. } | Self::Split { .. });
        self.makes_frames() || waits || is_packed_anew
    }

    /// The severity: the magnitude of the first parameter, in its unit. Greater is worse.
    pub fn severity(&self) -> f64 {
        self.values().first().map_or(0.0, |value| value.abs())
    }

    /// The same kind with this severity; the sign and the other parameters stay the same. The value is clamped to the
    /// range of the parameter.
    #[must_use]
    pub fn with_severity(self, severity: f64) -> Self {
        let Some(parameter) = self.info().parameters.first() else { return self };
        let sign = self.values().first().map_or(1.0, |value| 1f64.copysign(*value));
        let (least, greatest) = parameter.range;
        self.with_value(0, (severity.abs() * sign).clamp(least, greatest))
    }

    /// Whether its severity has a direction: the first parameter can be negative.
    pub fn is_signed(&self) -> bool {
        self.info().parameters.first().is_some_and(|first| first.range.0 < 0.0)
    }

    /// The same kind in the other direction.
    #[must_use]
    pub fn reversed(self) -> Self {
        let first = self.values().first().copied().unwrap_or_default();
        self.with_value(0, -first)
    }

    /// Whether more of its first parameter is worse; the value of a signal is not.
    pub const fn is_graded(&self) -> bool {
        !matches!(self, Self::SignalValue { .. })
    }

    /// The useful severities: from the smallest with an effect to the greatest.
    pub fn severity_range(&self) -> (f64, f64) {
        self.info()
            .parameters
            .first()
            .map_or((0.0, 0.0), |parameter| (parameter.range.0.max(0.0), parameter.range.1))
    }

    /// The kind with this name and typical values.
    pub fn typical(name: &str) -> Option<Self> {
        Self::all().iter().find(|info| info.name == name).map(|info| info.typical)
    }

    /// The kind with this name and typical values, or an error with a suggestion.
    ///
    /// # Errors
    /// When no kind has this name.
    pub fn named(name: &str) -> Result<Self, UnknownKind> {
        Self::typical(name).ok_or_else(|| {
            let known: Vec<&str> = Self::all().iter().map(|info| info.name).collect();
            UnknownKind { name: name.to_owned(), help: proposal(name, &known) }
        })
    }
}

/// No fault has this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no fault is called `{name}`")]
pub struct UnknownKind {
    /// The requested name.
    pub name: String,
    /// A suggestion.
    pub help: String,
}

#[cfg(test)]
mod tests {
    use super::{FaultKind, Reach};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_kind_is_told_whole() {
        let mut names = BTreeSet::new();
        for (index, info) in FaultKind::all().iter().enumerate() {
            assert!(names.insert(info.name), "{} twice", info.name);
            assert!(!info.source.is_empty() && !info.doc.is_empty() && !info.parameters.is_empty());
            assert_eq!(info.typical.index(), index);
            assert_eq!(FaultKind::typical(info.name), Some(info.typical));
            for (parameter, value) in info.parameters.iter().zip(info.typical.values()) {
                assert!(parameter.takes(value), "{}.{}", info.name, parameter.name);
                assert!(!parameter.takes(f64::NAN) && parameter.range.0 < parameter.range.1);
            }
            let of_two = matches!(info.reach, Reach::CanBus | Reach::Powered);
            assert_eq!(of_two, info.reach.targets().len() == 2);
        }
    }

    proptest! {
        #[test]
        fn severity_is_what_it_was_set_to(index in 0..FaultKind::all().len(), share in 0f64..1.0) {
            let kind = FaultKind::all()[index].typical;
            let (least, most) = kind.severity_range();
            let wanted = least + (most - least) * share;
            let set = kind.with_severity(wanted);
            prop_assert!((set.severity() - wanted).abs() < 1e-12 * most.max(1.0));
            prop_assert_eq!(set.index(), kind.index());
            prop_assert_eq!(&set.values()[1..], &kind.values()[1..]);
            prop_assert!(kind.with_severity(1e300).severity() <= most);
        }
    }
}
