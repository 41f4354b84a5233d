//! Faults of the line to a device of the user's own: what the schedule says is done to it.

use super::link::{DeviceLink, node};
use crate::faults::Chance;
use crate::faults::Schedule;
use crate::plan::PhaseEvent;
use crate::record::FaultSummary;
use crate::record::sink::RecordSink;
use crate::world::faults::{Change, Ledger};
use wire::time::Timestamp;

/// The faults of a run; one without any has none of this.
#[derive(Debug)]
pub(in crate::world) struct LinkFaults {
    ledger: Ledger,
    seed: u64,
    /// The last that began: changes of error states are put down to it.
    last: usize,
}

impl LinkFaults {
    /// The faults of `schedule` in the run with `seed`, which begins at zero; none where there are none.
    pub(in crate::world) fn of(schedule: &Schedule, seed: u64) -> Option<Self> {
        Some(Self { ledger: Ledger::of(schedule, seed)?, seed, last: 0 })
    }

    pub(in crate::world) const fn next_due(&self) -> Timestamp {
        self.ledger.next_due()
    }

    pub(in crate::world) fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.ledger.phase(now, event);
    }

    /// What is due begins and ends.
    pub(in crate::world) fn strike(
        &mut self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) {
        while let Some(change) = self.ledger.change(now, sink) {
            match change {
                Change::Begins(index) => {
                    self.last = index;
                    let (fault, seed) = (self.ledger.fault(index), self.seed);
                    let chance = |way: &str| Chance::new(seed, &format!("{index} {way}"));
                    link.begin_fault(now, index, &fault.what, fault.toward, chance);
                }
                Change::Ends(index) => {
                    self.ledger.over(now, sink, index, link.end_fault(now, index));
                }
            }
        }
    }

    /// Records what became of the nodes of the bus.
    pub(in crate::world) fn record_confinement(
        &self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) {
        while let Some(change) = link.state_change() {
            self.ledger.confinement(now, sink, self.last, (node(change.node), &change));
        }
    }

    /// The run is over: whatever goes on ends, and what never began is told.
    pub(in crate::world) fn finish(
        &mut self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) -> Vec<FaultSummary> {
        for index in self.ledger.still_on() {
            self.ledger.over(now, sink, index, link.end_fault(now, index));
        }
        self.ledger.close(now, sink)
    }
}
