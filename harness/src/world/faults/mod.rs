//! Faults of a world: what the schedule says is done to lines, devices, host and operator. Whoever has the controller
//! hands it in: faults of its machine strike it alone.

mod host;
mod slips;
mod strike;
#[cfg(test)]
mod tests;

pub(super) use host::Host;
pub(super) use slips::Slips;

use super::lines::{BaseLink, Node};
use super::stage::Stage;
use crate::engine::PhaseEvent;
use crate::faults::{
    Change, Fault, FaultEvent, FaultRecord, FaultSummary, Injector, Schedule, Target,
};
use crate::link::ErrorState;
use crate::record::sink::RecordSink;
use crate::record::{Device, Record, RecordKind};
use controller::Controller;
use wire::time::Timestamp;

/// The faults of a world; one without any has none of this.
#[derive(Debug)]
pub(super) struct Faults {
    injector: Injector,
    seed: u64,
    pub(super) host: Host,
    /// How often each has acted, once it is over.
    acted: Vec<u64>,
    /// The last fault of the base's bus that began: changes of error states are put down to it.
    last_of_bus: usize,
}

impl Faults {
    /// The faults of `schedule` in the run with `seed`, which begins at zero; none where there are none.
    pub(super) fn of(schedule: &Schedule, seed: u64) -> Option<Box<Self>> {
        let faults = || Self {
            injector: Injector::new(schedule, seed, Timestamp::ZERO),
            seed,
            host: Host::default(),
            acted: vec![0; schedule.faults.len()],
            last_of_bus: 0,
        };
        (!schedule.is_empty()).then(|| Box::new(faults()))
    }

    pub(super) const fn next_due(&self) -> Timestamp {
        self.injector.next_due()
    }

    pub(super) fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.injector.phase(now, event);
    }

    /// How many faults go on now.
    pub(super) fn active(&self) -> usize {
        self.injector.active()
    }

    /// What is due begins and ends; true where anything did.
    pub(super) fn strike(
        &mut self,
        now: Timestamp,
        stage: &mut Stage,
        mut controller: Option<&mut Controller>,
        sink: &mut impl RecordSink,
    ) -> bool {
        let mut any = false;
        while let Some(change) = self.injector.change(now) {
            any = true;
            match change {
                Change::Begins(index) => {
                    self.tell(now, sink, index, FaultEvent::Began);
                    self.begin(now, index, stage);
                }
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
            let event = FaultEvent::Confinement {
                node: node.to_owned(),
                state: change.state.name().to_owned(),
                tec: change.counters.tec,
                rec: change.counters.rec,
            };
            self.tell(now, sink, self.last_of_bus, event);
        }
        has_left
    }

    /// The run is over: whatever goes on ends, and what never began is told.
    pub(super) fn finish(
        &mut self,
        now: Timestamp,
        stage: &mut Stage,
        mut controller: Option<&mut Controller>,
        sink: &mut impl RecordSink,
    ) -> Vec<FaultSummary> {
        for index in self.injector.still_on() {
            self.over(now, index, stage, controller.as_deref_mut(), sink);
        }
        for (index, why) in self.injector.never_begun() {
            self.tell(now, sink, index, FaultEvent::NeverHappened { why: why.to_owned() });
        }
        self.injector.summaries(&self.acted)
    }

    fn over(
        &mut self,
        now: Timestamp,
        index: usize,
        stage: &mut Stage,
        controller: Option<&mut Controller>,
        sink: &mut impl RecordSink,
    ) {
        let acted = self.end(now, index, stage, controller);
        self.acted[index] = acted;
        self.tell(now, sink, index, FaultEvent::Ended { acted });
    }

    fn tell(&self, at: Timestamp, sink: &mut impl RecordSink, index: usize, event: FaultEvent) {
        let fault = self.injector.fault(index);
        let record = FaultRecord { index: index as u32, name: fault.to_string(), event };
        let kind = RecordKind::Fault(Box::new(record));
        sink.record(Record { at, device: device_of(fault), kind });
    }
}

/// Whose event it is in the record.
const fn device_of(fault: &Fault) -> Device {
    match fault.target {
        Target::Gyro => Device::Gyro,
        Target::Base => Device::Base,
        Target::Table => Device::Table,
        Target::Host => Device::Controller,
        Target::Operator => Device::Plan,
        Target::Device => Device::Device,
    }
}
