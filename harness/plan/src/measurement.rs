//! The declaration of a measurement, with its band and its place in the paper.

use super::band::Band;
use super::check::{Check, Meant, Selection};
use super::name::Name;
use super::observation::Observations;
use super::quantities::{DURING_PREFIX, during_tag};
use super::quantity::{Filter, QuantityName};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::num::NonZeroU32;

/// One `[[measurement]]` of a plan.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Declared {
    /// Unique in the plan.
    pub name: Name,
    /// What it shows, in a sentence.
    pub doc: String,
    /// What is observed.
    pub quantity: QuantityName,
    /// Which of its observations are meant; all where it is absent.
    #[serde(rename = "where", default)]
    pub filter: Filter,
    /// Of a `period`: the time before the first message counts, too, since the `start` of the run, or since this step
    /// or label first began.
    #[serde(default)]
    pub since: Option<Name>,
    /// Unit of the figure that is judged; `1` for shares, counts and ratios.
    pub unit: String,
    /// What it must satisfy.
    pub check: Check,
    /// What the paper gives, with its place.
    #[serde(default)]
    pub paper: Option<String>,
    /// What it proves, where that is said.
    #[serde(default)]
    pub proves: Option<Proves>,
    /// The band was found with a reference as uncertain as ours: the observations' own uncertainties do not narrow it again.
    #[serde(default)]
    pub band_holds_reference: bool,
    /// With fewer observations than this it is unset, and fails.
    #[serde(default = "one")]
    pub observations_min: NonZeroU32,
}

impl Declared {
    /// Those of `observations` that are judged. These may contain other quantities and be in any order.
    pub fn select<'a>(&self, observations: &'a Observations) -> Selection<'a> {
        let facts = self.check.kind().facts();
        let is_of_message = self.quantity.of_message().is_some();
        // How long an open gap would have been is unknown: a figure of all values is not formed with it.
        let band = facts.value_band.or((!is_of_message).then_some(facts.figure_band));
        let meant = Meant {
            quantity: &self.quantity,
            second: facts.second_quantity.map(|(_, quantity)| quantity),
            filter: &self.filter,
            during: facts.during,
            since: self.since.as_ref().map(Name::as_str),
            least: self.observations_min.get() as usize,
            most: band.and_then(Band::upper),
        };
        Selection::new(&meant, observations)
    }

    /// Whether an observation with these tags is judged.
    pub fn is_judged_at(&self, tags: &BTreeMap<String, f64>) -> bool {
        let has = |tag: &str| tags.get(tag).copied();
        let is_during = |phase| has(&during_tag(phase)).is_some_and(|value| value != 0.0);
        self.filter.matches(has) && self.check.kind().facts().during.is_none_or(is_during)
    }

    /// The steps and labels in which it judges.
    pub fn phases(&self) -> impl Iterator<Item = &str> {
        let tags = self.filter.tags().filter_map(|tag| tag.strip_prefix(DURING_PREFIX));
        tags.chain(self.check.kind().facts().during)
    }

    /// Whether a gap between two messages that has lasted so long, in s, is already outside of the band.
    pub fn is_broken_by_gap(&self, seconds: f64) -> bool {
        let most = self.check.kind().facts().value_band.and_then(Band::upper);
        most.is_some_and(|most| seconds > most)
    }
}

/// What a measurement proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Proves {
    /// What the controller did or says is held against a truth that is not its own.
    TestsTheController,
    /// What went in comes out again, or the controller judges itself: arithmetic and wiring.
    ConsistencyOfInputs,
}

impl Proves {
    /// For a table column: the component whose fault a failure would show.
    pub const fn short(self) -> &'static str {
        match self {
            Self::TestsTheController => "controller",
            Self::ConsistencyOfInputs => "inputs",
        }
    }
}

fn one() -> NonZeroU32 {
    NonZeroU32::MIN
}
