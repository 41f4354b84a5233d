//! One case: a seed and what goes wrong; and what came of it.

use plan::faults::Schedule;
use record::outcome::Outcome;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The property that is broken by a controller that panics.
pub const PANIC: &str = "no_panic";
/// What is broken where a plan does not pass.
pub const PASSES: &str = "passes";

/// One run of a plan.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Of everything random in the run.
    pub seed: u64,
    /// What goes wrong.
    #[serde(default)]
    pub schedule: Schedule,
}

/// A case by its content: equal cases of equal plans have equal names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CaseId(u128);

impl Case {
    /// Its name among those of the plan with this text.
    pub fn id(&self, plan: &str) -> CaseId {
        CaseId::of(&[record::VERSION, plan, &self.seed.to_string(), &self.schedule.to_toml()])
    }
}

impl CaseId {
    /// Of texts, which may hold anything.
    pub fn of(texts: &[&str]) -> Self {
        let mut hash = Fnv::new();
        for text in texts {
            hash.write(&(text.len() as u64).to_le_bytes());
            hash.write(text.as_bytes());
        }
        Self(hash.0)
    }
}

/// FNV-1a, 128 bits (Fowler, Noll, Vo; constants of RFC 9923): fixed for all time and all platforms.
struct Fnv(u128);

impl Fnv {
    const fn new() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn write(&mut self, bytes: &[u8]) {
        const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(PRIME);
        }
    }
}

/// 32 hexadecimal digits.
impl fmt::Display for CaseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// Where a property broke.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Violated {
    /// The property.
    pub property: String,
    /// Bench time, s.
    pub at_s: f64,
    /// What was seen.
    pub what: String,
}

/// What one case came to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CaseResult {
    /// How the run ended, as in its summary.
    pub outcome: String,
    /// Always-properties that were broken, in the order in which they are declared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violated: Vec<Violated>,
    /// Least margin of each always-property that had something to judge: negative where it broke.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub margins: BTreeMap<String, f64>,
    /// Sometimes-properties that came about.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub reached: BTreeSet<String>,
    /// Where runs differ: what came of repeating the case, for each property that broke in its first run. One that is not
    /// among the violated was not shown to break.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub repeated: BTreeMap<String, Repeated>,
    /// Every measurement of the plan was in its band, and the plan went to its end.
    pub passed: bool,
    /// A controller that takes missions said that something is wrong: its health was worse than ok after it had been ok, or it
    /// refused or broke off a mission. Envelopes ask for it, whose journals keep it beside the result.
    #[serde(skip)]
    pub announced: bool,
}

impl CaseResult {
    /// Of a case of which nothing is known but how it ended.
    pub fn ended(outcome: &str) -> Self {
        Self { outcome: outcome.to_owned(), ..Self::default() }
    }

    /// Nobody carried it out to its end, because somebody wants no more.
    pub fn given_up() -> Self {
        Self::ended(Outcome::Aborted.name())
    }

    /// It was given up on request: it says nothing of the case.
    pub fn is_given_up(&self) -> bool {
        self.outcome == Outcome::Aborted.name()
    }

    /// Did this property break?
    pub fn breaks(&self, property: &str) -> bool {
        self.violated.iter().any(|violated| violated.property == property)
    }
}

/// What repetitions of one case came to, for one property.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Repeated {
    /// How many broke it.
    pub broke: u64,
    /// Of how many.
    pub of: u64,
    /// At the confidence asked for it breaks in at least this share of all runs.
    pub at_least: f64,
}

#[cfg(test)]
mod tests {
    use super::{Case, Fnv};
    use plan::faults::{Fault, FaultKind, Schedule, Target};

    #[test]
    fn the_hash_is_the_published_one() {
        let hash = |text: &str| {
            let mut hash = Fnv::new();
            hash.write(text.as_bytes());
            hash.0
        };
        assert_eq!(hash(""), 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(hash("a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }

    #[test]
    fn seed_plan_and_schedule_make_the_name() {
        let case = Case { seed: 1, ..Case::default() };
        let fault = Fault::new(Target::Gyro, FaultKind::typical("drop").unwrap());
        let faulty = Case { schedule: Schedule { faults: vec![fault] }, ..case.clone() };
        let ids =
            [case.id("a"), case.id("b"), faulty.id("a"), Case { seed: 2, ..case.clone() }.id("a")];
        for (i, a) in ids.iter().enumerate() {
            assert!(ids[i + 1..].iter().all(|b| b != a));
        }
        assert_eq!(case.id("a"), case.clone().id("a"));
        assert_eq!(case.id("a").to_string().len(), 32);
    }
}
