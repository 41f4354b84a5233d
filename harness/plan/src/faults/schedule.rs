//! A schedule: the faults of one run.

use super::{Chances, Fault};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The most faults of one run. Assumption: a larger schedule is unreadable and shrinks badly.
pub const FAULTS_MAX: usize = 256;

/// The faults of one run, in the order in which a plan writes them; a fault is known by its place here.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Schedule {
    /// The faults.
    pub faults: Vec<Fault>,
}

impl Schedule {
    /// Whether it has no faults.
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// The random numbers of each fault in the run with `seed`.
    pub fn chances(&self, seed: u64) -> impl Iterator<Item = Chances> {
        self.faults.iter().enumerate().map(move |(place, fault)| {
            let alike = |other: &&Fault| {
                (other.what.name(), other.target) == (fault.what.name(), fault.target)
            };
            Chances::new(seed, fault, self.faults[..place].iter().filter(alike).count())
        })
    }

    /// These faults after those of `other`, which keep their indices and their random numbers.
    #[must_use]
    pub fn beside(&self, other: &Self) -> Self {
        Self { faults: other.faults.iter().chain(&self.faults).cloned().collect() }
    }

    /// Its text in a plan: `[[fault]]` tables.
    pub fn to_toml(&self) -> String {
        #[derive(Serialize)]
        struct Holder<'a> {
            fault: &'a Schedule,
        }
        // TOML can represent names, numbers and tables.
        toml::to_string(&Holder { fault: self }).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;
    use crate::Name;
    use crate::faults::{Fault, FaultKind, Lasts, Target, Toward, When};
    use proptest::prelude::*;
    use wire::time::Span;

    #[derive(serde::Deserialize)]
    struct Holder {
        fault: Schedule,
    }

    fn name() -> Name {
        Name::new("lap").unwrap()
    }

    fn when() -> impl Strategy<Value = When> {
        prop_oneof![
            Just(When::Always),
            (0i64..1_000_000).prop_map(|ms| When::At(Span::from_millis(ms))),
            (1u32..9, 0i64..10_000).prop_map(|(number, ms)| When::Step {
                phase: name(),
                number,
                after: Span::from_millis(ms)
            }),
            (1u32..9).prop_map(|number| When::During { phase: name(), number }),
        ]
    }

    /// Of the first numbers of each fault's stream, those of the fault that lasts that long.
    fn numbers(schedule: &Schedule, seed: u64, lasts_s: i64) -> Vec<f64> {
        let drawn = schedule.faults.iter().zip(schedule.chances(seed));
        let of = drawn.filter(|(fault, _)| fault.duration == Some(Span::from_secs(lasts_s)));
        of.map(|(_, chances)| chances.of("to host").uniform()).collect()
    }

    #[test]
    fn a_fault_keeps_its_random_numbers_when_others_go() {
        let lasting = |target, what, lasts_s| Fault {
            duration: Some(Span::from_secs(lasts_s)),
            ..Fault::new(target, what)
        };
        const DROP: FaultKind = FaultKind::Drop { loss_percent: 1.0 };
        const LESS: FaultKind = FaultKind::Drop { loss_percent: 0.5 };
        let all = [
            lasting(Target::Base, FaultKind::LateStop { late_s: 1.0 }, 1),
            lasting(Target::Gyro, DROP, 2),
            lasting(Target::Base, DROP, 3),
            lasting(Target::Gyro, LESS, 4),
        ];
        let of = |places: &[usize]| Schedule {
            faults: places.iter().map(|place| all[*place].clone()).collect(),
        };
        let whole = of(&[0, 1, 2, 3]);
        assert_eq!(numbers(&whole, 7, 4), numbers(&of(&[1, 3]), 7, 4));
        assert_eq!(numbers(&whole, 7, 3), numbers(&of(&[2]), 7, 3));
        let drawn: Vec<Vec<f64>> = (1..5).map(|lasts_s| numbers(&whole, 7, lasts_s)).collect();
        assert!((1..4).all(|place| !drawn[..place].contains(&drawn[place])), "{drawn:?}");
        assert_ne!(numbers(&whole, 8, 2), numbers(&whole, 7, 2));
        // In place of the first, the second of a kind draws what that one drew, whatever its size.
        assert_eq!(numbers(&whole, 7, 2), numbers(&of(&[3]), 7, 4));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(
            index in 0..FaultKind::all().len(), when in when(), seconds in 1i64..100,
            probability in 0.01f64..=1.0, device in any::<bool>(),
        ) {
            let info = &FaultKind::all()[index];
            let fault = Fault {
                target: info.reach.targets()[0],
                toward: if device { Toward::Device } else { Toward::Both },
                what: info.typical,
                when,
                duration: (info.lasts == Lasts::Scheduled).then_some(Span::from_secs(seconds)),
                probability,
            };
            let schedule = Schedule { faults: vec![fault, Fault::new(Target::Gyro, info.typical)] };
            let text = schedule.to_toml();
            let read = toml::from_str::<Holder>(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            prop_assert_eq!(read.fault, schedule);
        }
    }
}
