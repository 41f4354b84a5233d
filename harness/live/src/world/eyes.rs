//! What the monitor of a live run sees. Of an in-process controller it sees what that received and sent, at those
//! times. Of any other it sees the lines: what left a port of an emulated device counts as received, what came in there
//! as sent.

use super::in_process::Crossing;
use super::ports::{BASE, GYRO};
use controller::mission::Report;
use controller::{Output, Port};
use judge::properties::{Limits, Monitor, Property, PropertyVerdict, Seen, Sight, Unjudged, View};
use plan::Speaker;
use record::Device;
use rig::Sink;
use rig::bench::Bench;
use rig::engine::Action;
use rig::watch::Watch;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Place at which the lines are observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ear {
    Controller,
    /// At the ports of the harness.
    Lines,
}

#[derive(Debug)]
pub(super) struct Eyes {
    watch: Option<Watch>,
    unjudged: Vec<Unjudged>,
    truth: bool,
    ear: Ear,
    /// Keeps time monotonic for the monitor; times of an in-process controller run ahead of the loop's.
    latest: Timestamp,
}

impl Eyes {
    /// A monitor of `properties`, as far as `sight` allows.
    pub(super) fn new(
        properties: &[Property],
        limits: Option<&Limits>,
        speakers: &[Speaker],
        (sight, ear): (&Sight, Ear),
    ) -> Self {
        let (judged, unjudged) = sight.divide(properties);
        let monitor = || Monitor::new(&judged, limits, speakers);
        let watch = (!judged.is_empty()).then(|| Watch::new(monitor()));
        let truth = sight.has(View::Truth);
        Self { watch, unjudged, truth, ear, latest: Timestamp::ZERO }
    }

    /// Whether there is anything to judge.
    pub(super) const fn judge(&self) -> bool {
        self.watch.is_some()
    }

    /// Verdicts of the properties, and the properties that could not be judged.
    pub(super) fn close(self, end: Timestamp) -> (Vec<PropertyVerdict>, Vec<Unjudged>) {
        let end = end.max(self.latest);
        let verdicts = self.watch.map(|watch| watch.into_monitor().verdicts(end));
        (verdicts.unwrap_or_default(), self.unjudged)
    }

    pub(super) fn tell(&self, sink: Sink<'_>) {
        if let Some(watch) = &self.watch {
            watch.tell(sink);
        }
    }

    pub(super) fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        self.latest = self.latest.max(now);
        if let Some(watch) = &mut self.watch {
            watch.see(self.latest, seen);
        }
    }

    /// Shows an action of the engine before it is carried out.
    pub(super) fn see_action(&mut self, now: Timestamp, bench: &Bench, action: &Action) {
        self.look(now, bench);
        let latest = self.latest;
        if let Some(watch) = &mut self.watch {
            watch.see_action(latest, action);
        }
    }

    pub(super) fn report(&mut self, now: Timestamp, bench: &Bench, report: &Report) {
        self.look(now, bench);
        self.see(now, &Seen::Report(report));
    }

    /// Shows the truth of `now`, unless already shown.
    fn look(&mut self, now: Timestamp, bench: &Bench) {
        self.latest = self.latest.max(now);
        if let Some(watch) = self.watch.as_mut().filter(|_| self.truth) {
            watch.look(self.latest, bench);
        }
    }

    pub(super) fn look_again(&mut self, now: Timestamp, bench: &Bench) {
        self.latest = self.latest.max(now);
        if let Some(watch) = self.watch.as_mut().filter(|_| self.truth) {
            watch.look_again(self.latest, bench);
        }
    }

    pub(super) fn line(&mut self, now: Timestamp, role: &str, by: Device, crossed: Transmit) {
        if self.ear == Ear::Lines {
            self.crossed(now, role, by, crossed);
        }
    }

    /// Shows what crossed a port of the in-process controller.
    pub(super) fn within(&mut self, now: Timestamp, bench: &Bench, crossing: &Crossing) {
        if crossing.by == Device::Controller {
            self.look(now, bench);
        }
        self.crossed(now, crossing.role, crossing.by, crossing.crossed);
    }

    fn crossed(&mut self, now: Timestamp, role: &str, by: Device, crossed: Transmit) {
        match (role, by, crossed) {
            (GYRO, Device::Controller, Transmit::Bytes(packet)) => {
                self.see(now, &Seen::Sent(&Output::Bytes(Port::Gyro, packet)));
            }
            (BASE, Device::Controller, Transmit::Bytes(packet)) => {
                self.see(now, &Seen::Sent(&Output::Bytes(Port::Base, packet)));
            }
            (BASE, Device::Controller, Transmit::Frame(frame)) => {
                self.see(now, &Seen::Sent(&Output::Frame(frame)));
            }
            (GYRO, _, Transmit::Bytes(packet)) => {
                self.see(now, &Seen::GyroBytes(packet.as_slice()));
            }
            (BASE, _, Transmit::Bytes(packet)) => {
                self.see(now, &Seen::BaseBytes(packet.as_slice()));
            }
            (BASE, _, Transmit::Frame(frame)) => self.see(now, &Seen::BaseFrame(&frame)),
            _ => {}
        }
    }
}
