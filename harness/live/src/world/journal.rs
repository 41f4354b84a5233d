//! Describes problems at the ports of a run, for the record and for the reason of its end.

use super::role_port::{Link, PortEvent, RolePort};
use record::outcome::{Outcome, PortSide, PortSummary};
use record::{BUS_CLOSED, BUS_OPENED, Device, Record, RecordKind};
use rig::Sink;
use rig::engine::Ending;
use rig::talk::Notes;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

/// A run that ends badly within this time after the absence of a port ends so because of it. Assumption: a controller
/// gives up within a few seconds of silence, and stopping its longest step takes two.
const AFTERMATH: Span = Span::from_secs(10);

/// Records a problem that does not end the run.
pub(super) fn note(sink: Sink<'_>, at: Timestamp, device: Device, what: String) {
    sink.record(Record { at, device, kind: RecordKind::Note(what) });
}

/// The bench broke: its reason comes first, then that of the run.
pub(super) fn blame_bench(ending: Ending, why: &str) -> Ending {
    let then = ending.reason.map_or_else(String::new, |reason| format!("; {reason}"));
    Ending { outcome: Outcome::Error, reason: Some(format!("{why}{then}")), lost: false }
}

/// Most absences of a port that are told apart; a loose contact has more, and the last one stands for the rest.
const ABSENCES_MAX: usize = 20;

/// Key of a port.
type Whose = (Arc<str>, PortSide);

/// A port that is gone, or was gone.
#[derive(Debug, Clone)]
pub(super) struct Absence {
    pub(super) what: String,
    /// Since when, and what had not been sent by then.
    pub(super) from: (Timestamp, u64),
    /// When it came back, and what had not been sent by then.
    pub(super) until: Option<(Timestamp, u64)>,
    /// The plan had the bench or a person do something that may have switched the device off.
    pub(super) is_expected: bool,
}

impl Absence {
    /// What was to be sent meanwhile.
    pub(super) fn unsent(&self) -> u64 {
        self.until.map_or(0, |(_, unsent)| unsent.saturating_sub(self.from.1))
    }

    pub(super) fn told(&self, whose: &str, link: Link) -> String {
        let until = self.until.map_or_else(
            || "to the end".to_owned(),
            |(until, _)| format!("to {:.3} s", until.as_secs_f64()),
        );
        let lost = match self.unsent() {
            0 => String::new(),
            unsent => {
                format!("; lost meanwhile, though the record has them: {}", link.counted(unsent))
            }
        };
        format!("{whose} was away from {:.3} s {until}{lost}", self.from.0.as_secs_f64())
    }
}

/// What the bench or a person does at the plan's word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Work {
    #[default]
    None,
    UnderWay,
    /// Done at that time.
    Done(Timestamp),
}

impl Work {
    /// Whether a device that goes away now may have been switched off by it.
    fn explains(self, now: Timestamp) -> bool {
        match self {
            Self::None => false,
            Self::UnderWay => true,
            Self::Done(at) => now - at <= AFTERMATH,
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Journal {
    notes: Notes,
    absences: BTreeMap<Whose, Vec<Absence>>,
    lost: BTreeMap<Whose, u64>,
    pub(super) work: Work,
}

/// A port, for a sentence.
pub(super) fn whose(role: &str, side: PortSide, port: &str) -> String {
    match side {
        PortSide::Plan => format!("the plan's port for the {role}, {port},"),
        PortSide::Bench => format!("the {role}'s port {port}"),
        PortSide::Controller => format!("the controller's port for the {role}, {port},"),
    }
}

impl Journal {
    /// A note about an event of a port, at which so much could not be sent so far; `None` for bytes and frames, and
    /// beyond the limit.
    pub(super) fn take(
        &mut self,
        now: Timestamp,
        (role, side): Whose,
        (port, unsent): (&str, u64),
        event: &PortEvent,
    ) -> Option<String> {
        let whose = whose(&role, side, port);
        let note = match event {
            PortEvent::Bytes(_) | PortEvent::Frame(_) => return None,
            PortEvent::Break => format!("{whose} heard a break"),
            PortEvent::Bus(event) => format!("{whose} tells of its bus: {event}"),
            PortEvent::Down => format!("{whose} is down"),
            PortEvent::Up => format!("{whose} is up again"),
            PortEvent::Opened => format!("{whose}: {BUS_OPENED}"),
            PortEvent::Closed => format!("{whose}: {BUS_CLOSED}"),
            PortEvent::Lost(lost) => format!("{whose} is lost: {lost}"),
            PortEvent::Back => format!("{whose} is back"),
            PortEvent::Away(error) => format!("{whose} stays away: {error}"),
        };
        match event {
            PortEvent::Lost(_) | PortEvent::Down => {
                *self.lost.entry((Arc::clone(&role), side)).or_default() += 1;
                let absences = self.absences.entry((role, side)).or_default();
                let (from, is_expected) = ((now, unsent), self.work.explains(now));
                let is_full = absences.len() == ABSENCES_MAX;
                match absences.last_mut().filter(|last| is_full || last.until.is_none()) {
                    Some(last) => (last.what, last.until) = (note.clone(), None),
                    None => {
                        let what = note.clone();
                        absences.push(Absence { what, from, until: None, is_expected });
                    }
                }
            }
            PortEvent::Back | PortEvent::Up => {
                let absences = self.absences.get_mut(&(role, side));
                if let Some(absence) = absences.and_then(|absences| absences.last_mut()) {
                    absence.until.get_or_insert((now, unsent));
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
        let last = || self.absences.values().filter_map(|absences| absences.last());
        let gone = last().find(|absence| absence.until.is_none());
        let was_gone = || {
            let is_recent = |(at, _): (Timestamp, u64)| now - at <= AFTERMATH;
            last().find(|absence| absence.until.is_some_and(is_recent))
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

    pub(super) fn absences(&self, whose: &Whose) -> &[Absence] {
        self.absences.get(whose).map_or(&[], Vec::as_slice)
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
    use super::{
        ABSENCES_MAX, AFTERMATH, Arc, Ending, Journal, Outcome, PortEvent, PortSide, Timestamp,
        Work,
    };
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
        let note = journal.take(Timestamp::ZERO, base(), ("can:vcan0", 0), &lost).unwrap();
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
        assert!(journal.take(Timestamp::ZERO, base(), ("x", 0), &lost).is_some());
        assert!(journal.take(Timestamp::ZERO, base(), ("x", 0), &PortEvent::Back).is_some());
        let soon = Timestamp::ZERO + AFTERMATH;
        assert_eq!(journal.explain(ending(Outcome::Passed), soon), ending(Outcome::Passed));
        assert_eq!(journal.explain(ending(Outcome::Failed), soon).outcome, Outcome::Error);
        let later = soon + Span::from_nanos(1);
        assert_eq!(journal.explain(ending(Outcome::Failed), later), ending(Outcome::Failed));
    }

    #[test]
    fn each_absence_is_kept_and_a_loose_contact_ends() {
        let (lost, mut journal) = (PortEvent::Lost(PortLost::HungUp), Journal::default());
        let at = |ms: i64| Timestamp::ZERO + Span::from_millis(ms);
        for (ms, unsent, event) in [(10, 3, &lost), (20, 7, &PortEvent::Back)] {
            journal.take(at(ms), base(), ("x", unsent), event);
        }
        journal.work = Work::Done(at(30));
        journal.take(at(40), base(), ("x", 7), &lost);
        let [unexpected, expected] = journal.absences(&base()) else { panic!("{journal:?}") };
        assert_eq!((unexpected.unsent(), unexpected.is_expected), (4, false));
        assert_eq!((expected.unsent(), expected.is_expected), (0, true));
        assert!(!journal.work.explains(at(31) + AFTERMATH), "that was long ago");
        for _ in 0..=ABSENCES_MAX {
            journal.take(at(50), base(), ("x", 7), &PortEvent::Back);
            journal.take(at(60), base(), ("x", 7), &lost);
        }
        let absences = journal.absences(&base());
        assert_eq!((absences.len(), absences.last().unwrap().until), (ABSENCES_MAX, None));
    }

    #[test]
    fn a_bus_that_never_ends_to_complain_is_counted() {
        let mut journal = Journal::default();
        for _ in 0..NOTES_MAX + 3 {
            journal.take(Timestamp::ZERO, base(), ("x", 0), &PortEvent::Break);
        }
        assert_eq!(journal.unnoted().unwrap(), "3 more events of ports are not noted");
    }
}
