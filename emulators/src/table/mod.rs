//! A stepper-driven rotary table: takes lines of text, turns, answers with lines of text.
//!
//! The indexer turns each move into a trapezoid of step rate. The motor loses whole electrical cycles if it is ramped
//! too hard, the gear has play at each reversal, and eccentricity shows once and twice per turn. The indexer counts
//! the steps it sends and notices none of this.
//!
//! Between steps the angle is taken as smooth: inertia carries the table over 0.0125 deg.

mod fault;
mod mechanics;
mod parameters;
mod profile;
mod slip;
#[cfg(test)]
mod tests;

pub use parameters::TableParameters;
pub use slip::STEPS_PER_ELECTRICAL_CYCLE;

use crate::parameters::{ParameterError, Parameters as _};
use mechanics::Mechanics;
use profile::Profile;
use slip::Slip;
use std::collections::VecDeque;
use wire::packet::Packet;
use wire::table::{Answer, Command, CommandDecoder};
use wire::time::Timestamp;
use wire::units::Angle;

/// Maximum number of answers waiting to be sent.
pub const ANSWERS_MAX: usize = 16;

/// Top rate at power-up, in steps/s: the paper's 30 deg/s with the default step.
const TOP_RATE_AT_POWER_UP: u32 = 2_400;
/// Ramp at power-up, in steps/s^2: 15 deg/s^2 with the default step, which fits the paper's 48 s run.
const RAMP_AT_POWER_UP: u32 = 1_200;

/// An emulated rotary table.
#[derive(Debug, Clone)]
pub struct TableEmulator {
    parameters: TableParameters,
    commands: CommandDecoder,
    top_rate: u32,
    ramp: u32,
    distance: i32,
    moving: bool,
    profile: Profile,
    mechanics: Mechanics,
    answers: VecDeque<Packet>,
    dropped: u64,
}

impl TableEmulator {
    /// A table at rest at angle zero.
    pub fn new(parameters: TableParameters) -> Self {
        Self {
            parameters,
            commands: CommandDecoder::default(),
            top_rate: TOP_RATE_AT_POWER_UP,
            ramp: RAMP_AT_POWER_UP,
            distance: 0,
            moving: false,
            profile: Profile::at_rest(0.0),
            mechanics: Mechanics::AT_POWER_UP,
            answers: VecDeque::new(),
            dropped: 0,
        }
    }

    /// Takes bytes from the line, in pieces of any length.
    pub fn receive(&mut self, now: Timestamp, bytes: &[u8]) {
        let mut commands = std::mem::take(&mut self.commands);
        commands.feed(bytes, |line| {
            let answer = line.map_or_else(|refusal| refusal, |command| self.command(now, command));
            if self.answers.len() < ANSWERS_MAX {
                self.answers.push_back(answer.encode());
            } else {
                self.dropped = self.dropped.saturating_add(1);
            }
        });
        self.commands = commands;
    }

    /// Advances to `now`.
    pub fn wake(&mut self, now: Timestamp) {
        if self.moving && self.profile.end() <= now {
            self.end_move(self.profile.end());
        }
    }

    /// The next answer to send, if any.
    pub fn transmit(&mut self) -> Option<Packet> {
        self.answers.pop_front()
    }

    /// End of the current move; `None` at rest.
    pub fn next_wakeup(&self) -> Option<Timestamp> {
        self.moving.then(|| self.profile.end())
    }

    /// Carries out a command and returns its answer.
    pub fn command(&mut self, now: Timestamp, command: Command) -> Answer {
        self.wake(now);
        let verb = command.verb();
        let accepted = match command {
            Command::TopRate(rate) => {
                let accepted = rate > 0 && f64::from(rate) <= self.parameters.rate_max_steps_per_s;
                if accepted {
                    self.top_rate = rate;
                }
                accepted
            }
            Command::Ramp(ramp) => {
                if ramp > 0 {
                    self.ramp = ramp;
                }
                ramp > 0
            }
            Command::Distance(distance) => {
                self.distance = distance;
                true
            }
            Command::Go => self.go(now),
            Command::Stop => {
                self.stop(now);
                true
            }
            Command::State => {
                return Answer::State {
                    // The counter of a 32-bit indexer, which saturates.
                    position_steps: libm::trunc(self.profile.position(now)) as i32,
                    moving: self.moving,
                };
            }
        };
        if accepted { Answer::Done(verb) } else { Answer::refused(verb) }
    }

    /// Sets the parameter `name` from `now` on; the limit of the ramp from the next move on.
    pub fn set_parameter(
        &mut self,
        now: Timestamp,
        name: &str,
        value: f64,
    ) -> Result<(), ParameterError> {
        self.wake(now);
        self.parameters.set(name, value)
    }

    /// The current parameters.
    pub const fn parameters(&self) -> &TableParameters {
        &self.parameters
    }

    /// The table's true angle at `now` (unwrapped, counter-clockwise, zero at power-up), not before the last call with
    /// a time.
    pub fn angle_at(&self, now: Timestamp) -> Angle {
        self.mechanics.angle_at(&self.parameters, &self.profile, now)
    }

    /// Steps lost until `now`; counter-clockwise is positive.
    pub fn steps_lost_at(&self, now: Timestamp) -> f64 {
        self.mechanics.lost_steps(&self.profile, now)
    }

    /// Number of lines that were not commands.
    pub const fn lines_refused(&self) -> u64 {
        self.commands.refused()
    }

    /// Answers lost because more than [`ANSWERS_MAX`] were waiting.
    pub const fn answers_dropped(&self) -> u64 {
        self.dropped
    }

    fn go(&mut self, now: Timestamp) -> bool {
        if self.moving {
            return false;
        }
        let (rate, ramp) = (f64::from(self.top_rate), f64::from(self.ramp));
        let from = self.profile.position(now);
        self.profile = Profile::new(now, from, f64::from(self.distance), rate, ramp);
        let limit = self.parameters.acceleration_limit_steps_per_s2;
        self.mechanics.begin_move(Slip::of(&self.profile, ramp, limit));
        self.moving = true;
        self.wake(now);
        true
    }

    fn stop(&mut self, now: Timestamp) {
        if self.moving {
            let stopped = self.profile.stopped(now, f64::from(self.ramp));
            self.mechanics.end_move(&self.parameters, &self.profile, now);
            self.profile = stopped;
            self.wake(now);
        }
    }

    fn end_move(&mut self, at: Timestamp) {
        self.mechanics.end_move(&self.parameters, &self.profile, at);
        self.profile = Profile::at_rest(self.profile.position(at));
        self.moving = false;
    }
}
