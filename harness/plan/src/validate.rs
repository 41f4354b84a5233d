//! Checks of a plan as a whole, beyond the bounds of single values.

use super::contradiction::contradictions;
use super::measurement::Declared;
use super::mistake::{Checked, Fault, Place, Segment};
use super::property::Property;
use super::quantities::find_tag;
use super::reaction;
use super::rig::Rig;
use super::step::Step;
use super::subject::Subject;
use super::survey::Survey;
use super::{DEPTH_MAX, Plan, STEPS_DONE_MAX, STEPS_MAX};
use described::hint::proposal;
use std::collections::BTreeMap;

/// The first mistake; units and names of messages are checked only if the rig is known.
pub(super) fn validate(plan: &Plan, rig: Option<&Rig>) -> Checked {
    let subject = Subject::of(plan, rig)?;
    let mut survey = Survey::new(subject, &plan.reactions);
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
        subject.send(&send.message, &send.set, &at)?;
    }
    subject.properties(&plan.properties)?;
    reaction::check(&plan.reactions, rig)?;
    plan.faults.check(plan)?;
    for (index, envelope) in plan.envelopes.iter().enumerate() {
        envelope.check(index)?;
    }
    contradictions(&plan.properties, &plan.steps)
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
            step.action.needs().check(name, &self.subject, &at)?;
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
}
