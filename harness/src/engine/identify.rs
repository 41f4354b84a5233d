//! Identifies what a gyro does beyond its calibration, and has the controller correct by it.

use super::gathered::{self, Selection};
use super::{Action, Engine, StepAction};
use crate::made::Found;
use crate::models;
use crate::outcome::Outcome;
use crate::plan::quantities as q;
use crate::plan::{Identify, Source, Step};
use crate::record::RecordKind;
use controller::mission::Command;
use identification::finding::{Finding, Verdict};
use identification::identify::{Options, identify};
use identification::model::Model;
use identification::units::si_factor;
use std::collections::BTreeSet;
use wire::time::Timestamp;
use wire::units::Angle;

impl Engine {
    /// The step's identification.
    pub(super) fn identify(&mut self, now: Timestamp) {
        let Some((StepAction::Identify(step), _)) = &self.step else { return };
        let step = step.clone();
        match self.found(&step) {
            Ok(found) => {
                let note = format!("identify {}: {}", step.name, in_words(&found.finding));
                self.record(RecordKind::Note(note));
                self.observe_finding(now, step.from, &found.finding);
                let name = step.name.as_str().to_owned();
                if let Some(robot) = &mut self.robot {
                    robot.models.insert(name.clone(), found.model.clone());
                }
                self.actions.push_back(Action::KeepFound { name, found: Box::new(found) });
            }
            Err(why) => {
                let reason = format!("{}: {why}", self.place());
                self.end(now, Outcome::Failed, Some(reason));
            }
        }
    }

    fn found(&self, step: &Identify) -> Result<Found, String> {
        let robot = self.robot.as_ref().ok_or("there is no robot here")?;
        let selection = Selection {
            source: step.from,
            over: step.over.as_ref().map(|over| over.as_str()),
            since_s: (robot.calibration_since - self.began).as_secs_f64(),
            heading_source: robot.heading_source,
        };
        let name = format!("{}-{}", self.plan.name, step.name);
        let swept = swept(&self.plan.steps);
        let dataset = gathered::dataset(&self.observations, &selection, &swept, &name)?;
        let found = identify(&dataset, None, &Options::default(), &mut |_, _| {})
            .map_err(|error| error.to_string())?;
        Ok(Found { finding: found.finding, model: on_top(robot.model.as_ref(), found.model) })
    }

    fn observe_finding(&mut self, now: Timestamp, source: Source, finding: &Finding) {
        let Some(factor) = si_factor(&finding.held_out.unit) else { return };
        let degrees = |value: f64| Angle::from_rad(value * factor).deg();
        let (before, after) = match source {
            Source::Turns | Source::Laps => (&q::IDENTIFICATION_BEFORE, &q::IDENTIFICATION_AFTER),
            Source::Series => (&q::IDENTIFICATION_RATE_BEFORE, &q::IDENTIFICATION_RATE_AFTER),
        };
        let left = f64::from(u8::from(finding.verdict == Verdict::StructureLeft));
        self.observe(now, |collector| {
            collector.add(before, degrees(finding.held_out.before), 0.0, &[]);
            collector.add(after, degrees(finding.held_out.after), 0.0, &[]);
            collector.add(&q::IDENTIFICATION_EFFECTS, finding.effects.len() as f64, 0.0, &[]);
            collector.add(&q::IDENTIFICATION_LEFT, left, 0.0, &[]);
        });
    }

    /// Has the controller correct by the model of that name, or by none any more.
    pub(super) fn use_model(&mut self, now: Timestamp, name: Option<&str>) {
        let Some(robot) = &self.robot else { return };
        let model = match name.map(|name| (name, robot.models.get(name))) {
            None => None,
            Some((_, Some(model))) => Some(model.clone()),
            Some((name, None)) => {
                let reason =
                    format!("{}: no model \"{name}\" has been identified or found", self.place());
                self.end(now, Outcome::Error, Some(reason));
                return;
            }
        };
        let mut calibration = robot.calibration.clone();
        calibration.corrections.clear();
        let calibration = match &model {
            None => Ok(calibration),
            Some(model) => models::calibration(model, &calibration),
        };
        match calibration {
            Ok(calibration) => {
                self.send(now, Command::SetCalibration(calibration));
                if let Some(robot) = &mut self.robot {
                    robot.model = model;
                }
            }
            Err(refused) => {
                let reason = format!("{}: {refused}", self.place());
                self.end(now, Outcome::Failed, Some(reason));
            }
        }
    }
}

/// What was read under a model shows what that leaves: the whole model is both. Two scales that
/// follow each other are taken as their sum, which is off by their product.
fn on_top(in_force: Option<&Model>, mut found: Model) -> Model {
    if let Some(in_force) = in_force {
        found.terms = in_force.terms.iter().cloned().chain(found.terms).collect();
        for (field, role) in &in_force.fields {
            found.fields.entry(field.clone()).or_insert(*role);
        }
    }
    found
}

/// Quantities that the plan's identifications are made from.
pub(super) fn needed(steps: &[Step], names: &mut BTreeSet<String>) {
    for step in steps {
        if let StepAction::Identify(identify) = &step.action {
            let all = q::QUANTITIES.iter().map(|quantity| quantity.name);
            let made_of = all.filter(|name| gathered::is_of(identify.from, name));
            names.extend(made_of.map(str::to_owned));
        }
        needed(step.action.steps(), names);
    }
}

/// The parameters that the plan sweeps.
fn swept(steps: &[Step]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for step in steps {
        if let StepAction::Sweep(sweep) = &step.action {
            names.insert(sweep.parameter.to_string());
        }
        names.extend(swept(step.action.steps()));
    }
    names
}

fn in_words(finding: &Finding) -> String {
    let held_out = &finding.held_out;
    let effects: Vec<_> = finding.effects.iter().map(|effect| effect.name.as_str()).collect();
    let effects = if effects.is_empty() { "no effect".to_owned() } else { effects.join(", ") };
    let unit = &held_out.unit;
    format!(
        "{effects}; held-out error {:.4} {unit}, before {:.4} {unit}",
        held_out.after, held_out.before
    )
}
