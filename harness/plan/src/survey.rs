//! Contents of the steps of a plan, for what refers to them.

use super::Checked;
use super::name::Name;
use super::quantities::{COMMON_TAGS, DURING_PREFIX};
use super::quantity::{Filter, QuantityName};
use super::reaction::{self, Reaction};
use super::subject::Subject;
use described::hint::proposal;
use described::{Mistake, Place};
use std::collections::{BTreeMap, BTreeSet};

/// Contents of the steps so far, for references to them.
#[derive(Default)]
pub(super) struct Survey<'a> {
    pub(super) subject: Subject<'a>,
    pub(super) reactions: &'a [Reaction],
    pub(super) steps: usize,
    /// Fits: what each is of, and whether a calibration has a place for it.
    pub(super) fits: BTreeMap<&'a str, (String, bool)>,
    pub(super) models: Vec<&'a str>,
    /// Answers of the operator, and their units.
    pub(super) answers: BTreeMap<&'a str, &'a str>,
    /// Units of what steps read, by the step and the name; `None` if the rig is not loaded.
    reads: BTreeMap<(&'static str, &'a str), Option<String>>,
    pub(super) swept: Vec<String>,
    /// Messages that steps send, and those that they stop sending, with their places.
    pub(super) sent: BTreeSet<&'a str>,
    pub(super) stopped: Vec<(&'a str, Place)>,
    pub(super) phases: Vec<&'a str>,
}

impl<'a> Survey<'a> {
    pub(super) fn new(subject: Subject<'a>, reactions: &'a [Reaction]) -> Self {
        Self { subject, reactions, ..Self::default() }
    }

    /// Steps and labels so far, without duplicates.
    pub(super) fn phases(&self) -> Vec<&'a str> {
        BTreeSet::from_iter(self.phases.iter().copied()).into_iter().collect()
    }

    /// Unit of a quantity; `None` if its device's layout is not loaded.
    pub(super) fn unit(
        &self,
        quantity: &QuantityName,
        at: &Place,
    ) -> Result<Option<String>, Mistake> {
        self.subject.quantity(quantity, at)?;
        if let Some(of_message) = quantity.of_message() {
            return self.subject.unit(of_message, at);
        }
        if let Some(entry) = quantity.entry() {
            return Ok(Some(entry.unit.to_owned()));
        }
        if let Some(name) = quantity.reaction() {
            reaction::find(self.reactions, name, at)?;
            return Ok(Some("s".to_owned()));
        }
        if let Some(line) = quantity.line() {
            return self.subject.line(line, at).map(|()| Some("1".to_owned()));
        }
        if let Some((step, name)) = quantity.read() {
            return self.reads.get(&(step, name)).cloned().ok_or_else(|| {
                let message = format!("no step `{step}` in this plan reads `{name}`");
                let known = self.reads.keys().filter(|(other, _)| *other == step);
                let known: Vec<&str> = known.map(|(_, name)| *name).collect();
                at.mistake(message).help(proposal(name, &known))
            });
        }
        let answer = quantity.operator_answer().unwrap_or_default();
        self.answers.get(answer).map(|unit| Some((*unit).to_owned())).ok_or_else(|| {
            at.mistake(format!("no operator_prompt in this plan asks for `{answer}`"))
        })
    }

    /// Takes what a step reads: its name, and its unit if that is known.
    pub(super) fn reads(
        &mut self,
        step: &'static str,
        name: &'a Name,
        unit: Option<String>,
        at: &Place,
    ) -> Checked {
        let known = self.reads.entry((step, name.as_str())).or_insert_with(|| unit.clone());
        match (known, unit) {
            (Some(known), Some(unit)) if *known != unit => {
                Err(at.key("read").mistake(format!("`{name}` is in {known} in another step")))
            }
            _ => Ok(()),
        }
    }

    /// The first message that steps stop sending and none sends.
    pub(super) fn never_sent(&self) -> Checked {
        let Some((message, at)) = self.stopped.iter().find(|(name, _)| !self.sent.contains(name))
        else {
            return Ok(());
        };
        let sent: Vec<&str> = self.sent.iter().copied().collect();
        let mistake = at.mistake(format!("no step of this plan sends `{message}`"));
        Err(mistake.help(proposal(message, &sent)))
    }

    pub(super) fn filter(&self, quantity: &QuantityName, filter: &Filter, at: &Place) -> Checked {
        filter.tags().try_for_each(|tag| self.tag(quantity, tag, &at.key("where")))
    }

    pub(super) fn tag(&self, quantity: &QuantityName, tag: &str, at: &Place) -> Checked {
        let own = quantity.entry().map_or(&[][..], |entry| entry.tags);
        let known: Vec<&str> = own
            .iter()
            .chain(COMMON_TAGS)
            .copied()
            .chain(self.swept.iter().map(String::as_str))
            .collect();
        let phase = tag.strip_prefix(DURING_PREFIX);
        if known.contains(&tag) || phase.is_some_and(|phase| self.phases.contains(&phase)) {
            return Ok(());
        }
        if let Some(phase) = phase {
            let message = format!("no step or label `{phase}` in this plan");
            return Err(at.mistake(message).help(proposal(phase, &self.phases())));
        }
        Err(at.mistake(format!("`{quantity}` carries no tag `{tag}`")).help(proposal(tag, &known)))
    }
}
