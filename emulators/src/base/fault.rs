//! Deliberate faults of a base. Faults of its line or bus are elsewhere.

use super::BaseEmulator;
use crate::random::RandomStream;
use wire::base::{Motion, Request};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Pose};

/// A persistent fault of a base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BaseFault {
    /// It refuses velocities but accepts stops.
    RefuseCommands,
    /// Its reports repeat the displacement, heading and pose of the first report after the fault began.
    StuckOdometry,
    /// The wheels slip.
    WheelSlip {
        /// Lost share of the path, within 0 to 1.
        lost: f64,
    },
    /// A stop, or a velocity of zero, is carried out late. A velocity in the meantime replaces it.
    LateStop {
        /// The delay.
        by: Span,
    },
    /// The emergency stop is pressed.
    EmergencyStop,
}

/// A fault with the reports that it repeats.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    fault: BaseFault,
    motion: Option<Motion>,
    pose: Option<Pose>,
}

impl BaseEmulator {
    /// Switches a fault on under `number`.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        fault: BaseFault,
        chance: RandomStream,
    ) {
        self.advance(now);
        self.faults.switch_on(number, Kept { fault, motion: None, pose: None }, chance);
        self.switched(now, fault);
        if fault == BaseFault::EmergencyStop {
            self.act(|fault| fault == BaseFault::EmergencyStop);
        }
    }

    /// Switches a fault off; returns the number of commands or reports it has changed.
    pub fn end_fault(&mut self, now: Timestamp, number: usize) -> u64 {
        self.advance(now);
        let Some((acted, kept)) = self.faults.switch_off(number) else { return 0 };
        self.switched(now, kept.fault);
        acted
    }

    /// The steering encoder counts `angle` without a motion; the base's own pose turns with it.
    pub fn jump_encoder(&mut self, now: Timestamp, angle: Angle) {
        self.advance(now);
        // Starts a phase here, so that its start can be moved.
        self.start_phase(now, self.kinematics.targets(), self.accelerations());
        let mut state = self.kinematics.state_at(now);
        state.steered += angle.rad();
        state.reckoned.steer += angle.rad();
        self.kinematics.set_state(state);
    }

    fn switched(&mut self, now: Timestamp, fault: BaseFault) {
        match fault {
            BaseFault::WheelSlip { .. } => {
                self.start_phase(now, self.kinematics.targets(), self.accelerations());
                self.apply_track_model(now);
            }
            BaseFault::EmergencyStop => {
                let pressed = self.is_on(|fault| fault == BaseFault::EmergencyStop);
                self.set_emergency_stop(now, pressed);
            }
            _ => {}
        }
    }

    fn is_on(&self, is: impl Fn(BaseFault) -> bool) -> bool {
        self.faults.iter().any(|switch| is(switch.fault.fault))
    }

    /// Counts an action of each such fault; returns true if there is one.
    fn act(&mut self, is: impl Fn(BaseFault) -> bool) -> bool {
        let mut any = false;
        for switch in self.faults.iter_mut().filter(|switch| is(switch.fault.fault)) {
            switch.acted += 1;
            any = true;
        }
        any
    }

    /// The share of the path that remains on the floor.
    pub(super) fn grip(&self) -> f64 {
        let lost = self.faults.iter().map(|switch| match switch.fault.fault {
            BaseFault::WheelSlip { lost } => 1.0 - lost,
            _ => 1.0,
        });
        lost.product()
    }

    /// The request to carry out now, if any.
    #[cold]
    pub(super) fn through_faults(&mut self, now: Timestamp, request: Request) -> Option<Request> {
        let stops = match request {
            Request::Stop => true,
            Request::SetVelocity { drive, steer } => {
                if self.act(|fault| fault == BaseFault::RefuseCommands) {
                    return None;
                }
                drive.m_per_s() == 0.0 && steer.rad_per_s() == 0.0
            }
            _ => return Some(request),
        };
        let late = self.faults.iter().find_map(|switch| match switch.fault.fault {
            BaseFault::LateStop { by } => Some(by),
            _ => None,
        });
        match late {
            Some(by) if stops => {
                if self.late_stop.is_none() && self.kinematics.is_moving() {
                    self.act(|fault| matches!(fault, BaseFault::LateStop { .. }));
                    self.late_stop = Some((now + by, request));
                    return None;
                }
                self.late_stop.is_none().then_some(request)
            }
            _ => {
                if !stops {
                    self.late_stop = None;
                }
                Some(request)
            }
        }
    }

    #[cold]
    pub(super) fn motion_through_faults(&mut self, motion: Motion) -> Motion {
        let mut told = motion;
        for switch in self.faults.iter_mut() {
            if switch.fault.fault == BaseFault::StuckOdometry {
                let first = *switch.fault.motion.get_or_insert(told);
                told = Motion { displacement: first.displacement, heading: first.heading, ..told };
                switch.acted += 1;
            }
            if matches!(switch.fault.fault, BaseFault::WheelSlip { .. }) && motion.moving {
                switch.acted += 1;
            }
        }
        told
    }

    #[cold]
    pub(super) fn pose_through_faults(&mut self, pose: Pose) -> Pose {
        let mut told = pose;
        for switch in self.faults.iter_mut() {
            if switch.fault.fault == BaseFault::StuckOdometry {
                told = *switch.fault.pose.get_or_insert(told);
                switch.acted += 1;
            }
        }
        told
    }
}
