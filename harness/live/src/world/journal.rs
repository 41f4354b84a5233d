//! Describes problems at the ports of a run, for the record and for the reason of its end.

use super::role_port::{PortEvent, RolePort};
use record::outcome::{Outcome, PortSide, PortSummary};
use record::sink::RecordSink;
use record::{Device, Record, RecordKind};
use rig::engine::Ending;
use rig::talk::Notes;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

/// A run that ends badly within this time after the absence of a port ends so because of it. Assumption: a controller
/// gives up within a few seconds of silence, and stopping its longest step takes two.
const AFTERMATH: Span = Span::from_secs(10);

/// Records a problem that does not end the run.
pub(super) fn note(sink: &mut dyn RecordSink, at: Timestamp, device: Device, what: String) {
    sink.record(Record { at, device, kind: RecordKind::Note(what) });
}

/// The bench broke: its reason comes first, then that of the run.
pub(super) fn blame_bench(ending: Ending, why: &str) -> Ending {
    let then = ending.reason.map_or_else(String::new, |reason| format!("; {reason}"));
    Ending { outcome: Outcome::Error, reason: Some(format!("{why}{then}")), lost: false }
}

/// Key of a port.
type Whose = (Arc<str>, PortSide);

/// A port that is gone, or was gone.
#[derive(Debug, Clone)]
struct Absence {
    what: String,
    /// When it came back.
    until: Option<Timestamp>,
}

#[derive(Debug, Default)]
pub(super) struct Journal {
    notes: Notes,
    absences: BTreeMap<Whose, Absence>,
    lost: BTreeMap<Whose, u64>,
}

impl Journal {
    /// A note about an event of a port; `None` for bytes and frames, and beyond the limit.
    pub(super) fn take(
        &mut self,
        now: Timestamp,
        (role, side): Whose,
        port: &str,
        event: &PortEvent,
    ) -> Option<String> {
        let whose = match side {
            PortSide::Plan => format!("the plan's port for the {role}, {port},"),
            PortSide::Bench => format!("the {role}'s port {port}"),
            PortSide::Controller => format!("the controller's port for the {role}, {port},"),
        };
        let note = match event {
            PortEvent::Bytes(_) | PortEvent::Frame(_) => return None,
            PortEvent::Break => format!("{whose} heard a break"),
            PortEvent::Bus(event) => format!("{whose} tells of its bus: {event}"),
            PortEvent::Down => format!("{whose} is down"),
            PortEvent::Up => format!("{whose} is up again"),
            PortEvent::Opened => format!("{whose}: the other side has opened the bus"),
            PortEvent::Closed => format!("{whose}: the other side has closed the bus"),
            PortEvent::Lost(lost) => format!("{whose} is lost: {lost}"),
            PortEvent::Back => format!("{whose} is back"),
            PortEvent::Away(error) => format!("{whose} stays away: {error}"),
        };
        match event {
            PortEvent::Lost(_) | PortEvent::Down => {
                *self.lost.entry((Arc::clone(&role), side)).or_default() += 1;
                self.absences.insert((role, side), Absence { what: note.clone(), until: None });
            }
            PortEvent::Back | PortEvent::Up => {
                if let Some(absence) = self.absences.get_mut(&(role, side)) {
                    absence.until = Some(now);
                }
            }
            _ => {}
        }
        self.note(note)
    }

    pub(super) fn note(&mut self, note: String) -> Option<String> {
        self.notes.keeps().then_some(note)
    }

    /// A note about the notes beyond the limit.
    pub(super) fn unnoted(&self) -> Option<String> {
        self.notes.beyond("events of ports")
    }

    /// Adjusts the ending for absent ports: a run that failed for lack of a port did not fail by itself.
    pub(super) fn explain(&self, ending: Ending, now: Timestamp) -> Ending {
        let gone = self.absences.values().find(|absence| absence.until.is_none());
        let was_gone = || {
            let recent = |absence: &&Absence| absence.until.is_some_and(|at| now - at <= AFTERMATH);
            self.absences.values().find(recent)
        };
        let (absence, since) = match ending.outcome {
            Outcome::Passed | Outcome::Error => (gone, ""),
            Outcome::Failed | Outcome::Timeout if gone.is_some() => (gone, ""),
            Outcome::Failed | Outcome::Timeout => (was_gone(), ", and was back too late"),
            Outcome::Aborted => (None, ""),
        };
        let Some(absence) = absence else { return ending };
        blame_bench(ending, &format!("{}{since}", absence.what))
    }

    pub(super) fn summary(&self, (role, side): Whose, port: &RolePort) -> PortSummary {
        let rows = port.counters().rows().into_iter().filter(|(_, count)| *count > 0);
        PortSummary {
            role: role.to_string(),
            side,
            port: port.name().to_owned(),
            lost: self.lost.get(&(Arc::clone(&role), side)).copied().unwrap_or_default(),
            counters: rows.map(|(name, count)| (name.to_owned(), count)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AFTERMATH, Arc, Ending, Journal, Outcome, PortEvent, PortSide, Timestamp};
    use ports::PortLost;
    use rig::talk::NOTES_MAX;
    use wire::time::Span;

    fn base() -> (Arc<str>, PortSide) {
        ("base".into(), PortSide::Bench)
    }

    fn ending(outcome: Outcome) -> Ending {
        Ending { outcome, reason: Some("it took too long".to_owned()), lost: false }
    }

    #[test]
    fn a_port_that_never_returns_is_the_reason() {
        let mut journal = Journal::default();
        let lost = PortEvent::Lost(PortLost::Deleted);
        let note = journal.take(Timestamp::ZERO, base(), "can:vcan0", &lost).unwrap();
        assert_eq!(note, "the base's port can:vcan0 is lost: the interface was deleted");
        for outcome in [Outcome::Passed, Outcome::Failed, Outcome::Timeout, Outcome::Error] {
            let told = journal.explain(ending(outcome), Timestamp::MAX);
            assert_eq!(told.outcome, Outcome::Error);
            assert_eq!(told.reason.unwrap(), format!("{note}; it took too long"));
        }
        assert_eq!(
            journal.explain(ending(Outcome::Aborted), Timestamp::MAX),
            ending(Outcome::Aborted)
        );
    }

    #[test]
    fn a_port_that_came_back_is_to_blame_for_a_while() {
        let mut journal = Journal::default();
        let lost = PortEvent::Lost(PortLost::HungUp);
        assert!(journal.take(Timestamp::ZERO, base(), "x", &lost).is_some());
        assert!(journal.take(Timestamp::ZERO, base(), "x", &PortEvent::Back).is_some());
        let soon = Timestamp::ZERO + AFTERMATH;
        assert_eq!(journal.explain(ending(Outcome::Passed), soon), ending(Outcome::Passed));
        assert_eq!(journal.explain(ending(Outcome::Failed), soon).outcome, Outcome::Error);
        let later = soon + Span::from_nanos(1);
        assert_eq!(journal.explain(ending(Outcome::Failed), later), ending(Outcome::Failed));
    }

    #[test]
    fn a_bus_that_never_ends_to_complain_is_counted() {
        let mut journal = Journal::default();
        for _ in 0..NOTES_MAX + 3 {
            journal.take(Timestamp::ZERO, base(), "x", &PortEvent::Break);
        }
        assert_eq!(journal.unnoted().unwrap(), "3 more events of ports are not noted");
    }
}
