//! Keeps the schedule of faults: when each begins and ends, and how it turned out.

use plan::PhaseEvent;
use plan::faults::{Chances, Fault, FaultKind, Lasts, Schedule, When};
use record::FaultSummary;
use wire::time::{Span, Timestamp};

/// A change that is due now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    Begins(usize),
    Ends(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// By chance it does not happen.
    Spared,
    /// Waits for its phase; `seen` occurrences so far.
    Waiting {
        seen: u32,
    },
    /// Begins at this time.
    Due(Timestamp),
    /// Lasts until this time.
    On(Timestamp),
    Over,
}

#[derive(Debug, Clone)]
struct Entry {
    fault: Fault,
    chances: Chances,
    state: State,
    begun: bool,
    /// How often it has acted, once it is over.
    acted: u64,
    /// Open phases of the same name within its own; `None` while its own is not open.
    within: Option<u32>,
}

/// The schedule of one run.
#[derive(Debug, Clone)]
pub(crate) struct Injector {
    entries: Vec<Entry>,
    due: Timestamp,
}

impl Injector {
    /// Draws which faults happen at all; the run begins at `now`.
    pub fn new(schedule: &Schedule, seed: u64, now: Timestamp) -> Self {
        let entries = schedule.faults.iter().zip(schedule.chances(seed)).map(|(fault, chances)| {
            let happens = chances.of("happens").happens(fault.probability);
            let state = match fault.when {
                _ if !happens => State::Spared,
                When::Always => State::Due(now),
                When::At(at) => State::Due(now + at),
                When::Step { .. } | When::During { .. } => State::Waiting { seen: 0 },
            };
            Entry { fault: fault.clone(), chances, state, begun: false, acted: 0, within: None }
        });
        let mut injector = Self { entries: entries.collect(), due: Timestamp::MAX };
        injector.settle();
        injector
    }

    pub const fn next_due(&self) -> Timestamp {
        self.due
    }

    pub fn fault(&self, index: usize) -> &Fault {
        &self.entries[index].fault
    }

    pub fn chances(&self, index: usize) -> &Chances {
        &self.entries[index].chances
    }

    pub fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        for entry in &mut self.entries {
            entry.phase(now, event);
        }
        self.settle();
    }

    /// Returns the next change due by `now`: ends first, then by place in the schedule.
    pub fn change(&mut self, now: Timestamp) -> Option<Change> {
        if self.due > now {
            return None;
        }
        let ends = |entry: &Entry| matches!(entry.state, State::On(until) if until <= now);
        let begins = |entry: &Entry| matches!(entry.state, State::Due(at) if at <= now);
        let change = if let Some(index) = self.entries.iter().position(ends) {
            self.entries[index].state = State::Over;
            Some(Change::Ends(index))
        } else if let Some(index) = self.entries.iter().position(begins) {
            self.entries[index].begin(now);
            Some(Change::Begins(index))
        } else {
            None
        };
        self.settle();
        change
    }

    pub fn active(&self) -> usize {
        self.on().count()
    }

    pub fn on(&self) -> impl Iterator<Item = usize> {
        let entries = self.entries.iter().enumerate();
        entries.filter(|(_, entry)| matches!(entry.state, State::On(_))).map(|(index, _)| index)
    }

    /// Ends the run; returns the faults that were still active.
    pub(crate) fn still_on(&mut self) -> Vec<usize> {
        let found: Vec<usize> = self.on().collect();
        for index in &found {
            self.entries[*index].state = State::Over;
        }
        self.due = Timestamp::MAX;
        found
    }

    /// Faults that never began, and why.
    pub(crate) fn never_begun(&self) -> impl Iterator<Item = (usize, &'static str)> {
        self.entries.iter().enumerate().filter(|(_, entry)| !entry.begun).map(|(index, entry)| {
            let why = match entry.state {
                State::Spared => "drawn not to",
                State::Waiting { .. } => "what it waited for never came",
                _ => "the run was over before",
            };
            (index, why)
        })
    }

    /// Notes how often a fault has acted.
    pub fn acted(&mut self, index: usize, acted: u64) {
        self.entries[index].acted = acted;
    }

    pub fn summaries(&self) -> Vec<FaultSummary> {
        let summary = |(index, entry): (usize, &Entry)| FaultSummary {
            index,
            name: entry.fault.to_string(),
            begun: entry.begun,
            acted: entry.acted,
        };
        self.entries.iter().enumerate().map(summary).collect()
    }

    fn settle(&mut self) {
        let due = self.entries.iter().map(|entry| match entry.state {
            State::Due(at) | State::On(at) => at,
            _ => Timestamp::MAX,
        });
        self.due = due.min().unwrap_or(Timestamp::MAX);
    }
}

impl Entry {
    fn begin(&mut self, now: Timestamp) {
        self.begun = true;
        let over = match (self.fault.what.info().lasts, self.fault.lasting()) {
            (Lasts::Instant, _) => None,
            (_, Some(lasting)) => Some(now + lasting),
            (_, None) => Some(Timestamp::MAX),
        };
        let phase_over = matches!(self.fault.when, When::During { .. }) && self.within.is_none();
        self.state = match over {
            None => State::Over,
            Some(_) if phase_over => State::On(now),
            Some(until) => State::On(until),
        };
    }

    fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        if *event == PhaseEvent::PlanEnded {
            self.plan_ended(now);
        }
        let Some((name, number)) = self.fault.when.phase() else { return };
        match event {
            PhaseEvent::Began(began) if began == name.as_str() => {
                if let Some(within) = &mut self.within {
                    *within += 1;
                }
                let State::Waiting { seen } = &mut self.state else { return };
                *seen += 1;
                if *seen == number {
                    let after = match self.fault.when {
                        When::Step { after, .. } => after,
                        _ => Span::ZERO,
                    };
                    (self.state, self.within) = (State::Due(now + after), Some(0));
                }
            }
            PhaseEvent::Ended(ended) if ended == name.as_str() => match self.within {
                Some(0) => {
                    self.within = None;
                    if matches!(self.fault.when, When::During { .. })
                        && let State::On(until) = &mut self.state
                    {
                        *until = now;
                    }
                }
                Some(inner) => self.within = Some(inner - 1),
                None => {}
            },
            _ => {}
        }
    }

    /// A machine that stalls goes on: only what runs on it can say that the base stands.
    fn plan_ended(&mut self, now: Timestamp) {
        if !matches!(self.fault.what, FaultKind::SchedulerStall { .. }) {
            return;
        }
        match &mut self.state {
            State::On(until) => *until = now,
            state @ (State::Waiting { .. } | State::Due(_)) => *state = State::Over,
            State::Spared | State::Over => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Change, FaultKind, Injector, PhaseEvent, Schedule, Timestamp};
    use plan::Name;
    use plan::faults::{Fault, Target, When};
    use wire::time::Span;

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(seconds)
    }

    fn injector(when: When, what: FaultKind, duration_s: Option<i64>) -> Injector {
        let duration = duration_s.map(Span::from_secs);
        let fault = Fault { when, duration, ..Fault::new(Target::Gyro, what) };
        Injector::new(&Schedule { faults: vec![fault] }, 1, at(0.0))
    }

    const DROP: FaultKind = FaultKind::Drop { loss_percent: 1.0 };

    fn lap() -> Name {
        Name::new("lap").unwrap()
    }

    fn began() -> PhaseEvent {
        PhaseEvent::Began("lap".to_owned())
    }

    fn ended() -> PhaseEvent {
        PhaseEvent::Ended("lap".to_owned())
    }

    #[test]
    fn by_time_it_begins_and_ends() {
        let mut injector = injector(When::At(Span::from_secs(3)), DROP, Some(2));
        assert_eq!((injector.next_due(), injector.change(at(2.9))), (at(3.0), None));
        assert_eq!(injector.change(at(3.0)), Some(Change::Begins(0)));
        assert_eq!((injector.change(at(3.0)), injector.next_due()), (None, at(5.0)));
        assert_eq!(injector.change(at(5.0)), Some(Change::Ends(0)));
        assert_eq!(injector.next_due(), Timestamp::MAX);
        assert!(injector.summaries()[0].begun && injector.never_begun().next().is_none());
    }

    #[test]
    fn by_phase_it_is_on_during_that_one_and_no_other() {
        let mut injector = injector(When::During { phase: lap(), number: 2 }, DROP, None);
        injector.phase(at(1.0), &began());
        injector.phase(at(2.0), &ended());
        assert_eq!(injector.next_due(), Timestamp::MAX);
        injector.phase(at(3.0), &began());
        assert_eq!(injector.change(at(3.0)), Some(Change::Begins(0)));
        // A nested phase of the same name does not end it.
        injector.phase(at(4.0), &began());
        injector.phase(at(5.0), &ended());
        assert_eq!(injector.change(at(5.0)), None);
        injector.phase(at(6.0), &ended());
        assert_eq!(injector.change(at(6.0)), Some(Change::Ends(0)));
    }

    #[test]
    fn after_a_step_began_it_waits_and_outlives_it() {
        let when = When::Step { phase: lap(), number: 1, after: Span::from_secs(2) };
        let mut injector = injector(when, FaultKind::Stall { for_s: 0.5 }, None);
        injector.phase(at(1.0), &began());
        injector.phase(at(1.5), &ended());
        assert_eq!(injector.next_due(), at(3.0));
        assert_eq!(injector.change(at(3.0)), Some(Change::Begins(0)));
        assert_eq!(injector.next_due(), at(3.5));
        assert_eq!(injector.still_on(), [0]);
    }

    #[test]
    fn a_stall_of_the_machine_ends_with_the_plan_and_no_other_fault_does() {
        const STALL: FaultKind = FaultKind::SchedulerStall { for_s: 60.0 };
        for (what, left) in [(STALL, None), (DROP, Some(Change::Begins(0)))] {
            let mut injector = injector(When::At(Span::from_secs(3)), what, Some(9));
            injector.phase(at(2.0), &PhaseEvent::PlanEnded);
            assert_eq!(injector.change(at(3.0)), left);
        }
        for (what, left) in [(STALL, Some(Change::Ends(0))), (DROP, None)] {
            let mut injector = injector(When::At(Span::from_secs(3)), what, Some(9));
            injector.change(at(3.0));
            injector.phase(at(4.0), &PhaseEvent::PlanEnded);
            assert_eq!(injector.change(at(4.0)), left);
        }
    }

    #[test]
    fn what_never_came_is_said() {
        let waiting = injector(When::During { phase: lap(), number: 2 }, DROP, None);
        assert_eq!(waiting.never_begun().next(), Some((0, "what it waited for never came")));
        let fault = Fault { probability: 1e-9, ..Fault::new(Target::Gyro, DROP) };
        let spared = Injector::new(&Schedule { faults: vec![fault] }, 1, at(0.0));
        assert_eq!(spared.never_begun().next(), Some((0, "drawn not to")));
        assert_eq!(spared.next_due(), Timestamp::MAX);
    }
}
