//! The machine that a controller or a program runs on: it may stand still, and its clock may jump.

use crate::faults::FaultKind;
use controller::mission::Mission;
use std::collections::VecDeque;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// What waits for a machine that stands still; more is dropped and counted, as in full buffers of a kernel.
pub(crate) const HELD_MAX: usize = 4_096;

/// What runs on a machine. Times are those of the machine's clock.
pub(crate) trait Guest {
    /// It is to hear bytes or a frame.
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit);

    /// It is given a mission.
    fn order(&mut self, now: Timestamp, mission: Mission);
}

#[derive(Debug)]
enum Held {
    Crossed(PortId, Transmit),
    // Boxed: a calibration is far larger than a packet.
    Mission(Box<Mission>),
}

/// A machine with faults.
#[derive(Debug, Default)]
pub(crate) struct Host {
    /// How many stalls are on.
    stalls: usize,
    held: VecDeque<Held>,
    taken: u64,
    dropped: u64,
    /// How far its clock is ahead.
    ahead: Span,
}

impl Host {
    /// It does not run now.
    pub(crate) const fn is_stalled(&self) -> bool {
        self.stalls > 0
    }

    /// What its clock says.
    pub(crate) fn told(&self, now: Timestamp) -> Timestamp {
        now + self.ahead
    }

    /// When its clock says `told`.
    pub(crate) fn when(&self, told: Timestamp) -> Timestamp {
        if told == Timestamp::MAX { told } else { told - self.ahead }
    }

    /// A fault of a machine begins; others are none of its business.
    pub(crate) fn begin(&mut self, kind: &FaultKind) {
        match kind {
            FaultKind::SchedulerStall { .. } => self.stalls += 1,
            FaultKind::ClockStep { step_s } => self.ahead += Span::from_secs_f64(*step_s),
            _ => {}
        }
    }

    /// It ends; how often it has acted. A machine that goes on hears all at once what was held.
    pub(crate) fn end(&mut self, now: Timestamp, kind: &FaultKind, guest: &mut impl Guest) -> u64 {
        match kind {
            FaultKind::SchedulerStall { .. } => {
                self.go_on(now, guest);
                self.taken
            }
            FaultKind::ClockStep { step_s } => {
                self.ahead += -Span::from_secs_f64(*step_s);
                1
            }
            _ => 0,
        }
    }

    fn go_on(&mut self, now: Timestamp, guest: &mut impl Guest) {
        self.stalls = self.stalls.saturating_sub(1);
        if self.stalls > 0 {
            return;
        }
        let now = self.told(now);
        // What waited did so at each port, and a machine that goes on reads one after the other: serial ports in the order in
        // which something came, then buses, missions last. A program in step with the world does the same.
        let first = self.held.iter().find_map(|held| match held {
            Held::Crossed(port, Transmit::Bytes(_)) => Some(*port),
            _ => None,
        });
        let place = |held: &Held| match held {
            Held::Crossed(port, Transmit::Bytes(_)) if Some(*port) == first => 0,
            Held::Crossed(_, Transmit::Bytes(_)) => 1,
            Held::Crossed(_, Transmit::Frame(_)) => 2,
            Held::Mission(_) => 3,
        };
        self.held.make_contiguous().sort_by_key(place);
        for held in self.held.drain(..) {
            match held {
                Held::Crossed(port, what) => guest.hear(now, port, &what),
                Held::Mission(mission) => guest.order(now, *mission),
            }
        }
    }

    /// What found no room.
    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The guest is to hear bytes or a frame.
    pub(crate) fn hear(
        &mut self,
        now: Timestamp,
        port: PortId,
        what: Transmit,
        guest: &mut impl Guest,
    ) {
        if self.is_stalled() {
            self.hold(Held::Crossed(port, what));
        } else {
            guest.hear(self.told(now), port, &what);
        }
    }

    /// The guest is given a mission.
    pub(crate) fn mission(&mut self, now: Timestamp, mission: Mission, guest: &mut impl Guest) {
        if self.is_stalled() {
            self.hold(Held::Mission(Box::new(mission)));
        } else {
            guest.order(self.told(now), mission);
        }
    }

    fn hold(&mut self, held: Held) {
        if self.held.len() < HELD_MAX {
            self.held.push_back(held);
            self.taken += 1;
        } else {
            self.dropped += 1;
        }
    }
}
