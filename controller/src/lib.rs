//! The controller of a synchro-drive robot with a fibre-optic gyro as its heading sensor: the code under test,
//! modelled on Borenstein's work with the Andrew Autogyro Navigator and the Cybermotion K2A.
//!
//! [`Controller`] is a state machine without IO, allocation or clock. Its owner calls:
//!
//! ```text
//! receive(now, port, bytes | frame)   gyro stream, base messages
//! command(now, mission)               bias test, straight, turn, set pose, ...
//! wake(now)                           whenever next_wakeup() is due
//! transmit(now) -> Option<Output>     until None, after each of the above
//! report() -> Option<Report>          until None, after each of the above
//! ```
//!
//! * [`mission`]: commands and reports; documented as JSON lines for the process.
//! * [`calibration`]: Eq. 4's chain of factors, Eq. 6, and the table of bias against temperature.
//! * [`correction`]: subtracts the terms of an identified model from the rate.
//! * [`health`]: whether the controller's output can be trusted, and why not.
//! * [`config`]: ports, limits, gains; every default cites its source.
//! * [`approach`]: the two loops that straight lines and turns share.
//!
//! The controller stops the base when it loses the heading or the base, refuses impossible missions, and answers every
//! mission exactly once. The program `k2a-controller` (`harness/hil/src/bin`) is a thin shell around it: two ports,
//! the real clock, JSON lines on stdin and stdout.

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
mod follow_watch;
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
mod ordered;
mod own_time;
mod pose_download;
mod silence;
mod standstill;
mod stuck_watch;
mod temperature_watch;

pub use machine::{
    ANGLE_RAD_MAX, BIAS_TEST_S_MAX, Controller, DISTANCE_M_MAX, Input, Output, Port, RATE_MIN,
    REPORTS_MAX, SPEED_MIN, STATE_PERIOD_AT_REST,
};
#[cfg(feature = "mutants")]
pub use mutant::Mutant;
