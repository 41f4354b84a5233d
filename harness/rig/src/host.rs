//! The machine that runs a controller or a program: it may stall, and its clock may jump.

use controller::mission::Mission;
use plan::faults::FaultKind;
use std::collections::VecDeque;
use std::fmt;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// Most inputs held for a stalled machine; more are dropped and counted, as by the full buffers of a kernel.
pub(crate) const HELD_MAX: usize = 4_096;

/// Code that runs on a machine. Times are those of the machine's clock.
pub trait Guest {
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit);

    fn order(&mut self, now: Timestamp, mission: Mission);

    /// Sets its wall clock, if it has one beside the clock that it waits by.
    fn set_wall_clock(&mut self, _by: Span) -> bool {
        false
    }
}

#[derive(Debug, Clone)]
enum Held {
    Crossed(PortId, Transmit),
    // Boxed: a calibration is far larger than a packet.
    Mission(Box<Mission>),
}

#[derive(Debug, Clone, Default)]
struct Host {
    stalls: usize,
    held: VecDeque<Held>,
    taken: u64,
    dropped: u64,
    /// How far the clock is ahead of bench time.
    ahead: Span,
}

/// A guest with its machine. Times are those of the bench.
pub struct OnHost<G> {
    pub guest: G,
    /// Present only if faults can strike the machine.
    host: Option<Host>,
}

impl<G: Guest> OnHost<G> {
    pub const fn new(guest: G) -> Self {
        Self { guest, host: None }
    }

    /// Lets faults strike the machine from now on.
    pub fn with_faults(&mut self) {
        self.host = Some(Host::default());
    }

    pub fn begin_fault(&mut self, kind: &FaultKind) {
        if let Some(host) = &mut self.host {
            host.begin(kind, &mut self.guest);
        }
    }

    /// Ends a fault; returns how often it acted. `due` is when the guest wants to be woken.
    pub fn end_fault(&mut self, now: Timestamp, kind: &FaultKind, due: Timestamp) -> u64 {
        let Self { guest, host: Some(host) } = self else { return 0 };
        host.end(now, kind, due, guest)
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

    pub fn is_stalled(&self) -> bool {
        self.host.as_ref().is_some_and(Host::is_stalled)
    }

    /// Time by the machine's clock.
    pub fn told(&self, now: Timestamp) -> Timestamp {
        self.host.as_ref().map_or(now, |host| host.told(now))
    }

    /// Bench time at which the machine's clock shows `told`.
    pub fn when(&self, told: Timestamp) -> Timestamp {
        self.host.as_ref().map_or(told, |host| host.when(told))
    }

    pub fn dropped(&self) -> u64 {
        self.host.as_ref().map_or(0, |host| host.dropped)
    }

    /// Loses what is held for a stalled machine.
    pub fn forget(&mut self) {
        if let Some(host) = &mut self.host {
            host.held.clear();
        }
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
    const fn is_stalled(&self) -> bool {
        self.stalls > 0
    }

    /// Time by the machine's clock.
    fn told(&self, now: Timestamp) -> Timestamp {
        now + self.ahead
    }

    /// Bench time at which the machine's clock shows `told`.
    fn when(&self, told: Timestamp) -> Timestamp {
        if told == Timestamp::MAX { told } else { told - self.ahead }
    }

    /// Begins a fault of a machine; ignores other faults.
    fn begin(&mut self, kind: &FaultKind, guest: &mut impl Guest) {
        match kind {
            FaultKind::SchedulerStall { .. } => self.stalls += 1,
            FaultKind::ClockStep { step_s } => {
                self.set_clock(Span::from_secs_f64(*step_s), guest);
            }
            _ => {}
        }
    }

    fn set_clock(&mut self, by: Span, guest: &mut impl Guest) {
        if !guest.set_wall_clock(by) {
            self.ahead += by;
        }
    }

    /// Ends a fault; returns how often it acted. A machine that resumes receives all held inputs at once.
    fn end(
        &mut self,
        now: Timestamp,
        kind: &FaultKind,
        due: Timestamp,
        guest: &mut impl Guest,
    ) -> u64 {
        match kind {
            FaultKind::SchedulerStall { .. } => {
                self.go_on(now, guest);
                // What fell due in the meantime is late.
                self.taken + u64::from(due < now)
            }
            FaultKind::ClockStep { step_s } => {
                self.set_clock(-Span::from_secs_f64(*step_s), guest);
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
        // Inputs waited at each port, and a machine that resumes reads one port after the other: serial ports in the
        // order of their first input, then buses, missions last. A program in step with the world does the same.
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

    fn hear(&mut self, now: Timestamp, port: PortId, what: Transmit, guest: &mut impl Guest) {
        if self.is_stalled() {
            self.hold(Held::Crossed(port, what));
        } else {
            guest.hear(self.told(now), port, &what);
        }
    }

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
