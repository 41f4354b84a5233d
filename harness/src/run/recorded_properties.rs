//! Judges properties again if the record holds their data. For the others the verdict of the run stays.

use crate::outcome::PropertySummary;
use crate::plan::{Property, Rig, Speaker};
use crate::properties::{Limits, Monitor, Seen, Sight, Unjudged, View};
use crate::record::{Device, Ear, FaultEvent, FaultRecord, Record, RecordKind};
use controller::mission::{Mission, MissionId};
use controller::{Output, Port};
use rig::engine::FIRST_MISSION;
use std::collections::BTreeSet;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Shows a monitor the contents of a record.
#[derive(Debug)]
pub(super) struct Replayed {
    monitor: Monitor,
    mission: MissionId,
    /// Active faults.
    faults: BTreeSet<u32>,
    /// Whether there were bytes or frames of the gyro and of the base.
    gyro: bool,
    base: bool,
    /// The speakers of the rig, by their indices.
    ears: Vec<(usize, Ear)>,
    /// Whether there were bytes or frames of one of them.
    messages: bool,
    /// Keeps time monotonic for the monitor, whatever the record holds.
    latest: Timestamp,
}

impl Replayed {
    /// Creates a monitor of `properties`, of which there is at least one; `limits` are those of the rig's robot, if it
    /// has one.
    pub(super) fn new(properties: &[Property], limits: Option<&Limits>, rig: &Rig) -> Self {
        let ear = |(speaker, one): (usize, &Speaker)| Some((speaker, Ear::of(rig, one)?));
        Self {
            monitor: Monitor::new(properties, limits, &rig.speakers),
            ears: rig.speakers.iter().enumerate().filter_map(ear).collect(),
            messages: false,
            mission: FIRST_MISSION,
            faults: BTreeSet::new(),
            gyro: false,
            base: false,
            latest: Timestamp::ZERO,
        }
    }

    /// The run went on at least until then.
    pub(super) fn goes_on_until(&mut self, end: Timestamp) {
        self.latest = self.latest.max(end);
    }

    /// Takes the next record.
    pub(super) fn take(&mut self, record: &Record) {
        self.goes_on_until(record.at);
        self.read(record);
        match (&record.kind, record.device) {
            (RecordKind::StepBegan { .. }, _) => self.see(&Seen::StepBegan),
            (RecordKind::StepEnded { .. }, _) => self.see(&Seen::StepEnded),
            (RecordKind::Command(command), _) => {
                let mission = Mission { id: self.mission, command: (**command).clone() };
                self.mission = self.mission.wrapping_add(1);
                self.see(&Seen::Told(&mission));
            }
            (RecordKind::Report(report), _) => self.see(&Seen::Report(report)),
            (RecordKind::Bytes(bytes), Device::Gyro) => {
                self.gyro = true;
                self.see(&Seen::GyroBytes(bytes));
            }
            (RecordKind::Bytes(bytes), Device::Base) => {
                self.base = true;
                self.see(&Seen::BaseBytes(bytes));
            }
            (RecordKind::Bytes(bytes), Device::Controller) => {
                // This includes bytes for the gyro, which mean nothing to a base.
                if let Some(packet) = Packet::from_slice(bytes) {
                    self.see(&Seen::Sent(&Output::Bytes(Port::Base, packet)));
                }
            }
            (RecordKind::Frame(frame), Device::Controller) => {
                self.see(&Seen::Sent(&Output::Frame(*frame)));
            }
            (RecordKind::Frame(frame), _) => {
                self.base = true;
                self.see(&Seen::BaseFrame(frame));
            }
            (RecordKind::Fault(fault), _) => self.fault(fault),
            _ => {}
        }
    }

    /// Decodes bytes and frames of the rig's nodes as messages.
    fn read(&mut self, record: &Record) {
        let Self { ears, monitor, messages, latest: at, .. } = self;
        let is_forged = Ear::is_forged(ears.iter().map(|(_, ear)| ear), record);
        for (speaker, ear) in ears {
            *messages |= ear.who() == record.device
                && matches!(record.kind, RecordKind::Bytes(_) | RecordKind::Frame(_));
            ear.hear(record, is_forged, &mut |decoded| {
                monitor.see(*at, &Seen::Message { speaker: *speaker, decoded });
            });
        }
    }

    fn fault(&mut self, fault: &FaultRecord) {
        match &fault.event {
            FaultEvent::Began => _ = self.faults.insert(fault.index),
            FaultEvent::Ended { .. } => _ = self.faults.remove(&fault.index),
            FaultEvent::NeverHappened { .. } => return,
            FaultEvent::Confinement { state, .. } => {
                if state == rig::link::ErrorState::Off.name() {
                    self.see(&Seen::BusOff);
                }
                return;
            }
        }
        self.see(&Seen::Faults(self.faults.len()));
    }

    fn see(&mut self, seen: &Seen<'_>) {
        self.monitor.see(self.latest, seen);
    }

    /// What the record shows, judging by its contents; `real` if a real clock made it.
    fn sight(&self, limits: Option<&Limits>, real: bool) -> Sight {
        let mut sight = Sight::whole()
            .without(View::Truth, "the record has it less often than the run saw it, and no speeds")
            .without(
                View::BaseRequests,
                "the record says when it had arrived, not when it was sent",
            );
        let missing = "the record does not hold its bytes (--record full does)";
        if !self.gyro {
            sight = sight.without(View::GyroLine, missing).without(
                View::PlainReports,
                "the record holds states now and then (--record full all)",
            );
        }
        if !self.messages {
            sight = sight.without(View::Messages, missing);
        }
        if !self.base && limits.is_some_and(|limits| limits.base.is_some()) {
            sight = sight.without(View::BaseReplies, missing);
        }
        if real {
            sight = sight.without(View::BusStates, "what an interface told of them is a note");
        }
        sight
    }

    /// Verdicts of `properties`: judged again, or as they were `before` if the record does not hold their data. Those
    /// are listed with the reason.
    pub(super) fn judge(
        self,
        properties: &[Property],
        limits: Option<&Limits>,
        real: bool,
        before: &[PropertySummary],
    ) -> (Vec<PropertySummary>, Vec<Unjudged>) {
        let (_, unjudged) = self.sight(limits, real).divide(properties);
        let verdicts = self.monitor.verdicts(self.latest);
        let all = verdicts.iter().map(|verdict| {
            let Some(missing) = unjudged.iter().find(|one| one.name == verdict.name) else {
                return verdict.into();
            };
            let known = before.iter().find(|one| one.name == verdict.name);
            known.cloned().unwrap_or_else(|| missing.into())
        });
        (all.collect(), unjudged)
    }
}
