//! Deliberately planted mistakes, one at a time. They measure how many faults of a controller a method finds.
//!
//! Each is at a place where a person would make it. Without the feature `mutants` none can be planted: [`Planted`] is
//! empty and answers no at compile time, so that the code is the same as without this module.

wire::words! {
    /// One mistake.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    #[cfg_attr(feature = "mutants", derive(serde::Serialize, serde::Deserialize))]
    #[cfg_attr(feature = "mutants", serde(rename_all = "kebab-case"))]
    pub enum Mutant {
        /// A silent gyro shows in health but aborts no motion.
        StaleHeading = "stale-heading",
        /// The calibration's correction has the wrong sign counter-clockwise.
        CcwSign = "ccw-sign",
        /// The base may be silent ten times as long in motion.
        WatchdogOffByTen = "watchdog-off-by-ten",
        /// A bias test checks neither the base nor the readings for rest.
        BiasTestWhileMoving = "bias-test-while-moving",
        /// The target heading of a turn is wrapped at 360 deg, the heading itself is not.
        WrapAt360 = "wrap-at-360",
        /// A gap in the gyro's sequence numbers goes unnoticed.
        MissedSequenceGap = "missed-sequence-gap",
        /// A straight line ends on arrival, and its pose is written, before the base has come to rest.
        PoseWrittenInMotion = "pose-written-in-motion",
        /// The heading is kept as a 32-bit count of 0.00001 deg, which overflows after 59 turns.
        OverflowAfterLongRuns = "overflow-after-long-runs",
        /// A rate beyond the gyro's range is integrated as if it were right.
        OverRangeIgnored = "over-range-ignored",
        /// A repeated sample is integrated twice.
        RepeatedSampleCounted = "repeated-sample-counted",
        /// Readings that are stuck in spite of noise are integrated.
        StuckReadingsBelieved = "stuck-readings-believed",
        /// A reading that the base cannot have reached is integrated.
        JumpBelieved = "jump-believed",
        /// Gyro and steering odometry are never compared.
        HeadingsNotCompared = "headings-not-compared",
        /// Any temperature is believed, even an impossible or frozen one.
        TemperatureBelieved = "temperature-believed",
        /// The odometer may lag behind the commands without limit during motion.
        LaggingOdometerBelieved = "lagging-odometer-believed",
        /// Rotation while the base reports that it stands is taken for bias.
        BumpIgnored = "bump-ignored",
        /// The bias is not checked at standstills.
        MovedBiasIgnored = "moved-bias-ignored",
        /// A bias test clears earlier faults of the heading.
        BiasTestForgives = "bias-test-forgives",
        /// The pose written to the base is always the origin.
        WrongPoseDownloaded = "wrong-pose-downloaded",
        /// Dead reckoning swaps left and right.
        MirroredReckoning = "mirrored-reckoning",
        /// The bias is always that of the last test, whatever the selected method.
        BiasMethodIgnored = "bias-method-ignored",
        /// The factors of the two directions are swapped.
        SwappedDirections = "swapped-directions",
        /// Only the first of the factors of Eq. 4 is used.
        FirstFactorAlone = "first-factor-alone",
        /// A straight line is driven at the base's top speed, whatever the command.
        SpeedIgnored = "speed-ignored",
        /// A turn runs at the base's top rate, whatever the command.
        RateIgnored = "rate-ignored",
        /// The heading drifts with the gyro at rest.
        HeadingNotHeld = "heading-not-held",
        /// Nothing shows in health.
        HealthSilent = "health-silent",
        /// A host clock that is set back is believed.
        HostClockBelieved = "host-clock-believed",
        /// After a stop the base is said to stand, whatever it reports.
        StopCalledRest = "stop-called-rest",
        /// The tolerance for the end of a straight line is ten times too wide.
        LooseStop = "loose-stop",
        /// A straight line does not steer.
        SteeringLoopOpen = "steering-loop-open",
        /// A straight line steers away from its heading.
        SteeringReversed = "steering-reversed",
        /// A turn ends by the base's odometry, whatever the heading source.
        TurnByOdometry = "turn-by-odometry",
        /// The pose is written to the base after straight lines alone.
        TurnNotWritten = "turn-not-written",
        /// An inch of the base's path is taken for 25 mm.
        ShortInch = "short-inch",
        /// A gyro with the opposite convention is read like any other.
        SignIgnored = "sign-ignored",
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
