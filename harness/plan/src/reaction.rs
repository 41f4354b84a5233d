//! Reactions: the time that the nodes of a rig take from one condition to another.
//!
//! ```toml
//! [[reaction]]
//! name = "opening"
//! from = "cells.VoltageMax > 4.25 V"
//! to = "manager.ContactorClosed == 0"
//! ```
//!
//! Each time `from` becomes true, the time until `to` holds next is an observation of the quantity `reaction.opening`,
//! in s, for measurements to judge. If there is no response before the run ends, the observation is the time until the
//! end, a lower bound.
//!
//! The step `reaction = "opening"` waits for one reaction: until `from` has become true since the step began, and `to`
//! has held since then.

use super::formula::formula;
use super::name::Name;
use super::rig::Rig;
use described::hint::proposal;
use described::{Mistake, Place};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeSet;

/// One `[[reaction]]` of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Its quantity is `reaction.<name>`.
    pub name: Name,
    /// A formula over signals: the time begins when it becomes true.
    pub from: String,
    /// A formula over signals: the time ends when it holds.
    pub to: String,
}

/// The first mistake in `reactions`; formulas are only parsed if the rig is known.
pub(super) fn check(reactions: &[Reaction], rig: Option<&Rig>) -> Result<(), Mistake> {
    let mut names = BTreeSet::new();
    for (index, reaction) in reactions.iter().enumerate() {
        let at = Place::file().key("reaction").index(index);
        if !names.insert(reaction.name.as_str()) {
            let message = format!("reaction name `{}` is used twice", reaction.name);
            return Err(at.key("name").mistake(message));
        }
        let Some(rig) = rig else { continue };
        for (key, text) in [("from", &reaction.from), ("to", &reaction.to)] {
            if let Err(mistake) = formula(text, &rig.speakers) {
                let within = at.key(key).within(mistake.at);
                return Err(within.mistake(mistake.message).with_help(mistake.help));
            }
        }
    }
    Ok(())
}

pub(super) fn find(reactions: &[Reaction], name: &str, at: &Place) -> Result<(), Mistake> {
    let known: Vec<&str> = reactions.iter().map(|reaction| reaction.name.as_str()).collect();
    if known.contains(&name) {
        return Ok(());
    }
    Err(at.mistake(format!("no [[reaction]] `{name}` in this plan")).help(proposal(name, &known)))
}
