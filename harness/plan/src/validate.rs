//! Checks of a plan as a whole, beyond the bounds of single values.

use super::contradiction::contradictions;
use super::measurement::Declared;
use super::name::Name;
use super::property::Property;
use super::quantities::{COMMON_TAGS, DURING_PREFIX, find_tag};
use super::quantity::{Filter, QuantityName};
use super::reaction::{self, Reaction};
use super::rig::Rig;
use super::step::{Answer, Fit, Step};
use super::subject::Subject;
use super::{DEPTH_MAX, Plan, STEPS_DONE_MAX, STEPS_MAX};
use crate::faults::Unfit;
use described::hint::proposal;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// One level of a path in the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Segment {
    /// The value of this key.
    Key(&'static str),
    /// The key of this name and its value: a name that the file chooses.
    Entry(String),
    /// The element with this index.
    Index(usize),
    /// These bytes of a text.
    Text(Range<usize>),
}

/// A mistake and its place.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) path: Vec<Segment>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

pub(super) type Checked = Result<(), Fault>;

/// The first mistake; units and names of messages are checked only if the rig is known.
pub(super) fn validate(plan: &Plan, rig: Option<&Rig>) -> Checked {
    let subject = Subject::of(plan, rig)?;
    let mut survey = Survey { subject, reactions: &plan.reactions, ..Survey::default() };
    let mut path = vec![Segment::Key("steps")];
    let done = survey.steps(&plan.steps, &mut path, 1)?;
    if done > STEPS_DONE_MAX {
        let message = format!("{done} steps when carried out, expected at most {STEPS_DONE_MAX}");
        return Err(Fault { path, message, help: None });
    }
    if plan.measurements.is_empty() && !plan.properties.iter().any(Property::is_stated) {
        let message = "a plan that judges nothing, expected at least one [[measurement]]";
        return Err(Fault { path: Vec::new(), message: message.to_owned(), help: None });
    }
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    for (index, declared) in plan.measurements.iter().enumerate() {
        let at = Place { root: &[Segment::Key("measurement"), Segment::Index(index)] };
        if let Some(first) = names.insert(declared.name.as_str(), index) {
            let message = format!("measurement name `{}` is used twice", declared.name);
            let help = format!("the first is number {} in the file", first + 1);
            return Err(at.fault(&[Segment::Key("name")], message, Some(help)));
        }
        survey.measurement(declared, &at)?;
    }
    for (index, send) in plan.finally.iter().enumerate() {
        let at = Place { root: &[Segment::Key("finally"), Segment::Index(index)] };
        subject.send(send, &at)?;
    }
    subject.properties(&plan.properties)?;
    reaction::check(&plan.reactions, rig)?;
    plan.faults.check(plan).map_err(misplaced)?;
    for (index, envelope) in plan.envelopes.iter().enumerate() {
        envelope.check(index)?;
    }
    contradictions(&plan.properties, &plan.steps)
}

/// Adds the place to a mistake in the schedule.
pub(super) fn misplaced(unfit: Unfit) -> Fault {
    let mut path = vec![Segment::Key("fault"), Segment::Index(unfit.index)];
    path.extend(unfit.keys.into_iter().map(Segment::Key));
    Fault { path, message: unfit.message, help: unfit.help }
}

/// A place in the document.
pub(super) struct Place<'a> {
    pub(super) root: &'a [Segment],
}

impl Place<'_> {
    pub(super) fn fault(&self, rest: &[Segment], message: String, help: Option<String>) -> Fault {
        Fault { path: [self.root, rest].concat(), message, help }
    }
}

/// Contents of the steps so far, for references to them.
#[derive(Default)]
pub(super) struct Survey<'a> {
    pub(super) subject: Subject<'a>,
    pub(super) reactions: &'a [Reaction],
    steps: usize,
    pub(super) fits: BTreeMap<&'a str, &'a Fit>,
    pub(super) models: Vec<&'a str>,
    pub(super) answers: BTreeMap<&'a str, &'a Answer>,
    /// Units of what steps read, by the step and the name; `None` if the rig is not loaded.
    reads: BTreeMap<(&'static str, &'a str), Option<String>>,
    pub(super) swept: Vec<String>,
    pub(super) phases: Vec<&'a str>,
}

impl<'a> Survey<'a> {
    /// The number of steps carried out; `path` is restored.
    fn steps(
        &mut self,
        steps: &'a [Step],
        path: &mut Vec<Segment>,
        depth: usize,
    ) -> Result<u64, Fault> {
        if depth > DEPTH_MAX {
            let message = format!("steps nested {depth} deep, expected at most {DEPTH_MAX}");
            return Err(Fault { path: path.clone(), message, help: None });
        }
        let mut done: u64 = 0;
        for (index, step) in steps.iter().enumerate() {
            self.steps += 1;
            let name = step.action.name();
            path.extend([Segment::Index(index), Segment::Key(name)]);
            if self.steps > STEPS_MAX {
                let message = format!("more than {STEPS_MAX} steps in one plan");
                return Err(Fault { path: path.clone(), message, help: None });
            }
            self.phases.push(name);
            self.phases.extend(step.label.as_ref().map(|label| label.as_str()));
            let at = Place { root: path };
            self.subject.admits(&step.action, &at)?;
            step.action.check(self, &at)?;
            path.push(Segment::Key("steps"));
            let within = step.action.steps();
            let once = if within.is_empty() { 0 } else { self.steps(within, path, depth + 1)? };
            let all = once.saturating_mul(step.action.repetitions());
            done = done.saturating_add(1).saturating_add(all);
            path.truncate(path.len() - 3);
        }
        Ok(done)
    }

    /// Steps and labels so far, without duplicates.
    pub(super) fn phases(&self) -> Vec<&'a str> {
        BTreeSet::from_iter(self.phases.iter().copied()).into_iter().collect()
    }

    fn measurement(&self, declared: &Declared, at: &Place<'_>) -> Checked {
        self.filter(&declared.quantity, &declared.filter, at)?;
        let Some(unit) = self.unit(&declared.quantity, at, &[Segment::Key("quantity")])? else {
            return Ok(());
        };
        let kind = declared.check.kind();
        if kind.is_on_the_floor() && unit != "m" {
            let name = declared.check.name();
            let message = format!("`{}` is in {unit}, `{name}` needs m", declared.quantity);
            return Err(at.fault(&[Segment::Key("quantity")], message, None));
        }
        let check = [Segment::Key("check"), Segment::Key(declared.check.name())];
        let in_check = |key| [check[0].clone(), check[1].clone(), Segment::Key(key)];
        if let Some((key, second)) = kind.second_quantity() {
            let second_unit = self.unit(second, at, &in_check(key))?;
            if let Some(second_unit) = second_unit.filter(|second_unit| *second_unit != unit) {
                let message =
                    format!("`{second}` is in {second_unit}, `{}` in {unit}", declared.quantity);
                return Err(at.fault(&in_check(key), message, None));
            }
        }
        if let Some(tag) = kind.against() {
            self.tag(&declared.quantity, tag, at, &in_check("against"))?;
        }
        if let Some(during) = kind.during()
            && !self.phases.contains(&during)
        {
            let help = proposal(during, &self.phases());
            let message = format!("no step or label `{during}` in this plan");
            return Err(at.fault(&in_check("during"), message, Some(help)));
        }
        self.figure_unit(declared, &unit, at)
    }

    fn figure_unit(&self, declared: &Declared, unit: &str, at: &Place<'_>) -> Checked {
        let check = declared.check.kind();
        let against = check.against().and_then(find_tag).map(|tag| tag.unit);
        if against.is_none() && check.against().is_some() {
            // Only its device knows the unit of a swept parameter.
            return Ok(());
        }
        let expected = check.figure_unit(unit, against.unwrap_or("1"));
        if declared.unit == expected {
            return Ok(());
        }
        let kind = declared.check.name();
        let message = format!("unit `{}`, expected `{expected}`", declared.unit);
        let help = format!("`{kind}` of `{}` is judged in `{expected}`", declared.quantity);
        Err(at.fault(&[Segment::Key("unit")], message, Some(help)))
    }

    /// Unit of a quantity; `None` if its device's layout is not loaded.
    fn unit(
        &self,
        quantity: &QuantityName,
        at: &Place<'_>,
        here: &[Segment],
    ) -> Result<Option<String>, Fault> {
        self.subject.quantity(quantity, at, here)?;
        if let Some(of_message) = quantity.of_message() {
            return self.subject.unit(of_message, at, here);
        }
        if let Some(entry) = quantity.entry() {
            return Ok(Some(entry.unit.to_owned()));
        }
        if let Some(name) = quantity.reaction() {
            reaction::find(self.reactions, name, at, here)?;
            return Ok(Some("s".to_owned()));
        }
        if let Some((step, name)) = quantity.read() {
            return self.reads.get(&(step, name)).cloned().ok_or_else(|| {
                let message = format!("no step `{step}` in this plan reads `{name}`");
                let known = self.reads.keys().filter(|(other, _)| *other == step);
                let known: Vec<&str> = known.map(|(_, name)| *name).collect();
                at.fault(here, message, Some(proposal(name, &known)))
            });
        }
        let answer = quantity.operator_answer().unwrap_or_default();
        self.answers.get(answer).map(|answer| Some(answer.unit.clone())).ok_or_else(|| {
            let message = format!("no operator_prompt in this plan asks for `{answer}`");
            at.fault(here, message, None)
        })
    }

    /// Takes what a step reads: its name, and its unit if that is known.
    pub(super) fn reads(
        &mut self,
        step: &'static str,
        name: &'a Name,
        unit: Option<String>,
        at: &Place<'_>,
    ) -> Checked {
        let known = self.reads.entry((step, name.as_str())).or_insert_with(|| unit.clone());
        match (known, unit) {
            (Some(known), Some(unit)) if *known != unit => {
                let message = format!("`{name}` is in {known} in another step");
                Err(at.fault(&[Segment::Key("read")], message, None))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn filter(
        &self,
        quantity: &QuantityName,
        filter: &Filter,
        at: &Place<'_>,
    ) -> Checked {
        filter.tags().try_for_each(|tag| self.tag(quantity, tag, at, &[Segment::Key("where")]))
    }

    pub(super) fn tag(
        &self,
        quantity: &QuantityName,
        tag: &str,
        at: &Place<'_>,
        here: &[Segment],
    ) -> Checked {
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
        let message = format!("`{quantity}` carries no tag `{tag}`");
        Err(at.fault(here, message, Some(proposal(tag, &known))))
    }
}
