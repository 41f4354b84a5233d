//! Waits for a reaction.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::reaction;
use crate::survey::Survey;
use crate::time_limits::REACTION_LIMIT;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// The step that waits for a reaction: `reaction = "opening"`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct AwaitReaction {
    /// That of a `[[reaction]]` of the plan.
    pub name: Name,
}

impl StepKind for AwaitReaction {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "wait for the reaction {}", self.name)
    }

    fn judges(&self) -> bool {
        true
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Reaction(self.name.as_str().to_owned())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        reaction::find(survey.reactions, self.name.as_str(), at)
    }

    fn limit(&self) -> Span {
        REACTION_LIMIT
    }
}
