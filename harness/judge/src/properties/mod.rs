//! Properties of a run: what must hold at every moment, and what a campaign must have reached. Judged
//! while a run goes on.
//!
//! A plan states its own as [formulas](temporal) over the signals of its rig, judged message by message ([`Stated`]). Those
//! below are built in: they are of the paper's robot, judged from what is true and from what the controller says; in real
//! time by as much of it as the bench shows ([`Sight`]).
//!
//! | always | is violated when |
//! |---|---|
//! | `fresh_heading` | a velocity is sent while the last good gyro sample is older than the limit |
//! | `stops_on_loss` | the base moves longer or further than reaction and brakes allow after the gyro or the base was last heard |
//! | `within_limits` | a commanded or true speed, or a true speeding up, is beyond its limit |
//! | `pose_written_at_rest` | a pose is written while the base moves |
//! | `finite_outputs` | a report holds a number that is none |
//! | `recovers` | a controller that calls itself well makes no use of its gyro some time after a fault |
//! | `done_is_done` | a turn or straight that a well controller calls done was not done |
//! | `no_silent_wrong` | heading or position leaves its band, and no word of it before the lap's end |
//!
//! What is violated from when a fault began that no input of the controller shows (wheels that slip; another sensor would
//! see them) is named as such: it is no mistake of the controller.
//!
//! Heading-based ones are judged while the gyro closes the loops: by odometry a plan asks for worse. A
//! lap is a step of the plan; without steps, the run.
//!
//! They are no formulas: they go by the truth and by the controller's reports, which are in no message, and their margins are
//! of time and of distance gone, where a formula's is of values.
//!
//! Each always-property gives a **margin**, the least signed distance to a violation as a share of its
//! limit, which a search goes down along. Those of `sometimes` ([`Sometimes`]) come about or not.
//!
//! [`Monitor`] is fed by a world with what is [`Seen`]; it sends nothing and costs nothing where there is
//! none. The bytes that the controller received are decoded a second time: what the controller itself says
//! of its inputs is what is judged.

mod always;
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
pub use verdict::PropertyVerdict;

/// The truth is shown at least this often, as far as anything happens meanwhile, and whenever the controller says
/// something: the period of a base's reports in motion.
pub const TRUTH_PERIOD: wire::time::Span = wire::time::Span::from_millis(20);
