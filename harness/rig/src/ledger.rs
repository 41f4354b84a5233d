//! What becomes of a schedule in a run: told in the record as it happens, and summed up at the end.

use super::injector::{Change, Injector};
use crate::link::StateChange;
use plan::PhaseEvent;
use plan::faults::{Fault, Schedule, no_input_shows};
use record::sink::RecordSink;
use record::{Device, FaultEvent, FaultRecord, FaultSummary, Record, RecordKind};
use wire::time::Timestamp;

/// The schedule of a run, and what each of its faults has done. Who has what is struck asks for [`change`](Self::change)s,
/// makes them, and says when a fault is [`over`](Self::over).
#[derive(Debug, Clone)]
pub(crate) struct Ledger {
    injector: Injector,
    /// How often each has acted, once it is over.
    acted: Vec<u64>,
}

impl Ledger {
    /// Of the run with `seed`, which begins at zero; none where nothing is to go wrong.
    pub fn of(schedule: &Schedule, seed: u64) -> Option<Self> {
        (!schedule.is_empty()).then(|| Self {
            injector: Injector::new(schedule, seed, Timestamp::ZERO),
            acted: vec![0; schedule.faults.len()],
        })
    }

    /// When something begins or ends next.
    pub const fn next_due(&self) -> Timestamp {
        self.injector.next_due()
    }

    /// A phase of the plan began or ended.
    pub fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.injector.phase(now, event);
    }

    /// How many faults go on now.
    pub fn active(&self) -> usize {
        self.injector.active()
    }

    /// A kind that goes on now and that no input of the controller shows.
    pub fn unseen(&self) -> Option<&'static str> {
        self.injector.on().find_map(|index| no_input_shows(self.fault(index).what.name()))
    }

    pub fn fault(&self, index: usize) -> &Fault {
        self.injector.fault(index)
    }

    /// The next thing that is to be done by `now`; what begins is told.
    pub fn change(&mut self, now: Timestamp, sink: &mut impl RecordSink) -> Option<Change> {
        let change = self.injector.change(now);
        if let Some(Change::Begins(index)) = change {
            self.tell(now, sink, index, FaultEvent::Began);
        }
        change
    }

    /// The fault has acted so often, and is over without an end of its own.
    pub fn acted(&mut self, index: usize, acted: u64) {
        self.acted[index] = acted;
    }

    /// The fault is over, and has acted so often.
    pub fn over(&mut self, now: Timestamp, sink: &mut impl RecordSink, index: usize, acted: u64) {
        self.acted[index] = acted;
        self.tell(now, sink, index, FaultEvent::Ended { acted });
    }

    /// Records that a node of a bus is in another error state, which is put down to the fault at `index`.
    pub fn confinement<Node>(
        &self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        index: usize,
        (node, change): (&str, &StateChange<Node>),
    ) {
        let event = FaultEvent::Confinement {
            node: node.to_owned(),
            state: change.state.name().to_owned(),
            tec: change.counters.tec,
            rec: change.counters.rec,
        };
        self.tell(now, sink, index, event);
    }

    /// The run is over: those that still go on.
    pub(crate) fn still_on(&mut self) -> Vec<usize> {
        self.injector.still_on()
    }

    /// All that went on is over: what never began is told, and what became of each.
    pub fn close(&self, now: Timestamp, sink: &mut impl RecordSink) -> Vec<FaultSummary> {
        for (index, why) in self.injector.never_begun() {
            self.tell(now, sink, index, FaultEvent::NeverHappened { why: why.to_owned() });
        }
        self.injector.summaries(&self.acted)
    }

    fn tell(&self, at: Timestamp, sink: &mut impl RecordSink, index: usize, event: FaultEvent) {
        let fault = self.fault(index);
        let record = FaultRecord { index: index as u32, name: fault.to_string(), event };
        let kind = RecordKind::Fault(Box::new(record));
        sink.record(Record { at, device: Device::from(fault.target), kind });
    }
}
