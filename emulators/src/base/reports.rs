//! Reports of a base and their times.

use super::Transport;
use std::collections::VecDeque;
use wire::base::{Motion, Reply, can_link};
use wire::device::Transmit;
use wire::packet::Packet;
use wire::time::{Span, Timestamp};
use wire::units::Pose;

/// Maximum number of frames or answers waiting to be sent.
pub const OUTPUTS_MAX: usize = 64;

/// Time between two motion reports on CAN while the base moves (assumption).
pub const MOTION_PERIOD_IN_MOTION: Span = Span::from_millis(20);

/// Time between two motion reports on CAN at rest (assumption).
pub const MOTION_PERIOD_AT_REST: Span = Span::from_millis(500);

/// Time between two pose reports on CAN (assumption).
pub const POSE_PERIOD: Span = Span::from_millis(500);

#[derive(Debug, Clone)]
pub(super) struct Reports {
    transport: Transport,
    motion_at: Timestamp,
    pose_at: Timestamp,
    outputs: VecDeque<Transmit>,
    dropped: u64,
}

impl Reports {
    pub(super) fn new(transport: Transport) -> Self {
        Self {
            transport,
            motion_at: Timestamp::ZERO,
            pose_at: Timestamp::ZERO,
            outputs: VecDeque::new(),
            dropped: 0,
        }
    }

    /// Time of the next report; [`Timestamp::MAX`], never, on a serial line.
    pub(super) fn next_due(&self) -> Timestamp {
        if self.reports() { self.motion_at.min(self.pose_at) } else { Timestamp::MAX }
    }

    pub(super) fn motion_due(&self, now: Timestamp) -> bool {
        self.reports() && self.motion_at <= now
    }

    pub(super) fn pose_due(&self, now: Timestamp) -> bool {
        self.reports() && self.pose_at <= now
    }

    /// Makes a motion report due at `now`, after a change that the host should see at once.
    pub(super) fn motion_is_due(&mut self, now: Timestamp) {
        self.motion_at = self.motion_at.min(now);
    }

    pub(super) fn send_motion(&mut self, now: Timestamp, motion: Motion) {
        let period = if motion.moving { MOTION_PERIOD_IN_MOTION } else { MOTION_PERIOD_AT_REST };
        self.motion_at = now + period;
        self.push(Transmit::Frame(can_link::reply_frame(&Reply::Motion(motion))));
    }

    pub(super) fn send_pose(&mut self, now: Timestamp, pose: Pose) {
        self.pose_at = now + POSE_PERIOD;
        self.push(Transmit::Frame(can_link::reply_frame(&Reply::Pose(pose))));
    }

    pub(super) fn answer(&mut self, packet: Packet) {
        self.push(Transmit::Bytes(packet));
    }

    pub(super) fn transmit(&mut self) -> Option<Transmit> {
        self.outputs.pop_front()
    }

    pub(super) const fn dropped(&self) -> u64 {
        self.dropped
    }

    fn reports(&self) -> bool {
        self.transport == Transport::Can
    }

    fn push(&mut self, output: Transmit) {
        if self.outputs.len() < OUTPUTS_MAX {
            self.outputs.push_back(output);
        } else {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}
