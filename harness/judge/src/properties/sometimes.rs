//! Which of the relevant states a run has reached.

use super::Sometimes;
use super::senses::{Fact, Order, Senses};
use controller::health::Level;
use controller::mission::{AbortReason, Report};
use std::collections::BTreeSet;

/// The states that were reached.
#[derive(Debug, Clone, Default)]
pub(super) struct Reached {
    reached: BTreeSet<Sometimes>,
    fault: bool,
}

impl Reached {
    pub(super) fn has(&self, state: Sometimes) -> bool {
        self.reached.contains(&state)
    }

    pub(super) fn judge(&mut self, senses: &Senses, fact: &Fact) {
        match fact {
            Fact::Gyro if senses.resyncs() > 0 => self.reach(Sometimes::Resynchronised),
            Fact::BusOff => self.reach(Sometimes::BusOff),
            Fact::Health => self.health(senses),
            Fact::Answered(_, order, report) => self.answer(*order, report),
            _ => {}
        }
    }

    fn reach(&mut self, state: Sometimes) {
        self.reached.insert(state);
    }

    fn health(&mut self, senses: &Senses) {
        let causes = senses.health.causes;
        let said = [
            (causes.gyro_silent, Sometimes::GyroSilent),
            (causes.gyro_fault, Sometimes::GyroFault),
            (causes.samples_lost, Sometimes::SamplesLost),
            (causes.gyro_over_range, Sometimes::OverRange),
            (causes.clock_mismatch, Sometimes::ClockMismatch),
            (causes.base_silent, Sometimes::BaseSilent),
            (causes.base_not_ready, Sometimes::BaseNotReady),
            (causes.pose_not_written, Sometimes::PoseNotWritten),
            (causes.overflow, Sometimes::Overflow),
        ];
        self.reached.extend(said.into_iter().filter(|(is, _)| *is).map(|(_, state)| state));
        match senses.health.level {
            Level::Fault => self.fault = true,
            Level::Ok | Level::Degraded if self.fault => self.reach(Sometimes::Recovered),
            _ => {}
        }
    }

    fn answer(&mut self, order: Order, report: &Report) {
        match report {
            Report::Refused { .. } => {
                self.reach(Sometimes::MissionRefused);
                if order == Order::BiasTest {
                    self.reach(Sometimes::BiasTestRefused);
                }
            }
            Report::Aborted { reason, .. } => {
                self.reach(Sometimes::MissionAborted);
                match reason {
                    AbortReason::NotAtRest => self.reach(Sometimes::BiasTestRefused),
                    AbortReason::BaseCommandTimeout => self.reach(Sometimes::BaseStoppedItself),
                    _ => {}
                }
            }
            _ => {}
        }
    }
}
