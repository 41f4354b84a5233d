//! Properties: conditions that must hold throughout a run, and states that a run must reach. A campaign must reach them
//! in one of its runs.
//!
//! ```toml
//! [[property]]
//! name = "opens on over-voltage"
//! always = "cells.VoltageMax > 4.25 -> within 100 ms: manager.ContactorCommand == 0"
//!
//! [[property]]
//! sometimes = "manager.State == 3"
//!
//! [[property]]
//! always = { fresh_heading = { age_s_max = 0.16 } }
//! ```
//!
//! A text is a formula over signals of the rig, in the language of the crate `temporal`. Named properties are built in
//! and belong to the paper's robot; a limit that is left out comes from the bench (`judge::properties::Limits`).

use super::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::time::Span;
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Speed};

/// One `[[property]]` of a plan.
#[derive(Debug, Clone, PartialEq)]
pub enum Property {
    /// It must hold at every moment of every run.
    Always(Always),
    /// It must occur during a run, or in at least one run of a campaign.
    Sometimes(Sometimes),
    /// A formula of the plan.
    Stated(Stated),
}

/// The kind of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// It must hold at every moment.
    Always,
    /// It must occur: during a run, or in at least one run of a campaign.
    Sometimes,
}

/// A formula over signals of the rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stated {
    /// Its name; if the plan gives none, its text.
    pub name: String,
    /// When it must hold.
    pub kind: Kind,
    /// The text of the formula.
    pub formula: String,
}

/// What must hold at every moment.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Always {
    /// Nothing is told to move on a heading older than this.
    FreshHeading {
        /// Age of the last good gyro sample, s.
        #[serde(rename = "age_s_max", default, with = "number::Duration")]
        age_max: Option<Span>,
    },
    /// Who loses the gyro or the base stops: after the reaction time with at least these brakes.
    StopsOnLoss {
        /// From the last thing heard until the brakes bite, s.
        #[serde(rename = "reaction_s_max", default, with = "number::Duration")]
        reaction_max: Option<Span>,
        /// Deceleration on the way, m/s^2.
        #[serde(rename = "braking_m_per_s2_min", default, with = "number::Ramp")]
        braking_min: Option<Acceleration>,
        /// Deceleration of the steering, deg/s^2.
        #[serde(
            rename = "steer_braking_deg_per_s2_min",
            default,
            with = "number::AngularAcceleration"
        )]
        steer_braking_min: Option<AngularAcceleration>,
    },
    /// Neither what is commanded nor what is true goes beyond these.
    WithinLimits {
        /// Along the path, m/s.
        #[serde(rename = "speed_m_per_s_max", default, with = "number::Steady")]
        speed_max: Option<Speed>,
        /// Of the steering, deg/s.
        #[serde(rename = "steer_rate_deg_per_s_max", default, with = "number::Rate")]
        steer_rate_max: Option<AngularRate>,
        /// Speeding up, m/s^2.
        #[serde(rename = "acceleration_m_per_s2_max", default, with = "number::Ramp")]
        acceleration_max: Option<Acceleration>,
        /// Of the steering, speeding up, deg/s^2.
        #[serde(
            rename = "steer_acceleration_deg_per_s2_max",
            default,
            with = "number::AngularAcceleration"
        )]
        steer_acceleration_max: Option<AngularAcceleration>,
    },
    /// A pose is written to a base that stands.
    PoseWrittenAtRest {},
    /// No report holds a number that is none.
    FiniteOutputs {},
    /// Some time after the last fault is over, the controller works again or says that it does not.
    Recovers {
        /// From the end of the fault, s.
        #[serde(rename = "within_s_max", default, with = "number::Duration")]
        within_max: Option<Span>,
    },
    /// A mission that is called done, by a controller that calls itself well, was done; and a base that it says stands
    /// after a turn, a straight or a stop stands.
    DoneIsDone {
        /// True angle of a turn less the ordered one, deg.
        #[serde(rename = "turn_deg_max", default, with = "number::Angle")]
        turn_max: Option<Angle>,
        /// True length of a straight less the ordered one, m.
        #[serde(rename = "distance_m_max", default, with = "number::PathLength")]
        distance_max: Option<Length>,
    },
    /// Where the pose errs by more than this, health has said so before the step's end.
    NoSilentWrong {
        /// Of the heading since both poses were set right, deg.
        #[serde(rename = "heading_deg_max", default, with = "number::Angle")]
        heading_max: Option<Angle>,
        /// Of the position since then, m.
        #[serde(rename = "position_m_max", default, with = "number::PathLength")]
        position_max: Option<Length>,
    },
}

wire::words! {
    /// What a campaign must have reached at least once: states in which mistakes live.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, JsonSchema)]
    #[serde(rename_all = "snake_case")]
    pub enum Sometimes {
        /// A node left the bus (ISO 11898-1: transmit errors beyond 255).
        BusOff = "bus_off",
        /// A bias test was refused, or failed because the gyro was not at rest.
        BiasTestRefused = "bias_test_refused",
        /// Health has said that the gyro is silent.
        GyroSilent = "gyro_silent",
        /// Health has said that the gyro's data are not to be used.
        GyroFault = "gyro_fault",
        /// The gyro's decoder lost its place in the stream and found it again.
        Resynchronised = "resynchronised",
        /// Health has said that samples were lost.
        SamplesLost = "samples_lost",
        /// Health has said that a rate was beyond the gyro's range.
        OverRange = "over_range",
        /// Health has said that the clocks differ.
        ClockMismatch = "clock_mismatch",
        /// Health has said that the base is silent.
        BaseSilent = "base_silent",
        /// Health has said that the base's emergency stop is pressed, or a drive at fault.
        BaseNotReady = "base_not_ready",
        /// A mission ended because the base had stopped by itself.
        BaseStoppedItself = "base_stopped_itself",
        /// A mission was refused.
        MissionRefused = "mission_refused",
        /// A mission was broken off.
        MissionAborted = "mission_aborted",
        /// Health has said that the base did not take a pose.
        PoseNotWritten = "pose_not_written",
        /// Health has said that something overflowed.
        Overflow = "overflow",
        /// Health was worse than degraded, and became better.
        Recovered = "recovered",
    }
}

impl Property {
    /// Every property, each with the bench's limits.
    pub fn all() -> Vec<Self> {
        let always = Always::ALL.iter().map(|always| Self::Always(*always));
        let sometimes = Sometimes::ALL.iter().map(|sometimes| Self::Sometimes(*sometimes));
        always.chain(sometimes).collect()
    }

    /// As verdicts call it.
    pub fn name(&self) -> &str {
        match self {
            Self::Always(always) => always.name(),
            Self::Sometimes(sometimes) => sometimes.name(),
            Self::Stated(stated) => &stated.name,
        }
    }

    /// A formula that a plan states itself.
    pub const fn is_stated(&self) -> bool {
        matches!(self, Self::Stated(_))
    }

    /// When it must hold.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Always(_) => Kind::Always,
            Self::Sometimes(_) => Kind::Sometimes,
            Self::Stated(stated) => stated.kind,
        }
    }
}

impl Always {
    /// Every one, each with the bench's limits.
    pub const ALL: &[Self] = &[
        Self::FreshHeading { age_max: None },
        Self::StopsOnLoss { reaction_max: None, braking_min: None, steer_braking_min: None },
        Self::WithinLimits {
            speed_max: None,
            steer_rate_max: None,
            acceleration_max: None,
            steer_acceleration_max: None,
        },
        Self::PoseWrittenAtRest {},
        Self::FiniteOutputs {},
        Self::Recovers { within_max: None },
        Self::DoneIsDone { turn_max: None, distance_max: None },
        Self::NoSilentWrong { heading_max: None, position_max: None },
    ];

    /// As it is written.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::FreshHeading { .. } => "fresh_heading",
            Self::StopsOnLoss { .. } => "stops_on_loss",
            Self::WithinLimits { .. } => "within_limits",
            Self::PoseWrittenAtRest {} => "pose_written_at_rest",
            Self::FiniteOutputs {} => "finite_outputs",
            Self::Recovers { .. } => "recovers",
            Self::DoneIsDone { .. } => "done_is_done",
            Self::NoSilentWrong { .. } => "no_silent_wrong",
        }
    }
}
