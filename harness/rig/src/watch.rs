//! Shows a monitor of properties what happens on a rig.

use super::bench::{Bench, Carrier};
use crate::Sink;
use crate::engine::Action;
use emulators::base::BaseTruth;
use judge::properties::{Monitor, Seen, TRUTH_PERIOD, Truth};
use plan::Order;
use record::{RecordKind, Violation};
use wire::time::Timestamp;

/// A monitor, and when it last saw the truth.
#[derive(Debug, Clone)]
pub struct Watch {
    monitor: Monitor,
    looked: Option<Timestamp>,
}

impl Watch {
    pub const fn new(monitor: Monitor) -> Self {
        Self { monitor, looked: None }
    }

    pub fn into_monitor(self) -> Monitor {
        self.monitor
    }

    /// The properties that do not hold so far, each with its first violation.
    pub fn broken(&self) -> impl Iterator<Item = (&str, &Violation)> {
        self.monitor.broken()
    }

    pub fn tell(&self, sink: Sink<'_>) {
        for (name, violation) in self.broken() {
            sink.broken(name, violation);
        }
    }

    pub fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        self.monitor.see(now, seen);
    }

    /// Shows an action of the engine before it is carried out.
    pub fn see_action(&mut self, now: Timestamp, action: &Action) {
        match action {
            Action::Mission(mission) => self.see(now, &Seen::Told(mission)),
            Action::Order(Order::Place(_)) => {
                self.see(now, &Seen::Placed);
                self.looked = None;
            }
            Action::Record(_, RecordKind::StepBegan { .. }) => self.see(now, &Seen::StepBegan),
            Action::Record(_, RecordKind::StepEnded { .. }) => self.see(now, &Seen::StepEnded),
            _ => {}
        }
    }

    /// Shows the truth of `now`, unless already shown.
    pub fn look(&mut self, now: Timestamp, bench: &Bench) {
        if self.looked != Some(now) {
            self.looked = Some(now);
            if let Carrier::Base(base) = &bench.carrier {
                let BaseTruth { pose, speed, wheels, steer_rate, followed, .. } =
                    base.truth_at(now);
                let leapt = bench.gyro.leapt();
                let truth = Truth { pose, speed, wheels, leapt, steer_rate, followed };
                self.monitor.see(now, &Seen::Truth(truth));
            }
        }
    }

    /// Shows a message that has come from the base of `bench`, and whether it is what the base said.
    pub fn hear_base(&mut self, now: Timestamp, seen: &Seen<'_>, bench: Option<&Bench>) {
        self.see(now, seen);
        if let (Some(motion), Some(Carrier::Base(base))) =
            (self.monitor.motion_heard(now), bench.map(|bench| &bench.carrier))
            && !base.has_said(&motion)
        {
            self.see(now, &Seen::Misheard);
        }
    }

    pub fn look_again(&mut self, now: Timestamp, bench: &Bench) {
        if self.looked.is_none_or(|looked| now - looked >= TRUTH_PERIOD) {
            self.look(now, bench);
        }
    }
}

pub fn see(watch: &mut Option<Box<Watch>>, now: Timestamp, seen: &Seen<'_>) {
    if let Some(watch) = watch {
        watch.see(now, seen);
    }
}
