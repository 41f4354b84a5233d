//! Planted mistakes in the orders that are taken.

use super::Controller;
use crate::config::MotionConfig;
use crate::mission::Command;
use crate::mutant::Mutant;

impl Controller {
    /// `command` as a controller with the planted mistake understands it.
    pub(super) fn misread(&self, command: &mut Command) {
        match (command, &self.config.base) {
            (Command::Straight(order), Some(base)) if self.plants(Mutant::SpeedIgnored) => {
                order.speed = base.speed_max;
            }
            (Command::Turn(order), Some(base)) if self.plants(Mutant::RateIgnored) => {
                order.rate = base.steer_rate_max;
            }
            _ => {}
        }
    }

    /// The tuning of a straight line, as such a controller has it.
    pub(super) fn tuned(&self) -> MotionConfig {
        let mut motion = self.config.motion;
        if self.plants(Mutant::LooseStop) {
            motion.position_tolerance = motion.position_tolerance * 10.0;
        }
        motion
    }
}
