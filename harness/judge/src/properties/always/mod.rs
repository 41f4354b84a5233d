//! One judge per always-property.

mod done;
mod finite;
mod fresh;
mod limits;
mod loss;
mod pose_write;
mod recovery;
mod silent;

use super::senses::{Fact, Senses, Topic};
use super::verdict::Judgement;
use super::{Always, Limits};
use dyn_clone::DynClone;
use std::fmt::Debug;

/// Judges one property during a run.
pub(super) trait Judge: Debug + DynClone + Send {
    /// The topics that it subscribes to.
    fn hears(&self) -> &'static [Topic];

    /// Judges a fact.
    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement);
}

dyn_clone::clone_trait_object!(Judge);

/// The judge of `property`. Values that the property does not state come from `limits`.
pub(super) fn judge(property: &Always, limits: &Limits) -> Box<dyn Judge> {
    match *property {
        Always::FreshHeading { age_max } => {
            Box::new(fresh::FreshHeading { age_max: age_max.unwrap_or(limits.heading_age_max) })
        }
        Always::StopsOnLoss { reaction_max, braking_min, steer_braking_min } => {
            Box::new(loss::StopsOnLoss::new(Limits {
                reaction_max: reaction_max.unwrap_or(limits.reaction_max),
                braking_min: braking_min.unwrap_or(limits.braking_min),
                steer_braking_min: steer_braking_min.unwrap_or(limits.steer_braking_min),
                ..*limits
            }))
        }
        Always::WithinLimits {
            speed_max,
            steer_rate_max,
            acceleration_max,
            steer_acceleration_max: steer,
        } => {
            let limits = Limits {
                speed_max: speed_max.unwrap_or(limits.speed_max),
                steer_rate_max: steer_rate_max.unwrap_or(limits.steer_rate_max),
                acceleration_max: acceleration_max.unwrap_or(limits.acceleration_max),
                steer_acceleration_max: steer.unwrap_or(limits.steer_acceleration_max),
                ..*limits
            };
            Box::new(limits::WithinLimits { limits, before: None })
        }
        Always::PoseWrittenAtRest {} => Box::new(pose_write::PoseWrittenAtRest::default()),
        Always::FiniteOutputs {} => Box::new(finite::FiniteOutputs::default()),
        Always::Recovers { within_max } => {
            Box::new(recovery::Recovers::new(within_max.unwrap_or(limits.recovery_max), limits))
        }
        Always::DoneIsDone { turn_max, distance_max } => Box::new(done::DoneIsDone {
            turn_max: turn_max.unwrap_or(limits.heading_band),
            distance_max: distance_max.unwrap_or(limits.distance_band),
            ..done::DoneIsDone::default()
        }),
        Always::NoSilentWrong { heading_max, position_max } => Box::new(silent::NoSilentWrong {
            heading_max: heading_max.unwrap_or(limits.heading_band),
            position_max: position_max.unwrap_or(limits.position_band),
            ..silent::NoSilentWrong::default()
        }),
    }
}
