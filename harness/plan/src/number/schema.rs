//! The same bounds as JSON Schemas, for editors: one function for each that parses a number, under the same name.

use super::{
    ACCELERATION_MAX_M_PER_S2, ANGLE_MAX_DEG, ANGULAR_ACCELERATION_MAX_DEG_PER_S2, DISTANCE_MAX_M,
    DURATION_MAX_S, RATE_MAX_DEG_PER_S, SENDING_PERIOD_MIN_S, SPEED_MAX_M_PER_S,
};
use schemars::{Schema, SchemaGenerator, json_schema};

/// A default in the unit of the file, without the rounding error of the conversion from radians.
pub(crate) fn written(value: f64) -> f64 {
    const PER_UNIT: f64 = 1e9;
    (value * PER_UNIT).round() / PER_UNIT
}

fn above_zero(maximum: f64) -> Schema {
    json_schema!({ "type": "number", "exclusiveMinimum": 0, "maximum": maximum })
}

fn either_way(maximum: f64) -> Schema {
    json_schema!({ "type": "number", "minimum": -maximum, "maximum": maximum })
}

fn either_way_not_zero(maximum: f64) -> Schema {
    json_schema!({ "type": "number", "minimum": -maximum, "maximum": maximum, "not": { "const": 0 } })
}

macro_rules! schemas {
    ($($name:ident = $schema:expr;)*) => {
        $(pub(crate) fn $name(_: &mut SchemaGenerator) -> Schema {
            $schema
        })*
    };
}

schemas! {
    finite = json_schema!({ "type": "number" });
    finite_option = json_schema!({ "type": "number" });
    positive = json_schema!({ "type": "number", "exclusiveMinimum": 0 });
    share = above_zero(1.0);
    duration = above_zero(DURATION_MAX_S);
    duration_option = above_zero(DURATION_MAX_S);
    duration_or_zero = json_schema!({ "type": "number", "minimum": 0, "maximum": DURATION_MAX_S });
    sending_period = json_schema!({ "type": "number", "anyOf": [
        { "const": 0 },
        { "minimum": SENDING_PERIOD_MIN_S, "maximum": DURATION_MAX_S }
    ] });
    turn = either_way_not_zero(ANGLE_MAX_DEG);
    heading = either_way(360.0);
    rate = above_zero(RATE_MAX_DEG_PER_S);
    rate_option = above_zero(RATE_MAX_DEG_PER_S);
    angular_acceleration = above_zero(ANGULAR_ACCELERATION_MAX_DEG_PER_S2);
    angular_acceleration_option = above_zero(ANGULAR_ACCELERATION_MAX_DEG_PER_S2);
    distance = either_way_not_zero(DISTANCE_MAX_M);
    length = above_zero(DISTANCE_MAX_M);
    length_option = above_zero(DISTANCE_MAX_M);
    coordinate = either_way(DISTANCE_MAX_M);
    speed = above_zero(SPEED_MAX_M_PER_S);
    speed_option = above_zero(SPEED_MAX_M_PER_S);
    acceleration_option = above_zero(ACCELERATION_MAX_M_PER_S2);
    angle_option = above_zero(360.0);
}
