//! What both worlds share of a plan of a device of the user's own: the engine, its end of the line, the emulated device.

use super::emulated::Emulated;
use super::faults::LinkFaults;
use super::tester::Tester;
use crate::engine::{Action, Engine};
use crate::operator::{Asked, Operator, by_hand};
use crate::plan::Plan;
use crate::record::FaultSummary;
use crate::record::sink::RecordSink;
use crate::record::{Device, Record, RecordKind};
use described::Description;
use std::sync::Arc;
use wire::time::Timestamp;

/// Everything but what carries time and what crosses ports.
#[derive(Debug)]
pub(in crate::world) struct DeviceStage {
    pub(in crate::world) engine: Engine,
    pub(in crate::world) tester: Tester,
    /// None where the device is real.
    pub(in crate::world) emulated: Option<Emulated>,
    faults: Option<LinkFaults>,
    operator: Operator,
}

impl DeviceStage {
    /// Of `plan` from time zero on, its faults drawn from `seed`; `operator` answers what it asks a person.
    pub(in crate::world) fn new(
        plan: Arc<Plan>,
        description: &Arc<Description>,
        emulated: Option<Emulated>,
        operator: Operator,
        seed: u64,
    ) -> Self {
        Self {
            faults: LinkFaults::of(&plan.faults, seed),
            engine: Engine::of_device(plan, description.layout(), Timestamp::ZERO),
            tester: Tester::new(Arc::clone(description)),
            emulated,
            operator,
        }
    }

    /// Faults that are due begin and end.
    pub(in crate::world) fn strike(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        if let (Some(faults), Some(emulated)) = (&mut self.faults, &mut self.emulated) {
            faults.strike(now, &mut emulated.link, sink);
        }
    }

    /// Records what became of the nodes of a bus.
    pub(in crate::world) fn note_confinement(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
    ) {
        if let (Some(faults), Some(emulated)) = (&self.faults, &mut self.emulated) {
            faults.record_confinement(now, &mut emulated.link, sink);
        }
    }

    /// Wakes whoever is due, and does what the engine asks.
    pub(in crate::world) fn wake(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        if let Some(emulated) = &mut self.emulated {
            if emulated.is_back(now) {
                self.engine.answered(now);
            }
            emulated.wake(now);
        }
        if let Err(why) = self.tester.wake(now) {
            self.engine.broke(now, &why);
        }
        if self.engine.next_wakeup() <= now {
            self.engine.wake(now);
        }
        self.act(now, sink);
    }

    /// Does all that the engine asks.
    pub(in crate::world) fn act(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        while let Some(action) = self.engine.action() {
            self.act_on(now, sink, action);
        }
    }

    fn act_on(&mut self, now: Timestamp, sink: &mut impl RecordSink, action: Action) {
        match (action, &mut self.emulated) {
            (Action::Send(send), _) => {
                if let Err(why) = self.tester.send(now, &send) {
                    self.engine.broke(now, &why);
                }
            }
            (Action::StopSending(message), _) => self.tester.stop(&message),
            (Action::SetParameter { parameter, value, .. }, Some(emulated)) => {
                if emulated.device.set_parameter(now, &parameter, value) {
                    self.engine.answered(now);
                } else {
                    self.engine.broke(now, &format!("the device takes no {parameter} = {value}"));
                }
            }
            (Action::SetParameter { device, parameter, value }, None) => {
                let asked =
                    self.operator.ask(&by_hand::set_parameter(&device, &parameter, value), None);
                self.answered(now, asked, sink);
            }
            (Action::PowerCycle { off, .. }, Some(emulated)) => emulated.cycle(now, now + off),
            (Action::PowerCycle { device, off }, None) => {
                let asked = self.operator.ask(&by_hand::power_cycle(&device, off), None);
                self.answered(now, asked, sink);
            }
            (Action::Prompt { text, answer }, _) => {
                let asked = self.operator.ask(&text, answer.as_ref());
                self.answered(now, asked, sink);
            }
            (Action::Phase(event), _) => {
                if let Some(faults) = &mut self.faults {
                    faults.phase(now, &event);
                }
            }
            (Action::Record(device, kind), _) => sink.record(Record { at: now, device, kind }),
            (other, _) => {
                self.engine.broke(now, &format!("no device of one's own does this: {other:?}"))
            }
        }
    }

    /// When something is to be done next, if nothing comes before.
    pub(in crate::world) fn next_due(&self) -> Timestamp {
        let faults = self.faults.as_ref().map_or(Timestamp::MAX, LinkFaults::next_due);
        let emulated = self.emulated.as_ref().map_or(Timestamp::MAX, Emulated::next_due);
        emulated.min(faults).min(self.tester.next_wakeup()).min(self.engine.next_wakeup())
    }

    /// Takes what the person beside the bench has said by now.
    #[cfg(feature = "live")]
    pub(in crate::world) fn listen_to_operator(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
    ) {
        if let Some(asked) = self.operator.heard() {
            self.answered(now, asked, sink);
        }
    }

    /// Hands on what came of a question to a person.
    fn answered(&mut self, now: Timestamp, asked: Asked, sink: &mut impl RecordSink) {
        match asked {
            Asked::Waiting => {}
            Asked::Assumed => self.engine.answered(now),
            Asked::Nobody(why) => self.engine.broke(now, &why),
            Asked::Replied(reply) => {
                let value = reply.number.as_ref().map(|number| number.value);
                let kind = RecordKind::Reply(Box::new(reply));
                sink.record(Record { at: now, device: Device::Plan, kind });
                match value {
                    Some(value) => self.engine.answered_with(now, value),
                    None => self.engine.answered(now),
                }
            }
        }
    }

    /// The run is over: says what could not be read, and what became of the faults.
    pub(in crate::world) fn finish(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
    ) -> Vec<FaultSummary> {
        if self.tester.damaged() > 0 {
            let note = format!("{} times what came could not be read", self.tester.damaged());
            sink.record(Record { at: now, device: Device::Plan, kind: RecordKind::Note(note) });
        }
        match (&mut self.faults, &mut self.emulated) {
            (Some(faults), Some(emulated)) => faults.finish(now, &mut emulated.link, sink),
            _ => Vec::new(),
        }
    }

    /// What the emulated device and its line had no room for.
    pub(in crate::world) fn dropped(&self) -> u64 {
        self.emulated.as_ref().map_or(0, Emulated::dropped)
    }
}
