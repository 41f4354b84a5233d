//! Properties of a run: conditions that must hold at every moment, and states that a campaign must reach. Judged during
//! the run.
//!
//! A plan states its own properties as [formulas](temporal) over the signals of its rig, judged message by message
//! ([`Stated`]). The properties below are built in. They belong to the paper's robot and are judged by the truth and
//! the controller's reports; in real time, only as far as the bench shows them ([`Sight`]).
//!
//! | always | is violated when |
//! |---|---|
//! | `fresh_heading` | a velocity is sent while the last good gyro sample is older than the limit |
//! | `stops_on_loss` | after loss of gyro or base, the base moves longer or further than reaction and brakes allow |
//! | `within_limits` | a commanded or true speed, or a true acceleration, exceeds its limit |
//! | `pose_written_at_rest` | a pose is written while the base moves |
//! | `finite_outputs` | a report contains a number that is not finite |
//! | `recovers` | a controller that reports good health makes no use of its gyro some time after a fault |
//! | `done_is_done` | a turn or straight that a healthy controller reports as done was not done |
//! | `no_silent_wrong` | heading or position leaves its band, and health does not report it before the step's end |
//!
//! What is violated in the real world, and not in the one that the inputs of the controller show, is marked with what faults
//! hid: it is no error of the controller. See `hidden.rs`.
//!
//! Properties on the heading are judged while the gyro closes the loops: a plan that runs on odometry accepts worse. A
//! run without steps counts as one step.
//!
//! They are not formulas, because they use the truth and the controller's reports, which are in no message, and their
//! margins are of time and distance, whereas a formula's are of values.
//!
//! Each always-property gives a **margin**, the smallest signed distance to a violation as a share of its limit; a
//! search minimises it. Properties of `sometimes` ([`Sometimes`]) occur or do not.
//!
//! A world feeds [`Monitor`] with what is [`Seen`]. The monitor sends nothing, and a run without one has no overhead.
//! It decodes the bytes that the controller received a second time, so that it judges by the controller's own view of
//! its inputs.

mod always;
mod hidden;
mod limits;
mod monitor;
mod seen;
mod senses;
mod sight;
mod sometimes;
mod stated;
#[cfg(test)]
mod tests;
mod verdict;

pub use limits::{
    DISTANCE_BAND, HEADING_BAND, Limits, POSITION_BAND, RAMPS_MAX, REACTION_MAX, RECOVERY_MAX,
    TRUE_OVER_COMMANDED_MAX,
};
pub use monitor::Monitor;
pub use plan::{Always, Kind, Property, Sometimes, Stated};
pub use seen::{Seen, Truth};
pub use sight::{Sight, Unjudged, View};
pub use verdict::{Missing, PropertyVerdict};

/// Maximum interval of the truth, as long as anything happens; it is also shown whenever the controller sends. Equal to
/// the period of a base's reports in motion.
pub const TRUTH_PERIOD: wire::time::Span = wire::time::Span::from_millis(20);
