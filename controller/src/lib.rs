//! The controller of a synchro-drive robot whose heading comes from a fibre-optic gyro: the code under
//! test, after Borenstein's work with the Andrew Autogyro Navigator and the Cybermotion K2A.
//!
//! [`Controller`] is a state machine without IO, allocation or clock. Its owner feeds it and empties it:
//!
//! ```text
//! receive(now, port, bytes | frame)   gyro stream, base messages
//! command(now, mission)               bias test, straight, turn, set pose, ...
//! wake(now)                           whenever next_wakeup() is due
//! transmit(now) -> Option<Output>     until None, after each of the above
//! report() -> Option<Report>          until None, after each of the above
//! ```
//!
//! * [`mission`]: what it is told and what it tells; documented JSON lines for the process.
//! * [`calibration`]: Eq. 4's chain of factors, Eq. 6, and the table of bias against temperature.
//! * [`correction`]: the terms of a model that was identified, taken off the rate.
//! * [`health`]: how far it can be believed, and why.
//! * [`config`]: ports, limits, gains; every default names its source.
//! * [`approach`]: the two loops that straight lines and turns share.
//!
//! It stops the base by itself when the heading or the base is lost, refuses what it cannot do, and
//! answers every mission exactly once. The program `k2a-controller` (`harness/hil/src/bin`) is a thin shell around
//! it: two ports, the real clock, JSON lines on stdin and stdout.

#![no_std]

#[cfg(test)]
extern crate std;

pub mod approach;
mod base_driver;
mod bias_test;
mod bump_watch;
pub mod calibration;
mod clock_watch;
pub mod config;
pub mod correction;
mod dead_reckoning;
mod displacement_watch;
mod drive;
mod gyro_input;
mod heading;
mod heading_watch;
pub mod health;
mod jump_gate;
mod kalman;
mod loss_watch;
mod machine;
pub mod mission;
mod mutant;
mod own_time;
mod path_watch;
mod pose_download;
mod standstill;
mod stuck_watch;
mod temperature_watch;

pub use machine::{
    ANGLE_RAD_MAX, BIAS_TEST_S_MAX, Controller, DISTANCE_M_MAX, Input, Output, Port, RATE_MIN,
    REPORTS_MAX, SPEED_MIN, STATE_PERIOD_AT_REST,
};
#[cfg(feature = "mutants")]
pub use mutant::Mutant;
