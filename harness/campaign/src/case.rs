//! A case: a seed and a fault schedule; and its result.

use plan::faults::Schedule;
use record::outcome::Outcome;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The property that a controller breaks by a panic.
pub const PANIC: &str = "no_panic";
/// The property that a program under test breaks if it ends or hangs.
pub const KEEPS_RUNNING: &str = "keeps_running";
/// The property that a plan breaks if it does not pass.
pub const PASSES: &str = "passes";

/// One run of a plan.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Seed of all random numbers of the run.
    pub seed: u64,
    /// The faults.
    #[serde(default)]
    pub schedule: Schedule,
}

/// Identity of a case by its content: equal cases of equal plans have equal names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CaseId(u128);

impl Case {
    /// Its name among the cases of the plan with this text.
    pub fn id(&self, plan: &str) -> CaseId {
        CaseId::of(&[record::VERSION, plan, &self.seed.to_string(), &self.schedule.to_toml()])
    }
}

impl CaseId {
    /// The name of these texts, which may contain any characters.
    pub fn of<T: AsRef<[u8]>>(texts: &[T]) -> Self {
        let mut hash = Fnv::new();
        for text in texts.iter().map(T::as_ref) {
            hash.write(&(text.len() as u64).to_le_bytes());
            hash.write(text);
        }
        Self(hash.0)
    }
}

/// FNV-1a, 128 bits (Fowler, Noll, Vo; constants of RFC 9923): the same in all versions and on all platforms.
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

/// A violation of a property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Violated {
    /// The property.
    pub property: String,
    /// Bench time, s.
    pub at_s: f64,
    /// The observation at that time.
    pub what: String,
}

/// Result of one case.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CaseResult {
    /// Outcome of the run, as in its summary.
    pub outcome: String,
    /// Why the run ended so, in one sentence; none if it passed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Broken always-properties, in the order of their declaration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violated: Vec<Violated>,
    /// Smallest margin of each always-property that had something to judge; negative if it broke.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub margins: BTreeMap<String, f64>,
    /// Always-properties for which the run had nothing to judge, and why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub never_judged: BTreeMap<String, String>,
    /// Always-properties `a -> b` that held only because `a` was never true.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub never_asked: BTreeSet<String>,
    /// Sometimes-properties that occurred.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub reached: BTreeSet<String>,
    /// If runs differ: the result of the repetitions, for each property that broke in the first run. A property that is
    /// not in `violated` was not confirmed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub repeated: BTreeMap<String, Repeated>,
    /// How often each fault of the case acted, in their order: how many bytes, frames, outputs, commands or answers it
    /// changed. Empty if that is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub acted: Vec<u64>,
    /// Whether the plan ran to its end with every measurement in its band.
    pub passed: bool,
    /// Whether a controller that takes missions reported a problem: its health became worse than ok after it had been
    /// ok, or it refused or aborted a mission. Used by envelopes, whose journals store it beside the result.
    #[serde(skip)]
    pub announced: bool,
    /// Whether the run stopped at a violation, before its end. Then only this violation is known.
    #[serde(skip)]
    pub stopped: bool,
}

impl CaseResult {
    /// The result of a case of which only the outcome is known.
    pub fn ended(outcome: &str) -> Self {
        Self { outcome: outcome.to_owned(), ..Self::default() }
    }

    /// The result of a case that was interrupted on request.
    pub fn given_up() -> Self {
        Self::ended(Outcome::Aborted.name())
    }

    /// Whether it was interrupted on request, and so says nothing about the case.
    pub fn is_given_up(&self) -> bool {
        self.outcome == Outcome::Aborted.name()
    }

    /// How the case counts in a campaign: `passed` only if the run went to its end, no property broke, and each could be
    /// judged. Measurements are not judged in cases: a fault may well move what they measure.
    pub fn counts_as(&self) -> &str {
        let is_whole = self.violated.is_empty() && self.never_judged.is_empty();
        if self.outcome == Outcome::Passed.name() && !is_whole {
            return Outcome::Failed.name();
        }
        &self.outcome
    }

    /// Whether a fault of the case acted, by its place; `None` if that is not known.
    pub fn has_acted(&self, place: usize) -> Option<bool> {
        self.acted.get(place).map(|times| *times > 0)
    }

    /// Whether this property broke.
    pub fn breaks(&self, property: &str) -> bool {
        self.violated.iter().any(|violated| violated.property == property)
    }
}

/// Result of the repetitions of one case, for one property.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Repeated {
    /// Number of repetitions that broke it.
    pub broke: u64,
    /// Number of repetitions.
    pub of: u64,
    /// The lower bound, at the requested confidence, of the share of all runs that break it.
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
