//! The table of events: one row per event, with a description.

use super::cell::{Cell, Row, time};
use controller::mission::Report;
use record::FaultEvent;
use record::outcome::{PropertySummary, Summary};
use record::text::name_of;
use record::{Device, Record, RecordKind};
use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;
use wire::time::Timestamp;

#[derive(Debug, Clone, PartialEq)]
pub struct Event<'a> {
    pub at: Timestamp,
    pub device: Device,
    pub kind: EventKind,
    pub subject: Cow<'a, str>,
    /// Number of the mission, or of the fault in the schedule.
    pub id: Option<i64>,
    pub text: Cow<'a, str>,
    pub details: Option<Value>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A step of the plan began; the subject is its place in the plan.
    StepBegan,
    StepEnded,
    /// The plan sent a command to the controller.
    Command,
    Done,
    /// A mission was refused; the subject is the reason.
    Refused,
    /// A mission was aborted; the subject is the reason.
    Aborted,
    /// A problem, a loss or a recovery.
    Note,
    /// A person answered or did something.
    Reply,
    /// A fault began; the subject is its kind and target.
    FaultBegan,
    FaultEnded,
    FaultNeverHappened,
    /// The error state of a bus node changed.
    Confinement,
    Verdict,
    Property,
    /// How the run ended.
    Outcome,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    Info,
    Warning,
    Error,
}

impl Event<'_> {
    pub fn row(&self) -> Row<'_> {
        vec![
            time(self.at),
            Cell::text(self.device.name()),
            Cell::text(name_of(&self.kind)),
            Cell::text(&*self.subject),
            self.id.map_or(Cell::Missing, Cell::Integer),
            Cell::text(&*self.text),
            self.details.as_ref().map_or(Cell::Missing, |value| Cell::text(value.to_string())),
        ]
    }

    pub fn severity(&self) -> Severity {
        match self.kind {
            EventKind::Refused | EventKind::Aborted => Severity::Error,
            EventKind::Verdict | EventKind::Property | EventKind::Outcome => {
                match &*self.came_to() {
                    "fail" | "unset" | "broken" | "failed" | "error" | "timeout" => Severity::Error,
                    "marginal" | "aborted" | "not judged" | "not_judged" => Severity::Warning,
                    _ => Severity::Info,
                }
            }
            EventKind::Note
            | EventKind::FaultBegan
            | EventKind::FaultNeverHappened
            | EventKind::Confinement => Severity::Warning,
            _ => Severity::Info,
        }
    }

    /// Result of a verdict, a property or the run.
    fn came_to(&self) -> Cow<'_, str> {
        let word = self.details.as_ref().and_then(|details| details["came_to"].as_str());
        word.map_or(Cow::Borrowed(""), Cow::Borrowed)
    }
}

/// The event in a record; `None` for a state, an observation, or bytes.
pub fn of(record: &Record) -> Option<Event<'_>> {
    let event = |kind, subject: &dyn ToString, text: String| Event {
        at: record.at,
        device: record.device,
        kind,
        subject: subject.to_string().into(),
        id: None,
        text: text.into(),
        details: None,
    };
    Some(match &record.kind {
        RecordKind::StepBegan { path, title } => event(EventKind::StepBegan, path, title.clone()),
        RecordKind::StepEnded { path } => event(EventKind::StepEnded, path, "ended".to_owned()),
        RecordKind::Command(command) => {
            let details = json(command);
            let name = name_in(&details);
            let text = format!("told to {}", name.replace('_', " "));
            Event { details: content(details), ..event(EventKind::Command, &name, text) }
        }
        RecordKind::Report(Report::Done { id, result }) => {
            let details = json(result);
            let name = name_in(&details);
            let (id, text) = (Some(i64::from(*id)), format!("done: {}", name.replace('_', " ")));
            Event { id, details: content(details), ..event(EventKind::Done, &name, text) }
        }
        RecordKind::Report(Report::Refused { id, reason }) => {
            let name = name_of(reason);
            let text = format!("refused: {}", name.replace('_', " "));
            Event { id: Some(i64::from(*id)), ..event(EventKind::Refused, &name, text) }
        }
        RecordKind::Report(Report::Aborted { id, reason }) => {
            let name = name_of(reason);
            let text = format!("broken off: {}", name.replace('_', " "));
            Event { id: Some(i64::from(*id)), ..event(EventKind::Aborted, &name, text) }
        }
        RecordKind::Note(text) => event(EventKind::Note, &"", text.clone()),
        RecordKind::Reply(reply) => {
            let subject = reply.number.as_ref().map_or("done", |number| &number.name);
            let details = Some(json(reply));
            Event { details, ..event(EventKind::Reply, &subject, reply.to_string()) }
        }
        RecordKind::Fault(fault) => {
            let kind = match fault.event {
                FaultEvent::Began => EventKind::FaultBegan,
                FaultEvent::Ended { .. } => EventKind::FaultEnded,
                FaultEvent::NeverHappened { .. } => EventKind::FaultNeverHappened,
                FaultEvent::Confinement { .. } => EventKind::Confinement,
            };
            let (id, details) = (Some(i64::from(fault.index)), content(json(&fault.event)));
            Event { id, details, ..event(kind, &fault.name, fault.to_string()) }
        }
        RecordKind::Bytes(_)
        | RecordKind::Frame(_)
        | RecordKind::Truth { .. }
        | RecordKind::Observation(_)
        | RecordKind::Report(Report::State(_) | Report::Health(_)) => return None,
    })
}

/// Events of a run's results, at its end.
pub fn of_summary(at: Timestamp, summary: &Summary) -> impl Iterator<Item = Event<'_>> {
    let event = move |kind, subject: &'_ str, text: String, came_to: &str| Event {
        at,
        device: Device::Plan,
        kind,
        subject: subject.to_owned().into(),
        id: None,
        text: text.into(),
        details: Some(serde_json::json!({ "came_to": came_to })),
    };
    let verdicts = summary.measurements.iter().map(move |measurement| {
        let value = measurement.figure().unwrap_or_else(|| measurement.statistic.clone());
        let verdict = measurement.verdict.name();
        let text = format!("{}: {verdict}, {value}", measurement.name);
        event(EventKind::Verdict, &measurement.name, text, verdict)
    });
    let properties = summary.properties.iter().map(move |property| {
        let (came_to, why) = of_property(property);
        let text =
            format!("{}: {came_to}{}{why}", property.name, if why.is_empty() { "" } else { ", " });
        event(EventKind::Property, &property.name, text, came_to)
    });
    let outcome = summary.outcome.name();
    let reason = summary.reason.as_deref().map_or(String::new(), |reason| format!(": {reason}"));
    let ended = event(EventKind::Outcome, outcome, format!("{outcome}{reason}"), outcome);
    verdicts.chain(properties).chain(std::iter::once(ended))
}

fn of_property(property: &PropertySummary) -> (&'static str, &str) {
    match (property.held, property.always) {
        (None, _) => ("not judged", property.not_judged.as_deref().unwrap_or("")),
        (Some(true), true) => ("held", ""),
        (Some(false), true) => ("broken", property.what.as_deref().unwrap_or("")),
        (Some(true), false) => ("came about", ""),
        (Some(false), false) => ("did not come about", ""),
    }
}

/// A value as JSON; null if JSON cannot express it.
fn json(value: &impl Serialize) -> Value {
    serde_json::to_value(value).unwrap_or(Value::Null)
}

/// Name of a variant: the only key of an object, or the text.
fn name_in(value: &Value) -> String {
    match value {
        Value::String(name) => name.clone(),
        Value::Object(one) => one.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}

/// Contents of a variant; `None` for a plain name.
fn content(value: Value) -> Option<Value> {
    match value {
        Value::Object(one) => one.into_iter().next().map(|(_, content)| content),
        _ => None,
    }
}
