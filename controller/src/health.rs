//! The controller's self-assessment.

use serde::{Deserialize, Serialize};

/// Trust level of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Still waiting for the first data of an input.
    #[default]
    Starting,
    /// All is well.
    Ok,
    /// Works, but its heading or pose may be worse than specified.
    Degraded,
    /// An input that its missions need is lost or untrustworthy: it refuses those missions.
    Fault,
}

/// Reasons for a level other than `ok`. Those that are set explain the level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Causes {
    /// Fault: no gyro sample within the time-out.
    pub gyro_silent: bool,
    /// Fault: invalid data, a failed built-in test, or the same reading again and again.
    pub gyro_fault: bool,
    /// Fault: no motion message within the time-out.
    pub base_silent: bool,
    /// Fault: emergency stop, drive fault.
    pub base_not_ready: bool,
    /// Degraded: a rate beyond the gyro's range was integrated since a pose was last set.
    pub gyro_over_range: bool,
    /// Degraded: since a pose was last set, invalid samples or impossible jumps were bridged, or readings were stuck.
    pub gyro_invalid: bool,
    /// Degraded: samples were lost since a pose was last set.
    pub samples_lost: bool,
    /// Degraded: the odometer disagreed with the base's commands since a pose was last set, or the base fell silent while
    /// it moved and has not been heard to stand since.
    pub odometry_doubtful: bool,
    /// Degraded: since a pose was last set, gyro and steering odometry differed by more than the base's own errors.
    /// One of the two is wrong.
    pub headings_disagree: bool,
    /// Degraded: since a pose was last set, the gyro turned while the base reported that it stood.
    pub moved_at_rest: bool,
    /// Degraded: the gyro's clock falsifies the heading, or has changed.
    pub clock_mismatch: bool,
    /// Degraded: no bias is known by the chosen method.
    pub no_bias: bool,
    /// Degraded: at a standstill the bias differed from the last bias test, or had done so since a pose was last set.
    pub bias_moved: bool,
    /// Degraded: an impossible temperature was reported since a pose was last set, or is reported now.
    pub temperature_doubtful: bool,
    /// Degraded: the last bias test failed.
    pub bias_test_failed: bool,
    /// Degraded: the base did not accept the last pose.
    pub pose_not_written: bool,
    /// Degraded: the gyro is silent, and the odometry replaces it.
    pub bridging: bool,
    /// Degraded: the selected estimator failed, and the paper's method replaces it; or the filter that watches that method
    /// failed since a pose was last set and the base drove.
    pub estimator_failed: bool,
    /// Degraded: an internal queue overflowed; reports or requests were lost.
    pub overflow: bool,
}

impl Causes {
    /// True if a cause forbids motion.
    pub const fn any_fault(&self) -> bool {
        self.gyro_silent || self.gyro_fault || self.base_silent || self.base_not_ready
    }
}

/// Level and causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Trust level.
    pub level: Level,
    /// Reasons for the level.
    pub causes: Causes,
}

impl Health {
    /// The level that follows from `causes`; `starting` until all inputs have delivered data.
    pub fn new(starting: bool, causes: Causes) -> Self {
        let level = if starting {
            Level::Starting
        } else if causes.any_fault() {
            Level::Fault
        } else if causes != Causes::default() {
            Level::Degraded
        } else {
            Level::Ok
        };
        Self { level, causes }
    }
}

#[cfg(test)]
mod tests {
    use super::{Causes, Health, Level};

    #[test]
    fn the_worst_cause_decides() {
        let lost = Causes { samples_lost: true, ..Causes::default() };
        assert_eq!(Health::new(false, Causes::default()).level, Level::Ok);
        assert_eq!(Health::new(false, lost).level, Level::Degraded);
        assert_eq!(Health::new(false, Causes { gyro_silent: true, ..lost }).level, Level::Fault);
        assert_eq!(Health::new(true, lost).level, Level::Starting);
    }
}
