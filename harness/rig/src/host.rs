//! The machine that a controller or a program runs on: it may stand still, and its clock may jump.

use controller::mission::Mission;
use plan::faults::FaultKind;
use std::collections::VecDeque;
use std::fmt;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// What waits for a machine that stands still; more is dropped and counted, as in full buffers of a kernel.
pub(crate) const HELD_MAX: usize = 4_096;

/// What runs on a machine. Times are those of the machine's clock.
pub trait Guest {
    /// It is to hear bytes or a frame.
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit);

    /// It is given a mission.
    fn order(&mut self, now: Timestamp, mission: Mission);
}

#[derive(Debug, Clone)]
enum Held {
    Crossed(PortId, Transmit),
    // Boxed: a calibration is far larger than a packet.
    Mission(Box<Mission>),
}

/// A machine with faults.
#[derive(Debug, Clone, Default)]
struct Host {
    /// How many stalls are on.
    stalls: usize,
    held: VecDeque<Held>,
    taken: u64,
    dropped: u64,
    /// How far its clock is ahead.
    ahead: Span,
}

/// A guest, and the machine that it runs on. Times are those of the bench.
pub struct OnHost<G> {
    pub guest: G,
    /// Only where faults can strike it.
    host: Option<Host>,
}

impl<G: Guest> OnHost<G> {
    pub const fn new(guest: G) -> Self {
        Self { guest, host: None }
    }

    /// Faults can strike it from now on.
    pub fn with_faults(&mut self) {
        self.host = Some(Host::default());
    }

    /// Its machine begins to err.
    pub fn begin_fault(&mut self, kind: &FaultKind) {
        if let Some(host) = &mut self.host {
            host.begin(kind);
        }
    }

    /// Its machine errs no longer; how often it did.
    pub fn end_fault(&mut self, now: Timestamp, kind: &FaultKind) -> u64 {
        let Self { guest, host: Some(host) } = self else { return 0 };
        host.end(now, kind, guest)
    }

    #[inline]
    pub fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        match &mut self.host {
            None => self.guest.hear(now, port, what),
            Some(host) => host.hear(now, port, *what, &mut self.guest),
        }
    }

    pub fn command(&mut self, now: Timestamp, mission: Mission) {
        match &mut self.host {
            None => self.guest.order(now, mission),
            Some(host) => host.mission(now, mission, &mut self.guest),
        }
    }

    /// It does not run now.
    pub fn is_stalled(&self) -> bool {
        self.host.as_ref().is_some_and(Host::is_stalled)
    }

    /// What its clock says.
    pub fn told(&self, now: Timestamp) -> Timestamp {
        self.host.as_ref().map_or(now, |host| host.told(now))
    }

    /// When its clock says `told`.
    pub fn when(&self, told: Timestamp) -> Timestamp {
        self.host.as_ref().map_or(told, |host| host.when(told))
    }

    /// What found no room while it stood still.
    pub fn dropped(&self) -> u64 {
        self.host.as_ref().map_or(0, |host| host.dropped)
    }
}

impl<G> OnHost<G> {
    /// The same machine with a copy of its guest.
    pub(super) fn with_guest<H>(&self, guest: H) -> OnHost<H> {
        OnHost { guest, host: self.host.clone() }
    }
}

impl<G> fmt::Debug for OnHost<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnHost").field("host", &self.host).finish_non_exhaustive()
    }
}

impl Host {
    /// It does not run now.
    const fn is_stalled(&self) -> bool {
        self.stalls > 0
    }

    /// What its clock says.
    fn told(&self, now: Timestamp) -> Timestamp {
        now + self.ahead
    }

    /// When its clock says `told`.
    fn when(&self, told: Timestamp) -> Timestamp {
        if told == Timestamp::MAX { told } else { told - self.ahead }
    }

    /// A fault of a machine begins; others are none of its business.
    fn begin(&mut self, kind: &FaultKind) {
        match kind {
            FaultKind::SchedulerStall { .. } => self.stalls += 1,
            FaultKind::ClockStep { step_s } => self.ahead += Span::from_secs_f64(*step_s),
            _ => {}
        }
    }

    /// It ends; how often it has acted. A machine that goes on hears all at once what was held.
    fn end(&mut self, now: Timestamp, kind: &FaultKind, guest: &mut impl Guest) -> u64 {
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

    /// The guest is to hear bytes or a frame.
    fn hear(&mut self, now: Timestamp, port: PortId, what: Transmit, guest: &mut impl Guest) {
        if self.is_stalled() {
            self.hold(Held::Crossed(port, what));
        } else {
            guest.hear(self.told(now), port, &what);
        }
    }

    /// The guest is given a mission.
    fn mission(&mut self, now: Timestamp, mission: Mission, guest: &mut impl Guest) {
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
