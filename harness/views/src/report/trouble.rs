//! Notes, refusals, aborted missions and degraded health: where to look first when a run failed.

use super::listed;
use controller::health::Level;
use controller::mission::Report;
use maud::{Markup, html};
use record::text::{cause_names, name_of};
use record::{Device, Record, RecordKind};

const TROUBLES_MAX: usize = 200;

/// Maximum length of a text, in characters.
const TEXT_MAX: usize = 500;

#[derive(Debug)]
struct Trouble {
    at_s: f64,
    device: Device,
    text: String,
}

/// The first entries, and the number of further ones.
#[derive(Debug, Default)]
pub(super) struct Troubles {
    listed: Vec<Trouble>,
    overflowed: u64,
}

impl Troubles {
    pub(super) fn add(&mut self, record: &Record) {
        let Some(text) = text(&record.kind) else {
            return;
        };
        if self.listed.len() >= TROUBLES_MAX {
            self.overflowed += 1;
            return;
        }
        let text = text.chars().take(TEXT_MAX).collect();
        self.listed.push(Trouble { at_s: record.at.as_secs_f64(), device: record.device, text });
    }

    pub(super) fn instants(&self) -> impl Iterator<Item = f64> + '_ {
        self.listed.iter().map(|trouble| trouble.at_s)
    }
}

fn text(kind: &RecordKind) -> Option<String> {
    match kind {
        RecordKind::Note(text) => Some(text.clone()),
        RecordKind::Fault(fault) => Some(fault.to_string()),
        RecordKind::Report(Report::Refused { id, reason }) => {
            Some(format!("refused mission {id}: {}", name_of(reason)))
        }
        RecordKind::Report(Report::Aborted { id, reason }) => {
            Some(format!("aborted mission {id}: {}", name_of(reason)))
        }
        RecordKind::Report(Report::Health(health)) if health.level >= Level::Degraded => {
            let causes = cause_names(&health.causes).join(", ");
            Some(format!("health {}: {causes}", name_of(&health.level)))
        }
        _ => None,
    }
}

/// Renders the list; `None` if it is empty.
pub(super) fn list(troubles: &Troubles) -> Option<Markup> {
    if troubles.listed.is_empty() {
        return None;
    }
    let rows = html! {
        @for trouble in &troubles.listed {
            tr {
                td.number { (format!("{:.3}", trouble.at_s)) " s" }
                td { (trouble.device.name()) }
                td { (trouble.text) }
            }
        }
    };
    Some(html! {
        (listed::table(Some("troubles"), &["bench time", "device", "what"], &rows))
        @if troubles.overflowed > 0 {
            p.missing { "and " (troubles.overflowed) " more, which the record holds." }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{TROUBLES_MAX, Troubles, list};
    use record::samples::one_of_each;

    #[test]
    fn refusals_aborts_faults_and_notes_are_listed() {
        let mut troubles = Troubles::default();
        assert!(list(&troubles).is_none());
        one_of_each().iter().for_each(|record| troubles.add(record));
        let texts: Vec<_> = troubles.listed.iter().map(|trouble| trouble.text.as_str()).collect();
        let expected = [
            "refused mission 2: moving",
            "aborted mission 3: gyro_silent",
            "health fault: gyro_silent",
            "1 frame lost",
            "fault 2: base is bus-off, TEC 256, REC 3",
        ];
        assert_eq!(texts, expected);
    }

    #[test]
    fn the_list_is_bounded_and_says_so() {
        let mut troubles = Troubles::default();
        let note = &one_of_each()[13];
        (0..TROUBLES_MAX + 7).for_each(|_| troubles.add(note));
        assert!(list(&troubles).unwrap().into_string().contains("and 7 more"));
    }
}
