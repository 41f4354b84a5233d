//! What can go wrong, as data: a kind with its parameters, and what is known of each.

mod declare;
pub(crate) mod schema;
mod vocabulary;

pub use vocabulary::FaultKind;

use super::Target;
use described::hint::proposal;

/// One kind of fault, as a table or a campaign sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindInfo {
    /// Its key in a plan.
    pub name: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// Its parameters in the order of [`FaultKind::values`]; the first is its severity.
    pub parameters: &'static [KindParameter],
    /// What it strikes.
    pub reach: Reach,
    /// What says when it is over.
    pub lasts: Lasts,
    /// Kinds of one switch exclude each other on one target: a device cannot be stuck and off at once.
    pub switch: Option<&'static str>,
    /// Where it is from.
    pub source: &'static str,
    /// The kind with a typical value of each parameter.
    pub typical: FaultKind,
}

/// Kinds that nothing shows which the paper's controller hears: wheels that slip alike turn as the encoders say.
const NO_INPUT_SHOWS: &[&str] = &["wheel_slip"];

/// The kind of this name, where no input of the paper's controller shows it.
pub fn no_input_shows(name: &str) -> Option<&'static str> {
    NO_INPUT_SHOWS.iter().copied().find(|kind| *kind == name)
}

/// One parameter of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KindParameter {
    /// Its key; the unit comes last.
    pub name: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Least and greatest value, both included.
    pub range: (f64, f64),
}

impl KindParameter {
    /// Is `value` one of its?
    pub fn takes(&self, value: f64) -> bool {
        value >= self.range.0 && value <= self.range.1
    }
}

/// What a kind strikes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// A line: bytes of a serial line, frames of a CAN bus.
    Line,
    /// A serial line alone.
    SerialLine,
    /// A CAN bus alone.
    CanBus,
    /// A message of a node, or what is in it.
    Message(Share),
    /// A device, or the host or the operator.
    Only(Target),
}

/// What of a message is struck.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    /// All of it.
    Whole,
    /// Its counter.
    Counter,
    /// Its checksum.
    Checksum,
    /// One of its signals.
    Signal,
}

impl Reach {
    /// The targets that a fault of this reach can have; whether the line to one is a bus, the bench says.
    pub const fn targets(self) -> &'static [Target] {
        match self {
            Self::Line | Self::SerialLine => {
                &[Target::Gyro, Target::Base, Target::Table, Target::Device]
            }
            Self::CanBus => &[Target::Base, Target::Device],
            Self::Only(Target::Gyro) => &[Target::Gyro],
            Self::Only(Target::Base) => &[Target::Base],
            Self::Only(Target::Table) => &[Target::Table],
            Self::Only(Target::Host) => &[Target::Host],
            Self::Only(Target::Operator) => &[Target::Operator],
            Self::Message(_) | Self::Only(Target::Device | Target::Node(_)) => &[Target::Device],
        }
    }

    /// It strikes a line, so that a direction can be told.
    pub const fn is_line(self) -> bool {
        matches!(self, Self::Line | Self::SerialLine | Self::CanBus)
    }
}

/// What says when a fault is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// The schedule: its duration, or the end of the phase or of the run.
    Scheduled,
    /// Its first parameter, in seconds.
    Itself,
    /// It happens in an instant and is over.
    Instant,
}

impl FaultKind {
    /// What is known of this kind.
    pub fn info(&self) -> &'static KindInfo {
        &Self::all()[self.index()]
    }

    /// Its key in a plan.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// Is it a fault that makes frames of its own, whichever way?
    pub const fn makes_frames(&self) -> bool {
        matches!(self, Self::Babble { .. } | Self::BusLoad { .. })
    }

    /// How bad it is: the magnitude of its first parameter, in that one's unit. More is worse.
    pub fn severity(&self) -> f64 {
        self.values().first().map_or(0.0, |value| value.abs())
    }

    /// The same kind, this bad; the sign stays, and so do its other parameters. What is beyond the range
    /// of the parameter becomes its end.
    #[must_use]
    pub fn with_severity(self, severity: f64) -> Self {
        let Some(parameter) = self.info().parameters.first() else { return self };
        let sign = self.values().first().map_or(1.0, |value| 1f64.copysign(*value));
        let (least, greatest) = parameter.range;
        self.with_value(0, (severity.abs() * sign).clamp(least, greatest))
    }

    /// Severities that make sense: from the least that does anything to the greatest.
    pub fn severity_range(&self) -> (f64, f64) {
        self.info()
            .parameters
            .first()
            .map_or((0.0, 0.0), |parameter| (parameter.range.0.max(0.0), parameter.range.1))
    }

    /// The kind of this name with typical values.
    pub fn typical(name: &str) -> Option<Self> {
        Self::all().iter().find(|info| info.name == name).map(|info| info.typical)
    }

    /// The same, or what to say where there is none.
    ///
    /// # Errors
    ///
    /// When no kind has this name.
    pub fn named(name: &str) -> Result<Self, UnknownKind> {
        Self::typical(name).ok_or_else(|| {
            let known: Vec<&str> = Self::all().iter().map(|info| info.name).collect();
            UnknownKind { name: name.to_owned(), help: proposal(name, &known) }
        })
    }
}

/// There is no fault of this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no fault is called `{name}`")]
pub struct UnknownKind {
    /// What was asked for.
    pub name: String,
    /// What there is.
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
            assert_eq!(info.reach == Reach::CanBus, info.reach.targets().len() == 2);
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
