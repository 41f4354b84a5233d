//! The machine that the controller runs on: it may stand still, and its clock may jump.

use crate::hosted::HostedController;
use controller::mission::Mission;
use controller::{Input, Port};
use std::collections::VecDeque;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::{Span, Timestamp};

/// What waits for a machine that stands still; more is dropped and counted, as in full buffers of a kernel.
pub(in crate::world) const HELD_MAX: usize = 4_096;

#[derive(Debug)]
enum Held {
    Bytes(Port, Packet),
    Frame(CanFrame),
    // Boxed: a calibration is far larger than a packet.
    Mission(Box<Mission>),
}

/// A machine with faults.
#[derive(Debug, Default)]
pub(in crate::world) struct Host {
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
    pub(in crate::world) const fn is_stalled(&self) -> bool {
        self.stalls > 0
    }

    /// What its clock says.
    pub(in crate::world) fn told(&self, now: Timestamp) -> Timestamp {
        now + self.ahead
    }

    /// When its clock says `told`.
    pub(in crate::world) fn when(&self, told: Timestamp) -> Timestamp {
        if told == Timestamp::MAX { told } else { told - self.ahead }
    }

    pub(in crate::world) fn step_clock(&mut self, by: Span) {
        self.ahead += by;
    }

    pub(in crate::world) fn stall(&mut self) {
        self.stalls += 1;
    }

    /// Goes on; all that was held comes at once.
    pub(in crate::world) fn go_on(
        &mut self,
        now: Timestamp,
        controller: Option<&mut impl HostedController>,
    ) {
        self.stalls = self.stalls.saturating_sub(1);
        let Some(controller) = controller.filter(|_| self.stalls == 0) else { return };
        let now = self.told(now);
        for held in self.held.drain(..) {
            match held {
                Held::Bytes(port, packet) => {
                    controller.receive(now, port, Input::Bytes(packet.as_slice()));
                }
                Held::Frame(frame) => controller.receive(now, Port::Base, Input::Frame(frame)),
                Held::Mission(mission) => controller.command(now, *mission),
            }
        }
    }

    /// How much it has held back so far.
    pub(in crate::world) const fn taken(&self) -> u64 {
        self.taken
    }

    /// What found no room.
    pub(in crate::world) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The controller is to hear bytes.
    pub(in crate::world) fn bytes(
        &mut self,
        now: Timestamp,
        port: Port,
        packet: Packet,
        controller: &mut impl HostedController,
    ) {
        if self.is_stalled() {
            self.hold(Held::Bytes(port, packet));
        } else {
            controller.receive(self.told(now), port, Input::Bytes(packet.as_slice()));
        }
    }

    /// The controller is to hear a frame.
    pub(in crate::world) fn frame(
        &mut self,
        now: Timestamp,
        frame: CanFrame,
        controller: &mut impl HostedController,
    ) {
        if self.is_stalled() {
            self.hold(Held::Frame(frame));
        } else {
            controller.receive(self.told(now), Port::Base, Input::Frame(frame));
        }
    }

    /// The controller is given a mission.
    pub(in crate::world) fn mission(
        &mut self,
        now: Timestamp,
        mission: Mission,
        controller: &mut impl HostedController,
    ) {
        if self.is_stalled() {
            self.hold(Held::Mission(Box::new(mission)));
        } else {
            controller.command(self.told(now), mission);
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
