//! Explains effects to readers who know the robot but not the statistics.
//!
//! Sources: IEEE Std 952 (fibre optic gyros), Borenstein and Feng 1996 (UMBmark: unequal wheels, effective track).

use identification::dataset::Kind;
use identification::finding::Effect;
use identification::model::{Driver, Wrap};

/// Name of an effect in running text, from its standard name.
pub(super) fn title(name: &str) -> String {
    let spaced = match name {
        "shupe" => "Shupe effect".to_owned(),
        other => other.replace('_', " "),
    };
    let mut rest = spaced.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}

/// Physical meaning of the effect in data of this kind.
pub(super) fn meaning(effect: &Effect, kind: Kind) -> String {
    let of_kind = |name: &str| match kind {
        Kind::Sensor => of_any_sensor(name).or_else(|| standard(name)),
        _ => standard(name),
    };
    for (suffix, bent) in [
        ("_quadratic", " It grows with the square of its cause."),
        ("_cubic", " It grows with the cube of its cause."),
    ] {
        if let Some(text) = effect.name.strip_suffix(suffix).and_then(of_kind) {
            return format!("{text}{bent}");
        }
    }
    of_kind(&effect.name).map_or_else(|| generic(effect, kind), str::to_owned)
}

/// Effects that a sensor of anything has as a gyro has them, without rotation.
fn of_any_sensor(name: &str) -> Option<&'static str> {
    Some(match name {
        "bias" => "The sensor reads something where there is nothing.",
        "bias_over_temperature" => "The offset depends on the temperature.",
        "thermal_hysteresis" => {
            "At one and the same temperature the offset differs by whether the sensor was warmed or cooled to it."
        }
        "bias_temperature_lag" => {
            "The offset follows a temperature that comes later than the one measured: the part that matters is not where \
             the thermometer is."
        }
        "scale_factor" => "It reads too much or too little by a factor.",
        "scale_over_temperature" => "The gain depends on the temperature.",
        "coil_temperature_lag" => {
            "The gain follows a temperature that comes later than the one measured: the part that matters is not where the \
             thermometer is."
        }
        "scale_thermal_hysteresis" => {
            "At one and the same temperature the gain differs by whether the sensor was warmed or cooled to it."
        }
        "supply_voltage" => "The offset follows the supply voltage. A steadier supply removes it.",
        "warm_up" => "The offset settles after power-up.",
        "scale_warm_up" => "The gain settles after power-up.",
        "offset_of_runs" => {
            "The offset is another in each run: it comes back differently after a start."
        }
        "bias_ageing" => "The offset drifts steadily over the record.",
        "scale_ageing" => "The gain drifts steadily over the record.",
        "direction_asymmetry" => "Positive and negative values are read with a gain each.",
        "bias_over_direction" => "The offset differs between positive and negative values.",
        "scale_over_rate" => "The gain depends on the value: the response is not a straight line.",
        "dead_zone" => "Small values are not seen at all.",
        "delay" => {
            "The sensor tells what was some time ago: its data and the reference are shifted."
        }
        "bandwidth" => "The sensor follows quick changes late and softened, as a low-pass does.",
        _ => return None,
    })
}

fn standard(name: &str) -> Option<&'static str> {
    Some(match name {
        "shupe" => {
            "While the temperature changes, the fibre coil is heated unevenly; light that runs round it \
             both ways then sees different lengths, and the gyro takes that for a rotation. At constant \
             temperature the effect is gone."
        }
        "bias_over_temperature" => {
            "What the gyro shows at rest depends on its temperature. Correct the bias by temperature, or \
             measure it anew when the temperature has changed."
        }
        "thermal_hysteresis" => {
            "At one and the same temperature the bias differs by whether the gyro was warmed or cooled \
             to it."
        }
        "bias_temperature_lag" => {
            "The bias follows a temperature that comes later than the one measured: the part that matters \
             is not where the thermometer is."
        }
        "scale_over_temperature" => {
            "A turn reads longer or shorter as the gyro warms: its scale factor depends on temperature."
        }
        "coil_temperature_lag" => {
            "The scale factor follows the temperature of the coil, which comes later than that of the \
             thermometer: the coil takes time to warm through."
        }
        "scale_thermal_hysteresis" => {
            "At one and the same temperature the scale factor differs by whether the gyro was warmed or \
             cooled to it."
        }
        "magnetic_heading" | "magnetic_heading_second_harmonic" => {
            "The bias depends on which way the device points, as it does where a magnetic field, such as \
             the Earth's, acts on the light in the coil (Faraday effect)."
        }
        "scale_over_heading" | "scale_over_heading_second_harmonic" => {
            "A turn reads longer or shorter by where it begins and ends. The device may do that, or the table whose \
             own angle errs over its turn: these data do not tell the two apart, and whole turns show neither."
        }
        "magnetic_motor_current" => {
            "The current of a motor makes a magnetic field, which shifts the bias. Distance or a shield \
             between motor and gyro helps."
        }
        "supply_voltage" => "The bias follows the supply voltage. A steadier supply removes it.",
        "acceleration" => "The gyro takes acceleration, or tilt against gravity, for rotation.",
        "bias_correction" => {
            "The bias that was subtracted does not cancel the true one in full: what is left goes with it."
        }
        "warm_up" => {
            "The bias settles after power-up. Wait a few time constants before the bias is measured."
        }
        "scale_warm_up" => "The scale factor settles after power-up.",
        "bias_ageing" => "The bias drifts steadily over the record.",
        "scale_ageing" => "The scale factor drifts steadily over the record.",
        "tyre_wear" => "Distances drift steadily over the record, as when a tyre wears or warms.",
        "direction_asymmetry" => {
            "Turns to the left and to the right read differently: each direction has its own scale factor."
        }
        "turn_asymmetry" => "The robot turns differently to the left than to the right.",
        "bias_over_direction" => "The bias differs between turns to the left and to the right.",
        "scale_over_rate" | "turn_over_rate" => {
            "The scale factor depends on how fast it turns: the response is not a straight line."
        }
        "misaligned_axis" => {
            "What another axis measures leaks in: the sensitive axes are not at right angles, or the sensor is tilted in \
             its mount."
        }
        "dead_zone" => "Slow rotation is not seen at all.",
        "saturation" => {
            "What is beyond the range of the sensor is cut off: readings at its end say no more."
        }
        "rounding" => {
            "Readings come in steps that are coarser than their noise: what is smaller than a step does not show in one \
             reading."
        }
        "random_walk" => {
            "The error wanders by small steps that stay, farther the longer one waits. No model foresees it: a bias test \
             just before takes off what has come so far."
        }
        "slow_noise" => {
            "The error wanders. The record is too short to say whether it ever comes back. No model foresees it: a bias \
             test just before takes off what has come so far."
        }
        "correlated_noise" => {
            "The error wanders and comes back after some time. No model foresees it: a bias test just before takes off what \
             lasts for longer than until it is used."
        }
        "delay" => {
            "The gyro tells what happened some time ago: its data and the reference are shifted."
        }
        "bandwidth" => {
            "The gyro follows quick changes of the rate late and softened, as a low-pass does."
        }
        "sample_clock" => {
            "The clock of the samples runs at another speed than that of the reference."
        }
        "slip" => {
            "Wheels slip when the robot speeds up or brakes: they turn further than it moves."
        }
        "effective_track" => {
            "The robot turns less far or farther than its wheels say, as if they were further apart or closer than assumed: \
             a wheel touches the ground over a width, not at a point."
        }
        "effective_wheelbase" => {
            "The robot turns as if the steered wheel were further from the axle or closer to it than assumed."
        }
        "steer_offset" => "The steered wheel does not stand straight where its angle reads zero.",
        "steer_scale" => "The steering angle reads more or less than the wheel turns.",
        "reference_heading_offset" => {
            "The reference is turned in its mount: a straight drive looks askew to it."
        }
        "reference_left_of_axle" => "The reference is not mounted in the middle of the robot.",
        "exchanged_wheels" => "The left wheel is read as the right one.",
        "wrong_axis" => "The axes of the sensor and of the reference are named unlike.",
        "reversed_sign" => "It counts backwards: its wires or its axis are the other way round.",
        "creep" => {
            "The sensor gives way slowly under what it measures, and comes back as slowly afterwards."
        }
        "unequal_wheels" => {
            "The robot bends to one side while it drives straight, as with wheels of unequal diameter."
        }
        "wheel_size" => {
            "Distances and turns read long or short by one factor: the wheels are larger or smaller than assumed."
        }
        "right_wheel" | "left_wheel" => {
            "One wheel is larger or smaller than assumed: distances read long or short, and the robot bends to one side."
        }
        "wheel_toe" => {
            "The bend while driving straight depends on where the wheels are steered to: they are not all \
             parallel."
        }
        "drive_to_steer_leakage" => {
            "Driving turns the steering a little: the two are not decoupled."
        }
        "distance_scale" => {
            "Distances read long or short by a factor: the wheel radius is not as assumed."
        }
        "scale_factor" => "Rotation reads long or short by a factor.",
        "bias" => "The gyro shows a rotation at rest.",
        _ => return None,
    })
}

fn generic(effect: &Effect, kind: Kind) -> String {
    let whence = if effect.known { "" } else { "No standard effect has this shape. " };
    let causes: Vec<String> = effect.drivers.iter().map(|text| cause(text)).collect();
    let on = match (kind, effect.term.as_str()) {
        (Kind::Sensor, "bias") => "adds to what is read, however large that is",
        (Kind::Sensor, "scale") => "changes how much of what is measured is read",
        (_, term) => acts(term),
    };
    match causes.is_empty() {
        true => format!("{whence}It {on}, always alike."),
        false => format!("{whence}It {on}; by how much depends on {}.", causes.join(" and on ")),
    }
}

/// What a term does to the measurement, as a continuation of "it".
fn acts(term: &str) -> &'static str {
    match term {
        "bias" => "adds to the rotation that is read, whether the device turns or not",
        "scale" => "changes how much a rotation reads",
        "delay" => "shifts what is read in time",
        "clock" => "stretches time",
        "axis" => "lets rotation about another axis in",
        "drive" => "changes how much a distance reads",
        "turn" => "changes how far the robot turns",
        "curvature" => "bends the path while the robot drives straight",
        "slip" => "lets wheels turn further than the robot moves",
        "reference" => "changes what the reference reads",
        _ => "changes what is read",
    }
}

pub(super) fn cause(text: &str) -> String {
    let Some(Driver { wrap, field }) = Driver::parse(text) else {
        return text.to_owned();
    };
    match wrap {
        Wrap::Plain | Wrap::Trend => field,
        Wrap::RateOf => format!("how fast {field} changes"),
        Wrap::LagOf => format!("{field} as it was a while ago"),
        Wrap::BranchOf => format!("whether {field} last rose or fell"),
        Wrap::Abs => format!("the size of {field}"),
        Wrap::Sign => format!("the sign of {field}"),
        Wrap::Harmonic(1) => format!("{field}, once per turn"),
        Wrap::Harmonic(2) => format!("{field}, twice per turn"),
        Wrap::Harmonic(order) => format!("{field}, {order} times per turn"),
        Wrap::Step => format!("a moment in {field}"),
        Wrap::Periodic => format!("{field}, again and again"),
    }
}

/// Describes a driver for an axis, where times and angles are drawn as they are.
pub(super) fn axis_name(text: &str) -> String {
    let Some(Driver { wrap, field }) = Driver::parse(text) else {
        return text.to_owned();
    };
    match wrap {
        Wrap::RateOf => format!("rate of {field}"),
        Wrap::LagOf => format!("lagged {field}"),
        Wrap::BranchOf => format!("branch of {field}"),
        Wrap::Abs => format!("size of {field}"),
        Wrap::Sign => format!("sign of {field}"),
        _ => field,
    }
}

#[cfg(test)]
mod tests {
    use super::{axis_name, cause, meaning, title};
    use crate::report::identification::samples::effect;
    use identification::dataset::Kind;

    #[test]
    fn standard_effects_have_a_meaning_of_their_own() {
        assert!(
            meaning(&effect("shupe", &["rate_of(temperature)"]), Kind::Series)
                .contains("fibre coil")
        );
        let bent =
            meaning(&effect("bias_over_temperature_quadratic", &["temperature"]), Kind::Turns);
        assert!(bent.contains("at rest") && bent.ends_with("the square of its cause."));
    }

    #[test]
    fn a_sensor_of_anything_does_not_turn() {
        let names = ["bias", "bias_over_temperature", "delay", "bandwidth", "dead_zone"];
        let mut said: Vec<String> =
            names.iter().map(|name| meaning(&effect(name, &[]), Kind::Sensor)).collect();
        let mut odd = effect("bias_bump_over_sun", &["sun"]);
        odd.known = false;
        said.push(meaning(&odd, Kind::Sensor));
        for text in said {
            assert!(!["gyro", "rotation", "turn"].iter().any(|word| text.contains(word)), "{text}");
        }
    }

    #[test]
    fn any_other_is_said_by_what_it_acts_on_and_what_drives_it() {
        let mut odd = effect("bias_bump_over_sun", &["lag_of(sun)", "rate_of(rain)"]);
        odd.known = false;
        assert_eq!(
            meaning(&odd, Kind::Series),
            "No standard effect has this shape. It adds to the rotation that is read, whether the \
             device turns or not; by how much depends on sun as it was a while ago and on how fast \
             rain changes."
        );
        assert_eq!(cause("nonsense("), "nonsense(");
        assert_eq!(axis_name("rate_of(coil)"), "rate of coil");
        assert_eq!(axis_name("trend(time)"), "time");
        assert_eq!(title("warm_up"), "Warm up");
        assert_eq!(title(""), "");
    }
}
