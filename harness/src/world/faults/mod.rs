//! Faults of a world: what the schedule says is done to lines, devices, host and operator. Whoever has the controller
//! hands it in: faults of its machine strike it alone.

mod host;
mod injector;
mod ledger;
mod slips;
mod strike;
#[cfg(test)]
mod tests;

pub(super) use host::Host;
pub(super) use injector::{Change, makes_frames};
pub(super) use ledger::Ledger;
pub(super) use slips::Slips;

use super::lines::{BaseLink, Node};
use super::stage::Stage;
use crate::faults::Schedule;
use crate::hosted::HostedController;
use crate::link::ErrorState;
use crate::plan::PhaseEvent;
use crate::record::FaultSummary;
use crate::record::sink::RecordSink;
use wire::time::Timestamp;

/// The faults of a world; one without any has none of this.
#[derive(Debug)]
pub(super) struct Faults {
    ledger: Ledger,
    seed: u64,
    pub(super) host: Host,
    /// The last fault of the base's bus that began: changes of error states are put down to it.
    last_of_bus: usize,
}

impl Faults {
    /// The faults of `schedule` in the run with `seed`, which begins at zero; none where there are none.
    pub(super) fn of(schedule: &Schedule, seed: u64) -> Option<Box<Self>> {
        let ledger = Ledger::of(schedule, seed)?;
        Some(Box::new(Self { ledger, seed, host: Host::default(), last_of_bus: 0 }))
    }

    pub(super) const fn next_due(&self) -> Timestamp {
        self.ledger.next_due()
    }

    pub(super) fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.ledger.phase(now, event);
    }

    /// How many faults go on now.
    pub(super) fn active(&self) -> usize {
        self.ledger.active()
    }

    /// What is due begins and ends; true where anything did.
    pub(super) fn strike(
        &mut self,
        now: Timestamp,
        stage: &mut Stage,
        mut controller: Option<&mut impl HostedController>,
        sink: &mut impl RecordSink,
    ) -> bool {
        let mut any = false;
        while let Some(change) = self.ledger.change(now, sink) {
            any = true;
            match change {
                Change::Begins(index) => self.begin(now, index, stage),
                Change::Ends(index) => {
                    self.over(now, index, stage, controller.as_deref_mut(), sink);
                }
            }
        }
        any
    }

    /// Records what became of the nodes of the bus; says whether one has left it.
    pub(super) fn record_confinement(
        &self,
        now: Timestamp,
        stage: &mut Stage,
        sink: &mut impl RecordSink,
    ) -> bool {
        let mut has_left = false;
        let BaseLink::Can(bus) = &mut stage.lines.base else { return has_left };
        while let Some(change) = bus.state_change() {
            has_left |= change.state == ErrorState::Off;
            let node = match change.node {
                Node::Base => "base",
                Node::Controller => "controller",
                Node::Stranger => "stranger",
            };
            self.ledger.confinement(now, sink, self.last_of_bus, (node, &change));
        }
        has_left
    }

    /// The run is over: whatever goes on ends, and what never began is told.
    pub(super) fn finish(
        &mut self,
        now: Timestamp,
        stage: &mut Stage,
        mut controller: Option<&mut impl HostedController>,
        sink: &mut impl RecordSink,
    ) -> Vec<FaultSummary> {
        for index in self.ledger.still_on() {
            self.over(now, index, stage, controller.as_deref_mut(), sink);
        }
        self.ledger.close(now, sink)
    }

    fn over(
        &mut self,
        now: Timestamp,
        index: usize,
        stage: &mut Stage,
        controller: Option<&mut impl HostedController>,
        sink: &mut impl RecordSink,
    ) {
        let acted = self.end(now, index, stage, controller);
        self.ledger.over(now, sink, index, acted);
    }
}
