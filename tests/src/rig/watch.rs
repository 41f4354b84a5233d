//! A monitor of properties beside a rig.

use super::{Carrier, Direction, Piece, Rig};
use controller::config::Config;
use judge::properties::{Limits, Monitor, PropertyVerdict, Seen, TRUTH_PERIOD, Truth};
use wire::time::Timestamp;

/// A monitor, and when it was last shown the truth.
pub(super) struct Watch {
    monitor: Monitor,
    looked: Option<Timestamp>,
}

impl Watch {
    pub(super) fn new(config: &Config) -> Self {
        Self { monitor: Monitor::new(&[], Some(&Limits::of(config)), &[]), looked: None }
    }

    pub(super) fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        self.monitor.see(now, seen);
    }

    /// What the controller receives.
    pub(super) fn receive(&mut self, now: Timestamp, direction: Direction, piece: &Piece) {
        match (direction, piece) {
            (Direction::GyroToController, Piece::Bytes(bytes)) => {
                self.see(now, &Seen::GyroBytes(bytes));
            }
            (Direction::BaseToController, Piece::Bytes(bytes)) => {
                self.see(now, &Seen::BaseBytes(bytes));
            }
            (Direction::BaseToController, Piece::Frame(frame)) => {
                self.see(now, &Seen::BaseFrame(frame));
            }
            _ => {}
        }
    }

    pub(super) fn look(&mut self, now: Timestamp, carrier: &Carrier) {
        if self.looked == Some(now) {
            return;
        }
        self.looked = Some(now);
        if let Carrier::Base(base) = carrier {
            let truth = base.truth_at(now);
            let (pose, speed) = (truth.pose, truth.speed);
            self.see(now, &Seen::Truth(Truth { pose, speed, steer_rate: truth.steer_rate }));
        }
    }

    pub(super) fn look_again(&mut self, now: Timestamp, carrier: &Carrier) {
        if self.looked.is_none_or(|looked| now - looked >= TRUTH_PERIOD) {
            self.look(now, carrier);
        }
    }
}

impl Rig {
    /// What became of every property since the rig was made. The rig is at its end.
    pub fn verdicts(self) -> Vec<PropertyVerdict> {
        self.watch.monitor.verdicts(self.now)
    }

    /// A lap begins here, as far as properties go; without any, the scenario is one lap.
    pub fn begin_lap(&mut self) {
        self.watch.look(self.now, &self.carrier);
        self.watch.see(self.now, &Seen::LapBegan);
    }
}
