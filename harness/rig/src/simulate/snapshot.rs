//! Snapshots of a run in virtual time: cases of a campaign that share a seed also share everything up to their first fault.
//!
//! A run that [expects faults](Simulation::before_faults) is carried on [up to](Simulation::run_before) an instant and
//! [copied](Simulation::snapshot). A copy takes the [faults](Simulation::with_faults) of a case and goes on to the end. Its
//! events are those of a run that had these faults from the beginning.

use super::Simulation;
use crate::Rig;
use crate::faults::Faults;
use crate::injector::Injector;
use crate::node::Node;
use crate::{Keep, Sink};
use plan::faults::Schedule;
use record::Violation;
use wire::time::Timestamp;

impl Rig {
    fn copied(&self) -> Option<Self> {
        let nodes = self.nodes.iter().map(Node::copied);
        Some(Self {
            nodes: nodes.collect::<Option<_>>()?,
            lines: self.lines.clone(),
            line_names: self.line_names.clone(),
            ears: self.ears.clone(),
        })
    }
}

impl Simulation {
    /// Carries the run of a plan without faults through its first instant. Faults may be added later: the run keeps the
    /// phases that they could wait for.
    #[must_use]
    pub fn before_faults(mut self, sink: Sink<'_>, keep: Keep<'_>) -> Self {
        self.phases = Some(Vec::new());
        self.director.engine.watch_phases();
        self.begin(sink, keep);
        self
    }

    /// Handles all events before `until`. False once the run has ended.
    pub fn run_before(&mut self, until: Timestamp, sink: Sink<'_>, keep: Keep<'_>) -> bool {
        loop {
            if self.director.engine.ending().is_some() {
                return false;
            }
            let Some(next) = self.next_beside_stream(until, sink, keep) else { continue };
            if next >= until {
                return next < Timestamp::MAX;
            }
            if self.step(next, sink, keep).is_some() {
                return false;
            }
        }
    }

    pub const fn now(&self) -> Timestamp {
        self.now
    }

    /// The violation of `property`, if its monitor has found one.
    pub fn broken(&self, property: &str) -> Option<(&str, &Violation)> {
        self.watch.as_ref()?.broken().find(|(name, _)| *name == property)
    }

    /// When the first fault of `schedule` begins, as far as the phases up to now tell.
    pub fn first_fault(&self, schedule: &Schedule, seed: u64) -> Timestamp {
        let mut injector = Injector::new(schedule, seed, Timestamp::ZERO);
        self.phases.iter().flatten().for_each(|(at, event)| injector.phase(*at, event));
        injector.next_due()
    }

    /// The same run with these faults; all of them begin later than now.
    #[must_use]
    pub fn with_faults(mut self, schedule: &Schedule, seed: u64) -> Self {
        self.faults = Faults::of(schedule, seed, &mut self.rig);
        if let Some(faults) = &mut self.faults {
            self.phases.iter().flatten().for_each(|(at, event)| faults.phase(*at, event));
        }
        self
    }

    /// A copy in the same state, which goes on by itself. `None` where user code, a program, an FMU, a person or a
    /// crossing takes part.
    pub fn snapshot(&self) -> Option<Self> {
        if self.crossing.is_some() {
            return None;
        }
        Some(Self {
            now: self.now,
            rig: self.rig.copied()?,
            director: self.director.copied()?,
            crossing: None,
            watch: self.watch.clone(),
            touched: self.touched,
            emulated: self.emulated,
            others: self.others,
            replayed: self.replayed,
            faults: self.faults.clone(),
            plan_due: self.plan_due,
            events: self.events,
            events_at_once: self.events_at_once,
            gyros_are_late: self.gyros_are_late,
            stream: self.stream,
            phases: self.phases.clone(),
        })
    }
}
