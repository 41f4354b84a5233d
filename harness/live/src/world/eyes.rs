//! What the monitor of a live run is shown. A controller in the process is heard from within: what it received and
//! sent, as it did. Of any other the harness sees the lines: what left a port of an emulated device counts as heard,
//! what came in there as sent.

use super::in_process::Crossing;
use super::ports::{BASE, GYRO};
use controller::mission::Report;
use controller::{Output, Port};
use judge::properties::{Limits, Monitor, Property, PropertyVerdict, Seen, Sight, Unjudged, View};
use plan::Speaker;
use record::Device;
use record::sink::RecordSink;
use rig::bench::Carrier;
use rig::engine::Action;
use rig::watch::Watch;
use wire::device::Transmit;
use wire::time::Timestamp;

/// From where the lines are heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ear {
    /// Within the controller.
    Controller,
    /// At the ports of the harness.
    Lines,
}

/// A monitor, and what it gets to see.
#[derive(Debug)]
pub(super) struct Eyes {
    watch: Option<Watch>,
    unjudged: Vec<Unjudged>,
    truth: bool,
    ear: Ear,
    /// Times never go back for a monitor; those of a controller in the process run ahead of the loop's.
    latest: Timestamp,
}

impl Eyes {
    /// Eyes for `properties`, as far as `sight` goes.
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

    /// What became of the properties, and those that could not be judged.
    pub(super) fn close(self, end: Timestamp) -> (Vec<PropertyVerdict>, Vec<Unjudged>) {
        let end = end.max(self.latest);
        let verdicts = self.watch.map(|watch| watch.into_monitor().verdicts(end));
        (verdicts.unwrap_or_default(), self.unjudged)
    }

    /// Tells `sink` of the properties that do not hold.
    pub(super) fn tell(&self, sink: &mut impl RecordSink) {
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

    /// What the engine asks for; before it is carried out.
    pub(super) fn see_action(&mut self, now: Timestamp, carrier: &Carrier, action: &Action) {
        self.look(now, carrier);
        let latest = self.latest;
        if let Some(watch) = &mut self.watch {
            watch.see_action(latest, action);
        }
    }

    pub(super) fn report(&mut self, now: Timestamp, carrier: &Carrier, report: &Report) {
        self.look(now, carrier);
        self.see(now, &Seen::Report(report));
    }

    /// Shows the truth of `now`, unless it was shown.
    fn look(&mut self, now: Timestamp, carrier: &Carrier) {
        self.latest = self.latest.max(now);
        if let Some(watch) = self.watch.as_mut().filter(|_| self.truth) {
            watch.look(self.latest, carrier);
        }
    }

    /// Shows the truth if it is due.
    pub(super) fn look_again(&mut self, now: Timestamp, carrier: &Carrier) {
        self.latest = self.latest.max(now);
        if let Some(watch) = self.watch.as_mut().filter(|_| self.truth) {
            watch.look_again(self.latest, carrier);
        }
    }

    /// Something crossed a port of the harness.
    pub(super) fn line(&mut self, now: Timestamp, role: &str, by: Device, crossed: Transmit) {
        if self.ear == Ear::Lines {
            self.crossed(now, role, by, crossed);
        }
    }

    /// Something crossed a port of the controller in the process.
    pub(super) fn within(&mut self, now: Timestamp, carrier: &Carrier, crossing: &Crossing) {
        if crossing.by == Device::Controller {
            self.look(now, carrier);
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
