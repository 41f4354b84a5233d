//! Deliberately planted mistakes, one at a time. They measure how many faults of a controller a method finds.
//!
//! Each is at a place where a person would make it. Without the feature `mutants` none can be planted: [`Planted`] is
//! empty and answers no at compile time, so that the code is the same as without this module.

/// One mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "mutants", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "mutants", serde(rename_all = "kebab-case"))]
pub enum Mutant {
    /// A silent gyro shows in health but aborts no motion.
    StaleHeading,
    /// The calibration's correction has the wrong sign counter-clockwise.
    CcwSign,
    /// The base may be silent ten times as long in motion.
    WatchdogOffByTen,
    /// A bias test checks neither the base nor the readings for rest.
    BiasTestWhileMoving,
    /// The target heading of a turn is wrapped at 360 deg, the heading itself is not.
    WrapAt360,
    /// A gap in the gyro's sequence numbers goes unnoticed.
    MissedSequenceGap,
    /// A straight line ends on arrival, and its pose is written, before the base has come to rest.
    PoseWrittenInMotion,
    /// The heading is kept as a 32-bit count of 0.00001 deg, which overflows after 59 turns.
    OverflowAfterLongRuns,
    /// A rate beyond the gyro's range is integrated as if it were right.
    OverRangeIgnored,
    /// A repeated sample is integrated twice.
    RepeatedSampleCounted,
    /// Readings that are stuck in spite of noise are integrated.
    StuckReadingsBelieved,
    /// A reading that the base cannot have reached is integrated.
    JumpBelieved,
    /// Gyro and steering odometry are never compared.
    HeadingsNotCompared,
    /// Any temperature is believed, even an impossible or frozen one.
    TemperatureBelieved,
    /// The odometer may lag behind the commands without limit during motion.
    LaggingOdometerBelieved,
    /// Rotation while the base reports that it stands is taken for bias.
    BumpIgnored,
    /// The bias is not checked at standstills.
    MovedBiasIgnored,
    /// A bias test clears earlier faults of the heading.
    BiasTestForgives,
    /// The pose written to the base is always the origin.
    WrongPoseDownloaded,
    /// Dead reckoning swaps left and right.
    MirroredReckoning,
    /// The bias is always that of the last test, whatever the selected method.
    BiasMethodIgnored,
    /// The factors of the two directions are swapped.
    SwappedDirections,
    /// Only the first of the factors of Eq. 4 is used.
    FirstFactorAlone,
    /// A straight line is driven at the base's top speed, whatever the command.
    SpeedIgnored,
    /// A turn runs at the base's top rate, whatever the command.
    RateIgnored,
    /// The heading drifts with the gyro at rest.
    HeadingNotHeld,
    /// Nothing shows in health.
    HealthSilent,
    /// A host clock that is set back is believed.
    HostClockBelieved,
    /// After a stop the base is said to stand, whatever it reports.
    StopCalledRest,
    /// The tolerance for the end of a straight line is ten times too wide.
    LooseStop,
    /// A straight line does not steer.
    SteeringLoopOpen,
    /// A straight line steers away from its heading.
    SteeringReversed,
    /// A turn ends by the base's odometry, whatever the heading source.
    TurnByOdometry,
    /// The pose is written to the base after straight lines alone.
    TurnNotWritten,
    /// An inch of the base's path is taken for 25 mm.
    ShortInch,
    /// A gyro with the opposite convention is read like any other.
    SignIgnored,
}

#[cfg(feature = "mutants")]
impl Mutant {
    /// All mutants.
    pub const ALL: &[Self] = &[
        Self::StaleHeading,
        Self::CcwSign,
        Self::WatchdogOffByTen,
        Self::BiasTestWhileMoving,
        Self::WrapAt360,
        Self::MissedSequenceGap,
        Self::PoseWrittenInMotion,
        Self::OverflowAfterLongRuns,
        Self::OverRangeIgnored,
        Self::RepeatedSampleCounted,
        Self::StuckReadingsBelieved,
        Self::JumpBelieved,
        Self::HeadingsNotCompared,
        Self::TemperatureBelieved,
        Self::LaggingOdometerBelieved,
        Self::BumpIgnored,
        Self::MovedBiasIgnored,
        Self::BiasTestForgives,
        Self::WrongPoseDownloaded,
        Self::MirroredReckoning,
        Self::BiasMethodIgnored,
        Self::SwappedDirections,
        Self::FirstFactorAlone,
        Self::SpeedIgnored,
        Self::RateIgnored,
        Self::HeadingNotHeld,
        Self::HealthSilent,
        Self::HostClockBelieved,
        Self::StopCalledRest,
        Self::LooseStop,
        Self::SteeringLoopOpen,
        Self::SteeringReversed,
        Self::TurnByOdometry,
        Self::TurnNotWritten,
        Self::ShortInch,
        Self::SignIgnored,
    ];

    /// Words joined by hyphens.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StaleHeading => "stale-heading",
            Self::CcwSign => "ccw-sign",
            Self::WatchdogOffByTen => "watchdog-off-by-ten",
            Self::BiasTestWhileMoving => "bias-test-while-moving",
            Self::WrapAt360 => "wrap-at-360",
            Self::MissedSequenceGap => "missed-sequence-gap",
            Self::PoseWrittenInMotion => "pose-written-in-motion",
            Self::OverflowAfterLongRuns => "overflow-after-long-runs",
            Self::OverRangeIgnored => "over-range-ignored",
            Self::RepeatedSampleCounted => "repeated-sample-counted",
            Self::StuckReadingsBelieved => "stuck-readings-believed",
            Self::JumpBelieved => "jump-believed",
            Self::HeadingsNotCompared => "headings-not-compared",
            Self::TemperatureBelieved => "temperature-believed",
            Self::LaggingOdometerBelieved => "lagging-odometer-believed",
            Self::BumpIgnored => "bump-ignored",
            Self::MovedBiasIgnored => "moved-bias-ignored",
            Self::BiasTestForgives => "bias-test-forgives",
            Self::WrongPoseDownloaded => "wrong-pose-downloaded",
            Self::MirroredReckoning => "mirrored-reckoning",
            Self::BiasMethodIgnored => "bias-method-ignored",
            Self::SwappedDirections => "swapped-directions",
            Self::FirstFactorAlone => "first-factor-alone",
            Self::SpeedIgnored => "speed-ignored",
            Self::RateIgnored => "rate-ignored",
            Self::HeadingNotHeld => "heading-not-held",
            Self::HealthSilent => "health-silent",
            Self::HostClockBelieved => "host-clock-believed",
            Self::StopCalledRest => "stop-called-rest",
            Self::LooseStop => "loose-stop",
            Self::SteeringLoopOpen => "steering-loop-open",
            Self::SteeringReversed => "steering-reversed",
            Self::TurnByOdometry => "turn-by-odometry",
            Self::TurnNotWritten => "turn-not-written",
            Self::ShortInch => "short-inch",
            Self::SignIgnored => "sign-ignored",
        }
    }
}

/// The planted mistake, if any.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Planted {
    #[cfg(feature = "mutants")]
    mutant: Option<Mutant>,
}

impl Planted {
    #[cfg(feature = "mutants")]
    pub(crate) const fn new(mutant: Option<Mutant>) -> Self {
        Self { mutant }
    }

    /// True if `mutant` is planted.
    #[cfg(feature = "mutants")]
    pub(crate) const fn is(self, mutant: Mutant) -> bool {
        matches!(self.mutant, Some(planted) if planted as u8 == mutant as u8)
    }

    /// True for a mistake that a second check would find as well. Reports of that check would hide the mistake's own
    /// effect.
    #[cfg(feature = "mutants")]
    pub(crate) const fn blinds_second_looks(self) -> bool {
        matches!(
            self.mutant,
            Some(
                Mutant::CcwSign
                    | Mutant::WatchdogOffByTen
                    | Mutant::BiasTestWhileMoving
                    | Mutant::WrapAt360
                    | Mutant::OverflowAfterLongRuns
                    | Mutant::OverRangeIgnored
                    | Mutant::RepeatedSampleCounted
            )
        )
    }

    /// No mistake is planted.
    #[cfg(not(feature = "mutants"))]
    pub(crate) const fn blinds_second_looks(self) -> bool {
        false
    }

    /// No mistake is planted.
    #[cfg(not(feature = "mutants"))]
    pub(crate) const fn is(self, _: Mutant) -> bool {
        false
    }
}

/// Counts of 0.00001 deg in a radian.
const COUNTS_PER_RAD: f64 = 1e5 * 180.0 / core::f64::consts::PI;

/// `heading` as [`Mutant::OverflowAfterLongRuns`] keeps it.
pub(crate) fn in_32_bits(heading_rad: f64) -> f64 {
    // Wraps, as an addition of counts would.
    let counts = libm::round(heading_rad * COUNTS_PER_RAD) as i64 as i32;
    f64::from(counts) / COUNTS_PER_RAD
}

#[cfg(all(test, feature = "mutants"))]
mod tests;
