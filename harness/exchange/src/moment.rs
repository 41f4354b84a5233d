//! State of a run at one instant, from its record: `hil show RUN --at T`.

use crate::tables::{Ears, Heard};
use controller::mission::Report;
use record::FaultEvent;
use record::figures;
use record::header::Header;
use record::text::{Head, Line};
use record::{Record, RecordKind};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use wire::time::Timestamp;

/// The latest state of a run: active steps and faults, the last command to the controller and its last reports, the
/// truth, and the last value of every signal and every quantity.
#[derive(Debug)]
pub struct Moment {
    header: Header,
    ears: Ears,
    /// Active steps, outermost first.
    steps: Vec<(String, String)>,
    faults: BTreeMap<u32, String>,
    /// Latest record of each subject.
    lines: BTreeMap<About, String>,
    messages: BTreeMap<(String, usize), Message>,
    /// Messages that the last record completed.
    heard: Vec<(String, usize)>,
    quantities: BTreeMap<String, String>,
}

/// Subjects, in the order of display.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum About {
    Command,
    State,
    Health,
    Answer,
    Truth,
    Confinement(String),
}

#[derive(Debug)]
struct Message {
    at: Timestamp,
    values: Vec<Option<f64>>,
}

impl Moment {
    /// The state before the first record of the run of this header; `ears` decode its messages.
    pub fn new(header: Header, ears: Ears) -> Self {
        Self {
            header,
            ears,
            steps: Vec::new(),
            faults: BTreeMap::new(),
            lines: BTreeMap::new(),
            messages: BTreeMap::new(),
            heard: Vec::new(),
            quantities: BTreeMap::new(),
        }
    }

    pub fn take(&mut self, record: &Record) {
        self.heard.clear();
        let line = |header: &Header| Line(record, header).to_string();
        let about = match &record.kind {
            RecordKind::StepBegan { path, .. } => {
                self.steps.push((path.clone(), line(&self.header)));
                return;
            }
            RecordKind::StepEnded { path } => {
                self.steps.retain(|(on, _)| on != path);
                return;
            }
            RecordKind::Observation(observation) => {
                self.quantities.insert(observation.quantity.clone(), line(&self.header));
                return;
            }
            RecordKind::Bytes(_) | RecordKind::Frame(_) => return self.hear(record),
            RecordKind::Fault(fault) => match &fault.event {
                FaultEvent::Began => {
                    self.faults.insert(fault.index, line(&self.header));
                    return;
                }
                FaultEvent::Ended { .. } => {
                    self.faults.remove(&fault.index);
                    return;
                }
                FaultEvent::NeverHappened { .. } => return,
                FaultEvent::Confinement { node, .. } => About::Confinement(node.clone()),
            },
            RecordKind::Command(_) => About::Command,
            RecordKind::Report(Report::State(_)) => About::State,
            RecordKind::Report(Report::Health(_)) => About::Health,
            RecordKind::Report(_) => About::Answer,
            RecordKind::Truth { .. } => About::Truth,
            RecordKind::Note(_) | RecordKind::Reply(_) => return,
        };
        self.lines.insert(about, line(&self.header));
    }

    fn hear(&mut self, record: &Record) {
        let Self { header, ears, messages, heard: completed, .. } = self;
        ears.take(record, header, &mut |heard: &Heard<'_>| {
            let signals = heard.values.len();
            let name = (heard.who.to_owned(), heard.index);
            completed.push(name.clone());
            let message = messages
                .entry(name)
                .or_insert_with(|| Message { at: record.at, values: vec![None; signals] });
            message.at = record.at;
            // A signal that this message does not carry keeps its last value.
            for (last, said) in message.values.iter_mut().zip(&heard.values) {
                *last = said.or(*last);
            }
        });
    }

    /// The messages that the last record completed, one line each.
    pub fn heard(&self) -> Vec<String> {
        let message = |name| Some(self.message(name, self.messages.get(name)?));
        self.heard.iter().filter_map(message).collect()
    }

    fn message(&self, (who, index): &(String, usize), message: &Message) -> String {
        let form = &self.ears.forms()[*index];
        let mut text = format!("{}{}:", Head(message.at, who), form.full_name());
        for (signal, value) in form.signals.iter().zip(&message.values) {
            if let Some(value) = value {
                let name = signal.names.iter().find(|(named, _)| named == value);
                let value = figures::with_unit(rounded(*value), &signal.unit);
                let _ = write!(text, " {} {value}", signal.name);
                if let Some((_, name)) = name {
                    let _ = write!(text, " ({name})");
                }
                text.push(',');
            }
        }
        text.trim_end_matches([',', ':']).to_owned()
    }

    pub fn lines(&self) -> Vec<String> {
        let steps = self.steps.iter().map(|(_, line)| line.clone());
        let lines = steps.chain(self.lines.values().cloned()).chain(self.faults.values().cloned());
        let messages = self.messages.iter().map(|(name, message)| self.message(name, message));
        lines.chain(messages).chain(self.quantities.values().cloned()).collect()
    }
}

/// Without the rounding noise of a raw value times its factor. A whole number is free of it, and may have more digits.
fn rounded(value: f64) -> String {
    if value.fract() == 0.0 {
        return figures::all_digits(value);
    }
    format!("{value:.12e}").parse().unwrap_or(value).to_string()
}

#[cfg(test)]
mod tests {
    use super::{Moment, rounded};
    use crate::tables::Ears;
    use record::header::Header;
    use record::{Device, FaultEvent, FaultRecord, Record, RecordKind};
    use wire::time::Timestamp;

    #[test]
    fn steps_and_faults_are_there_while_they_are_on() {
        let mut moment = Moment::new(Header::default(), Ears::deaf());
        let mut shows = |at, kind, expected: &[&str]| {
            let at = Timestamp::from_secs_f64(at);
            moment.take(&Record { at, device: Device::Plan, kind });
            let lines = moment.lines();
            let texts =
                lines.iter().map(|line| line.split_once("plan").map_or("", |it| it.1.trim()));
            assert_eq!(texts.collect::<Vec<_>>(), expected);
        };
        let path = |path: &str| path.to_owned();
        let began = |at: &str| RecordKind::StepBegan { path: path(at), title: "t".to_owned() };
        let fault = |event| {
            RecordKind::Fault(Box::new(FaultRecord { index: 0, name: "drop".to_owned(), event }))
        };
        shows(0.0, began("steps[0]"), &["begin steps[0]: t"]);
        shows(
            1.0,
            began("steps[0].repeat[1]"),
            &["begin steps[0]: t", "begin steps[0].repeat[1]: t"],
        );
        let on = ["begin steps[0]: t", "begin steps[0].repeat[1]: t", "fault 0 begins: drop"];
        shows(2.0, fault(FaultEvent::Began), &on);
        shows(3.0, RecordKind::StepEnded { path: path("steps[0].repeat[1]") }, &[on[0], on[2]]);
        shows(4.0, fault(FaultEvent::Ended { acted: 1 }), &[on[0]]);
    }

    #[test]
    fn a_product_is_shown_without_its_last_bits() {
        assert_eq!(rounded(-3.0 * 0.1), "-0.3");
        assert_eq!(rounded(123_456.789_012_3), "123456.7890123");
        assert_eq!(rounded(1_152_921_504_606_846_976.0), "1152921504606846976");
    }
}
