//! Checks of a plan as a whole, beyond the bounds of single values.

use super::Checked;
use super::contradiction::contradictions;
use super::measurement::Declared;
use super::property::Property;
use super::quantities::{SINCE_START, find_tag};
use super::reaction;
use super::rig::Rig;
use super::speakers::OfMessage;
use super::step::Step;
use super::subject::Subject;
use super::survey::Survey;
use super::{DEPTH_MAX, Plan, STEPS_DONE_MAX, STEPS_MAX};
use described::hint::proposal;
use described::{Mistake, Place};
use std::collections::BTreeMap;
use wire::time::Span;

/// The first mistake; units and names of messages are checked only if the rig is known.
pub(super) fn validate(plan: &Plan, rig: Option<&Rig>) -> Checked {
    let subject = Subject::of(plan, rig)?;
    let mut survey = Survey::new(subject, &plan.reactions);
    let at = Place::file().key("steps");
    let done = survey.steps(&plan.steps, &at, 1)?;
    if done > STEPS_DONE_MAX {
        let message = format!("{done} steps when carried out, expected at most {STEPS_DONE_MAX}");
        return Err(at.mistake(message));
    }
    // Whether there is such a message at all shows with the rig, and comes first.
    if rig.is_some() {
        survey.never_sent()?;
    }
    let judges = !plan.measurements.is_empty()
        || plan.properties.iter().any(Property::is_stated)
        || Step::walk(&plan.steps).any(|step| step.action.judges());
    if !judges {
        let message = "a plan that judges nothing, expected a [[measurement]], a [[property]] with a formula, or a step that \
                       judges (uds, sdo, wait_until, reaction)";
        return Err(Place::file().mistake(message));
    }
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    for (index, declared) in plan.measurements.iter().enumerate() {
        let at = Place::file().key("measurement").index(index);
        if let Some(first) = names.insert(declared.name.as_str(), index) {
            let message = format!("measurement name `{}` is used twice", declared.name);
            let help = format!("the first is number {} in the file", first + 1);
            return Err(at.key("name").mistake(message).help(help));
        }
        survey.measurement(declared, &at)?;
    }
    for (index, send) in plan.finally.iter().enumerate() {
        let at = Place::file().key("finally").index(index);
        subject.send(&send.message, &send.set, &at)?;
        if send.every.is_some_and(|every| every != Span::ZERO) {
            let help = "nothing is sent after it: leave `every_s` out";
            return Err(at.key("every_s").mistake("`finally` sends each message once").help(help));
        }
    }
    subject.properties(&plan.properties)?;
    reaction::check(&plan.reactions, rig)?;
    plan.faults.check(plan)?;
    for (index, envelope) in plan.envelopes.iter().enumerate() {
        envelope.check(index)?;
    }
    contradictions(plan)
}

impl<'a> Survey<'a> {
    /// The number of steps carried out in the list at this place.
    fn steps(&mut self, steps: &'a [Step], list: &Place, depth: usize) -> Result<u64, Mistake> {
        if depth > DEPTH_MAX {
            let message = format!("steps nested {depth} deep, expected at most {DEPTH_MAX}");
            return Err(list.mistake(message));
        }
        let mut done: u64 = 0;
        for (index, step) in steps.iter().enumerate() {
            self.steps += 1;
            let name = step.action.name();
            let at = list.index(index).key(name);
            if self.steps > STEPS_MAX {
                return Err(at.mistake(format!("more than {STEPS_MAX} steps in one plan")));
            }
            self.phases.push(name);
            self.phases.extend(step.label.as_ref().map(|label| label.as_str()));
            step.action.needs().check(name, &self.subject, &at)?;
            step.action.check(self, &at)?;
            let within = step.action.steps();
            let once = match within.is_empty() {
                true => 0,
                false => self.steps(within, &at.key("steps"), depth + 1)?,
            };
            let all = once.saturating_mul(step.action.repetitions());
            done = done.saturating_add(1).saturating_add(all);
        }
        Ok(done)
    }

    fn measurement(&self, declared: &Declared, at: &Place) -> Checked {
        self.filter(&declared.quantity, &declared.filter, at)?;
        let Some(unit) = self.unit(&declared.quantity, &at.key("quantity"))? else {
            return Ok(());
        };
        self.since(declared, at)?;
        let facts = declared.check.kind().facts();
        if facts.is_on_the_floor && unit != "m" {
            let name = declared.check.name();
            let message = format!("`{}` is in {unit}, `{name}` needs m", declared.quantity);
            return Err(at.key("quantity").mistake(message));
        }
        let in_check = |key| at.key("check").key(declared.check.name()).key(key);
        if let Some((key, second)) = facts.second_quantity {
            let second_unit = self.unit(second, &in_check(key))?;
            if let Some(second_unit) = second_unit.filter(|second_unit| *second_unit != unit) {
                let message =
                    format!("`{second}` is in {second_unit}, `{}` in {unit}", declared.quantity);
                return Err(in_check(key).mistake(message));
            }
        }
        if let Some(tag) = facts.against {
            self.tag(&declared.quantity, tag, &in_check("against"))?;
        }
        if let Some(during) = facts.during
            && !self.phases.contains(&during)
        {
            let help = proposal(during, &self.phases());
            let message = format!("no step or label `{during}` in this plan");
            return Err(in_check("during").mistake(message).help(help));
        }
        self.figure_unit(declared, &unit, at)
    }

    fn since(&self, declared: &Declared, at: &Place) -> Checked {
        let Some(since) = &declared.since else { return Ok(()) };
        if !matches!(declared.quantity.of_message(), Some(OfMessage::Period { .. })) {
            let message = format!("`{}` has no time before its first message", declared.quantity);
            let help = "`since` goes with `period`: leave it out";
            return Err(at.key("since").mistake(message).help(help));
        }
        let mut known = self.phases();
        known.push(SINCE_START);
        if !known.contains(&since.as_str()) {
            let message = format!("no step or label `{since}` in this plan");
            return Err(at.key("since").mistake(message).help(proposal(since.as_str(), &known)));
        }
        Ok(())
    }

    fn figure_unit(&self, declared: &Declared, unit: &str, at: &Place) -> Checked {
        let facts = declared.check.kind().facts();
        let against = facts.against.and_then(find_tag).map(|tag| tag.unit);
        if against.is_none() && facts.against.is_some() {
            // Only its device knows the unit of a swept parameter.
            return Ok(());
        }
        let expected = facts.figure_unit(unit, against.unwrap_or("1"));
        if declared.unit == expected {
            return Ok(());
        }
        let kind = declared.check.name();
        let message = format!("unit `{}`, expected `{expected}`", declared.unit);
        let help = format!("`{kind}` of `{}` is judged in `{expected}`", declared.quantity);
        Err(at.key("unit").mistake(message).help(help))
    }
}
