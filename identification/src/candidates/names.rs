//! Standard names of effects, by what they act on and what drives them.

use crate::dataset::{Role, Unit};
use crate::model::{Acts, Form, UNEQUAL_WHEELS, Wrap};
use crate::problem::Channel;

/// The contract's word for what a term acts on.
pub(super) fn acts(acts: Acts) -> &'static str {
    match acts {
        Acts::Bias => "bias",
        Acts::Scale => "scale",
        Acts::Drive => "distance_scale",
        Acts::Turn => "turn_scale",
        Acts::Curvature => "curvature",
        Acts::Slip => "slip",
        _ => "error",
    }
}

/// Name of an effect over a field of the data.
pub(super) fn over(on: Acts, channel: &Channel, wrap: Wrap, form: Form) -> String {
    let standard = match (on, channel.role, channel.unit, wrap) {
        (Acts::Bias, Role::Temperature, _, Wrap::RateOf) => Some("shupe"),
        (Acts::Bias, Role::Temperature, _, Wrap::BranchOf) => Some("thermal_hysteresis"),
        (Acts::Bias, Role::Temperature, _, Wrap::LagOf) => Some("bias_temperature_lag"),
        (Acts::Scale, Role::Temperature, _, Wrap::LagOf) => Some("coil_temperature_lag"),
        (Acts::Scale, Role::Temperature, _, Wrap::BranchOf) => Some("scale_thermal_hysteresis"),
        (Acts::Bias, Role::Heading, _, Wrap::Harmonic(1)) => Some("magnetic_heading"),
        (Acts::Bias, Role::Heading, _, Wrap::Harmonic(2)) => {
            Some("magnetic_heading_second_harmonic")
        }
        (Acts::Curvature, Role::Heading, _, Wrap::Harmonic(1)) => Some("wheel_toe"),
        (Acts::Bias, Role::Auxiliary, Unit::Ampere, Wrap::Plain) => Some("magnetic_motor_current"),
        (Acts::Bias, Role::Auxiliary, Unit::Volt, Wrap::Plain) => Some("supply_voltage"),
        (Acts::Bias, Role::Auxiliary, Unit::MetrePerSecondSquared, Wrap::Plain) => {
            Some("acceleration")
        }
        (Acts::Bias, Role::Bias, _, Wrap::Plain) => Some("bias_correction"),
        _ => None,
    };
    let base = standard.map_or_else(
        || {
            let what =
                if channel.role == Role::Temperature { "temperature" } else { &channel.name };
            let wrapped = match wrap {
                Wrap::RateOf => format!("rate_of_{what}"),
                Wrap::LagOf => format!("lagged_{what}"),
                Wrap::BranchOf => format!("hysteresis_of_{what}"),
                Wrap::Harmonic(1) => "heading".to_owned(),
                Wrap::Harmonic(2) => "heading_second_harmonic".to_owned(),
                Wrap::Harmonic(order) => format!("heading_harmonic_{order}"),
                Wrap::Abs => format!("size_of_{what}"),
                Wrap::Sign => format!("sign_of_{what}"),
                _ => what.to_owned(),
            };
            format!("{}_over_{wrapped}", acts(on))
        },
        str::to_owned,
    );
    match form {
        Form::Quadratic => format!("{base}_quadratic"),
        Form::Cubic => format!("{base}_cubic"),
        _ => base,
    }
}

/// Name of a constant that the plain model lacks.
pub(crate) fn constant(on: Acts, is_steered: bool) -> &'static str {
    match on {
        Acts::Turn if is_steered => "effective_wheelbase",
        Acts::Curvature if is_steered => "steer_offset",
        Acts::Turn => "effective_track",
        Acts::Curvature => UNEQUAL_WHEELS,
        Acts::Drive => "distance_scale",
        Acts::Scale => "scale_factor",
        Acts::Reference => "reference_ahead_of_axle",
        _ => "bias",
    }
}
