//! How a run without faults went by.

use plan::Name;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::time::Span;

/// Longest time from the start of a phase to that of a fault, if it is not known how long the phase takes. Assumption:
/// turns and straights take some seconds.
const AFTER_MAX: Span = Span::from_secs(10);

/// How long a run without faults took, and each of its phases.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Course {
    /// The whole run.
    #[serde(rename = "lasted_ns")]
    pub lasted: Span,
    /// The occurrences of each phase, in their order, as far as they were looked at. Empty if they are not known.
    #[serde(default, rename = "phases_ns", skip_serializing_if = "BTreeMap::is_empty")]
    pub phases: BTreeMap<String, Vec<Span>>,
}

impl Course {
    /// How long this occurrence of a phase took: a fault that begins later strikes something else.
    pub(super) fn length(&self, phase: &Name, number: u32) -> Span {
        let usual = || AFTER_MAX.min(self.lasted);
        let Some(known) = self.phases.get(phase.as_str()) else { return usual() };
        let this = known.get((number as usize).saturating_sub(1));
        // A repeat may end early: another occurrence is the best guess.
        this.or_else(|| known.iter().max()).copied().unwrap_or_else(usual)
    }

    /// The time at `share` of this occurrence of a phase: before its end, in whole ms.
    pub(super) fn within(&self, phase: &Name, number: u32, share: f64) -> Span {
        let length_ms = self.length(phase, number).as_secs_f64() * 1e3;
        Span::from_millis((share * length_ms) as i64)
    }
}

/// Nothing is known of its phases.
impl From<Span> for Course {
    fn from(lasted: Span) -> Self {
        Self { lasted, phases: BTreeMap::new() }
    }
}
