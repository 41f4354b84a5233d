//! Identifies the errors of a gyro beyond its calibration, or of a node's sensor against a reference, and has the
//! controller or the node correct them.

use super::gathered::{self, Selection};
use super::{Action, Engine, StepAction, Waiting};
use controller::mission::Command;
use dataset::export::sensor;
use identification::dataset::Kind;
use identification::finding::{Compensation, Finding, Verdict};
use identification::identify::{Options, identify};
use identification::model::Model;
use identification::units::si_factor;
use plan::made::Found;
use plan::models;
use plan::quantities as q;
use plan::{Identify, Plan, QuantityName, Source, Step};
use record::RecordKind;
use record::outcome::Outcome;
use std::collections::{BTreeMap, BTreeSet};
use wire::time::Timestamp;
use wire::units::Angle;

impl Engine {
    /// Adds models that the plan can use by name.
    #[must_use]
    pub fn with_models(mut self, models: BTreeMap<String, Model>) -> Self {
        self.models = models;
        self
    }

    /// Identifies, keeps the finding and the model, and observes how well the model performs.
    pub(super) fn identify(&mut self, now: Timestamp, step: &Identify) {
        match self.found(step) {
            Ok(found) => {
                let note = format!("identify {}: {}", step.name, in_words(&found.finding));
                self.record(RecordKind::Note(note));
                self.observe_finding(now, step.from, &found.finding);
                let name = step.name.as_str().to_owned();
                self.models.insert(name.clone(), found.model.clone());
                self.actions.push_back(Action::KeepFound { name, found: Box::new(found) });
            }
            Err(why) => {
                self.end_here(now, Outcome::Failed, &why);
            }
        }
    }

    fn found(&self, step: &Identify) -> Result<Found, String> {
        if step.from == Source::Sensor {
            return self.found_of_sensor(step);
        }
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

    fn found_of_sensor(&self, step: &Identify) -> Result<Found, String> {
        let (Some(measured), Some(reference)) = (&step.measured, &step.reference) else {
            return Err("nothing is measured".to_owned());
        };
        if self.corrected.contains(measured) {
            let why = "errors are taken off it already: what is left is no model of it";
            return Err(format!("`{measured}`: {why}"));
        }
        let column = |quantity| sensor::Field {
            quantity,
            unit: models::unit_of(self.signals.unit(quantity)),
        };
        let beside: Vec<_> = step.beside.iter().map(column).collect();
        let over = step.over.as_ref().map(|over| over.as_str());
        let name = format!("{}-{}", self.plan.name, step.name);
        let fields = (&column(measured), &column(reference), &beside[..]);
        let dataset = sensor::dataset(&self.observations, fields, over, &name)?;
        let found = identify(&dataset, None, &Options::default(), &mut |_, _| {})
            .map_err(|error| error.to_string())?;
        Ok(Found { finding: found.finding, model: found.model })
    }

    fn observe_finding(&mut self, now: Timestamp, source: Source, finding: &Finding) {
        let figures = match (source, &finding.compensation) {
            (Source::Sensor, compensation) => {
                let held_out = compensation.as_ref().map(|steps| &steps.held_out);
                held_out.map(|error| [(&q::IDENTIFICATION_KEPT, error.after / error.before)].into())
            }
            (Source::Turns | Source::Laps, _) => {
                degrees(finding, &q::IDENTIFICATION_BEFORE, &q::IDENTIFICATION_AFTER)
            }
            (Source::Series, _) => {
                degrees(finding, &q::IDENTIFICATION_RATE_BEFORE, &q::IDENTIFICATION_RATE_AFTER)
            }
        };
        let left = f64::from(u8::from(finding.verdict == Verdict::StructureLeft));
        self.observe(now, |collector| {
            for (quantity, value) in figures.unwrap_or_default() {
                collector.add(quantity, value, 0.0, &[]);
            }
            collector.add(&q::IDENTIFICATION_EFFECTS, finding.effects.len() as f64, 0.0, &[]);
            collector.add(&q::IDENTIFICATION_LEFT, left, 0.0, &[]);
        });
    }

    /// Has the controller or a node correct by the model of that name; `None` stops all corrections.
    pub(super) fn use_model(&mut self, now: Timestamp, name: Option<&str>) {
        let model = match name.map(|name| (name, self.models.get(name))) {
            None => None,
            Some((_, Some(model))) => Some(model.clone()),
            Some((name, None)) => {
                let why = format!("no model \"{name}\" has been identified or found");
                self.end_here(now, Outcome::Error, &why);
                return;
            }
        };
        if let Some(Model { kind: Kind::Sensor, compensation, .. }) = &model {
            self.correct(now, compensation.as_ref());
            return;
        }
        if model.is_none() {
            for quantity in std::mem::take(&mut self.corrected) {
                self.ask_to_correct(&quantity, None);
            }
        }
        let Some(robot) = &self.robot else {
            if model.is_some() {
                self.end_here(now, Outcome::Failed, "no controller takes a model here");
            }
            return;
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
                self.end_here(now, Outcome::Failed, &refused.to_string());
            }
        }
    }
}

impl Engine {
    /// Has the node of the signal correct it.
    fn correct(&mut self, now: Timestamp, compensation: Option<&Compensation>) {
        let of = compensation.and_then(|steps| Some((steps, QuantityName::new(&steps.of)?)));
        let Some((steps, quantity)) = of.filter(|(_, quantity)| quantity.of_message().is_some())
        else {
            let why = "the model says nothing that could be taken off a signal of a node";
            self.end_here(now, Outcome::Failed, why);
            return;
        };
        self.ask_to_correct(&quantity, Some(steps));
        self.corrected.insert(quantity);
    }

    fn ask_to_correct(&mut self, quantity: &QuantityName, steps: Option<&Compensation>) {
        let Some(of) = quantity.of_message() else { return };
        let (node, signal) = (of.node().to_owned(), of.name().to_owned());
        let compensation = steps.cloned().map(Box::new);
        self.waiting = Waiting::Answer(None);
        self.actions.push_back(Action::Correct { node, signal, compensation });
    }
}

/// Held-out errors of a gyro, in degrees, before and after.
fn degrees(
    finding: &Finding,
    before: &'static q::Quantity,
    after: &'static q::Quantity,
) -> Option<Vec<(&'static q::Quantity, f64)>> {
    let factor = si_factor(&finding.held_out.unit)?;
    let degrees = |value: f64| Angle::from_rad(value * factor).deg();
    let held_out = &finding.held_out;
    Some(vec![(before, degrees(held_out.before)), (after, degrees(held_out.after))])
}

/// Data read under a model show what that model leaves, so the whole model is both together. Two scales in series are
/// added, which is off by their product.
fn on_top(in_force: Option<&Model>, mut found: Model) -> Model {
    if let Some(in_force) = in_force {
        found.terms = in_force.terms.iter().cloned().chain(found.terms).collect();
        for (field, role) in &in_force.fields {
            found.fields.entry(field.clone()).or_insert(*role);
        }
    }
    found
}

/// The parameters that the plan sweeps.
fn swept(steps: &[Step]) -> BTreeSet<String> {
    let parameter = |step: &Step| match &step.action {
        StepAction::Sweep(sweep) => Some(sweep.parameter.to_string()),
        _ => None,
    };
    Step::walk(steps).filter_map(parameter).collect()
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

/// Quantities that the plan judges, fits or identifies from, and those of turns and laps, which a later identification
/// may read whatever the plan does with them.
pub(super) fn wanted(plan: &Plan) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut judged: Vec<&QuantityName> = Vec::new();
    for declared in &plan.measurements {
        judged.push(&declared.quantity);
        judged.extend(declared.check.kind().facts().second_quantity.map(|(_, quantity)| quantity));
    }
    for step in Step::walk(&plan.steps) {
        match &step.action {
            StepAction::Fit(fit) => judged.push(&fit.quantity),
            StepAction::Identify(identify) => {
                let all = q::QUANTITIES.iter().map(|quantity| quantity.name);
                let made_of = all.filter(|name| gathered::is_of(identify.from, name));
                names.extend(made_of.map(str::to_owned));
                judged.extend(identify.of_nodes());
            }
            _ => {}
        }
    }
    names.extend(judged.iter().map(|quantity| quantity.as_str().to_owned()));
    let by_turn_or_lap = |made_by| matches!(made_by, "table_turn" | "lap");
    let always = q::QUANTITIES.iter().filter(|quantity| by_turn_or_lap(quantity.made_by));
    names.extend(always.map(|quantity| quantity.name.to_owned()));
    names
}
