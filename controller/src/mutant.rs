//! Mistakes that are planted on purpose, one at a time: what finds faults in controllers is measured by
//! whether it finds these.
//!
//! Each sits where a person would make it. Without the feature `mutants` none can be planted: [`Planted`]
//! holds nothing and says no, at compile time, and the code is what it would be without this module.

/// One mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "mutants", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "mutants", serde(rename_all = "kebab-case"))]
pub enum Mutant {
    /// A gyro that falls silent shows in health and breaks off no motion.
    StaleHeading,
    /// The calibration's correction is put on the wrong way counter-clockwise.
    CcwSign,
    /// The base may be silent ten times as long in motion.
    WatchdogOffByTen,
    /// A bias test asks neither the base nor the readings whether it is at rest.
    BiasTestWhileMoving,
    /// The heading that a turn is to reach is kept below 360 deg, the heading itself is not.
    WrapAt360,
    /// A gap in the gyro's running numbers goes unnoticed.
    MissedSequenceGap,
    /// A straight is over on arrival, and its pose written, before the base has come to rest.
    PoseWrittenInMotion,
    /// The heading is kept as a 32-bit count of 0.00001 deg, which overflows after 59 turns.
    OverflowAfterLongRuns,
    /// A rate beyond the gyro's range is integrated as if it were right.
    OverRangeIgnored,
    /// A sample that came twice is integrated twice.
    RepeatedSampleCounted,
    /// Readings that noise would change, and that stay the same, are integrated.
    StuckReadingsBelieved,
    /// A reading that no base could have turned to is integrated.
    JumpBelieved,
    /// Gyro and steering odometry are never compared.
    HeadingsNotCompared,
    /// Any temperature is believed, however wild, and one that is frozen.
    TemperatureBelieved,
    /// An odometer on its way may lag behind the orders as far as it likes.
    LaggingOdometerBelieved,
    /// What the gyro turns while the base says that it stands is taken for bias.
    BumpIgnored,
    /// A standstill is no occasion to look at the bias.
    MovedBiasIgnored,
    /// A bias test clears what was lost of the heading before it.
    BiasTestForgives,
    /// The pose that is written to the base is always the origin.
    WrongPoseDownloaded,
    /// Dead reckoning takes left for right.
    MirroredReckoning,
    /// The bias is that of the last test, whatever method was chosen.
    BiasMethodIgnored,
    /// The factors of the two directions are swapped.
    SwappedDirections,
    /// Of the factors of Eq. 4 the first alone is used.
    FirstFactorAlone,
    /// A straight is driven as fast as the base can, whatever was ordered.
    SpeedIgnored,
    /// A turn is as fast as the base can, whatever was ordered.
    RateIgnored,
    /// At rest the heading drifts as the gyro does.
    HeadingNotHeld,
    /// Nothing that is noticed shows in health.
    HealthSilent,
    /// The host's clock is believed where it is set back.
    HostClockBelieved,
}

#[cfg(feature = "mutants")]
impl Mutant {
    /// Every one.
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
    ];

    /// In words joined by hyphens.
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
        }
    }
}

/// Which mistake is planted here, if any.
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

    /// Is it this one?
    #[cfg(feature = "mutants")]
    pub(crate) const fn is(self, mutant: Mutant) -> bool {
        matches!(self.mutant, Some(planted) if planted as u8 == mutant as u8)
    }

    /// Is it one that a second look would find as well? What that look says would hide what the first lacks.
    #[cfg(feature = "mutants")]
    pub(crate) const fn blinds_second_looks(self) -> bool {
        matches!(
            self.mutant,
            Some(
                Mutant::WatchdogOffByTen
                    | Mutant::BiasTestWhileMoving
                    | Mutant::OverflowAfterLongRuns
                    | Mutant::OverRangeIgnored
                    | Mutant::RepeatedSampleCounted
            )
        )
    }

    /// There is none.
    #[cfg(not(feature = "mutants"))]
    pub(crate) const fn blinds_second_looks(self) -> bool {
        false
    }

    /// There is none.
    #[cfg(not(feature = "mutants"))]
    pub(crate) const fn is(self, _: Mutant) -> bool {
        false
    }
}

/// 0.00001 deg in a radian.
const COUNTS_PER_RAD: f64 = 1e5 * 180.0 / core::f64::consts::PI;

/// `heading` as [`Mutant::OverflowAfterLongRuns`] keeps it.
pub(crate) fn in_32_bits(heading_rad: f64) -> f64 {
    // Wraps, as an addition of counts would.
    let counts = libm::round(heading_rad * COUNTS_PER_RAD) as i64 as i32;
    f64::from(counts) / COUNTS_PER_RAD
}

#[cfg(all(test, feature = "mutants"))]
mod tests;
