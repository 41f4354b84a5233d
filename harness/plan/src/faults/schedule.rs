//! A schedule: the faults of one run.

use super::Fault;
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

    /// These faults after those of `other`, which keep their indices and so their random numbers.
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
