//! Causes in sentences, as one engineer would write them to another.

use super::delay::{delay, is_delay};
use super::phrases::{
    is_in_rows, number, of_axis, plain, quantity, seen, subject, time, why_it_drifts, with_unit,
};
use super::polynomial::is_polynomial;
use crate::dataset::Drive;
use crate::finding::Effect;
use crate::model::{ONE_WHEEL, WHEEL_SIZE};
use crate::units::{lasting, short, si_factor};

/// A sentence for each cause, of a robot driven so. Late axes share one delay.
pub(super) fn causes(effects: &[Effect], drive: Option<Drive>) -> Vec<String> {
    let late: Vec<&Effect> = effects.iter().filter(|effect| is_delay(effect)).collect();
    let late_together = (late.len() > 1).then(|| delay(&late)).flatten();
    effects
        .iter()
        .filter_map(|effect| {
            if let Some(sentence) = &late_together
                && is_delay(effect)
            {
                return std::ptr::eq(effect, late[0]).then(|| sentence.clone());
            }
            if is_polynomial(effect) {
                return Some(format!(
                    "{} changes with {} as a polynomial of order {}.",
                    subject(effect),
                    seen(effect, 0),
                    if effect.form == "cubic" { 3 } else { 2 }
                ));
            }
            Some(cause(effect, drive))
        })
        .collect()
}

/// A sentence for what the package states wrongly about a field.
fn set_right(effect: &Effect) -> Option<String> {
    let is_of_field = effect.form == "constant" && effect.drivers.len() == 1;
    let field = effect.drivers.first().filter(|_| is_of_field)?;
    let value = effect.parameters.first()?.value;
    let unit = &effect.parameters.first()?.unit;
    let side = if value > 0.0 { "left" } else { "right" };
    let size = quantity(value.abs(), unit);
    Some(match effect.name.as_str() {
        "reversed_sign" => format!("{field} has the wrong sign."),
        "exchanged_wheels" => format!("The wheels are exchanged: {field} is the other one."),
        "exchanged_axes" => format!("The axes of the reference are exchanged: {field} is y."),
        "added_up" => {
            format!("{field} adds up from the beginning of a run; its file says otherwise.")
        }
        "mean_speed" => {
            "The speeds of its wheels are means since the row before, not those of the moment."
                .to_owned()
        }
        "encoder_decoding" => {
            format!(
                "The edges of the encoder count otherwise: {field} is {} times what it must be.",
                short(value)
            )
        }
        "wrong_unit" => format!("{field} is {} times what it must be in its unit.", short(value)),
        name if name.ends_with("for_radians") || name.ends_with("for_degrees") => {
            format!("{field} is in another unit than its file says: {}.", plain(name))
        }
        "reference_heading_offset" => {
            format!("The reference looks {size} to the {side} of where the robot drives.")
        }
        "reference_left_of_axle" => {
            format!("The reference sits {size} to the {side} of the middle of the axle.")
        }
        "steer_scale" => {
            format!("The wheel is steered by {} times what {field} says.", short(value))
        }
        "steer_offset" => format!("The wheel stands {size} to the {side} where {field} says zero."),
        "wrong_axis" => {
            format!("What is measured{} is the rotation that {field} has.", of_axis(effect))
        }
        _ => return None,
    })
}

/// Share by which what is lost beyond a limit may differ from all of it, by the scale and its own error.
const WHOLE: f64 = 0.3;
/// Error of turns below which a track is 1.00 times what the package says, in three digits.
const TRACK_SHOWS: f64 = 0.005;

/// A cause as a sentence.
fn cause(effect: &Effect, drive: Option<Drive>) -> String {
    let first = effect.parameters.first();
    let value = first.map_or(f64::NAN, |one| one.value);
    let size = first.map_or_else(String::new, with_unit);
    let unit = first.map_or("", |one| one.unit.as_str());
    let of = of_axis(effect);
    let percent = || short(100.0 * value.abs());
    let more_or_less =
        |more: &'static str, less: &'static str| if value > 0.0 { more } else { less };
    let is_constant = effect.form == "constant";
    if let Some(sentence) = set_right(effect) {
        return sentence;
    }
    match (effect.term.as_str(), effect.name.as_str()) {
        ("scale", "reversed_sign") => format!("What is measured{of} has the wrong sign."),
        ("scale", "wrong_unit" | "encoder_decoding") => {
            format!("What is measured{of} is {} times what it must be.", short(1.0 + value))
        }
        ("scale", name) if name.ends_with("for_radians") || name.ends_with("for_degrees") => {
            format!("What is measured{of} is in another unit than its file says: {}.", plain(name))
        }
        ("turn", "effective_wheelbase") => {
            format!(
                "The robot turns as if its wheelbase were {} times as long as the package says.",
                short(1.0 / (1.0 + value))
            )
        }
        ("turn", _) if is_constant && drive == Some(Drive::Synchro) => {
            let more = more_or_less("farther", "less far");
            format!("It turns {} % {more} than its steering says.", percent())
        }
        ("turn", _) if is_constant && value.abs() < TRACK_SHOWS => {
            let more = more_or_less("farther", "less far");
            format!("It turns {} % {more} than its wheels say.", percent())
        }
        ("turn", _) if is_constant && value > -1.0 => {
            format!(
                "The robot turns as if its wheels stood {} times as far apart as the package says.",
                short(1.0 / (1.0 + value))
            )
        }
        ("drive", name) if name == WHEEL_SIZE || ONE_WHEEL.contains(&name) => {
            let more = more_or_less("larger", "smaller");
            let which =
                if name == WHEEL_SIZE { "wheels are" } else { &format!("{} is", plain(name)) };
            format!("Its {which} {} % {more} than the package says.", percent())
        }
        ("drive", _) if is_constant => {
            let more = more_or_less("farther", "less far");
            format!("It drives {} % {more} than the wheels say.", percent())
        }
        ("curvature", _) if is_constant => {
            format!(
                "It drifts to the {} by {} {unit} while it drives straight: {}.",
                more_or_less("left", "right"),
                short(value.abs()),
                why_it_drifts(effect, drive)
            )
        }
        ("reference", _) if is_constant => {
            format!(
                "The reference sits {} {unit} {} the axle.",
                short(value.abs()),
                more_or_less("ahead of", "behind")
            )
        }
        ("delay", "delay") => delay(&[effect]).unwrap_or_default(),
        ("delay", "bandwidth") => {
            format!("What is measured{of} follows with a time constant of {}.", lasting(value))
        }
        ("clock", _) => {
            let fast = short(1e6 * value);
            format!("The clock of what is measured{of} is off by {fast} parts in a million.")
        }
        ("axis", _) => {
            let share = value * si_factor(unit).unwrap_or(1.0);
            format!(
                "What is measured{of} has {} % of another axis ({}) in it.",
                short(100.0 * share.abs()),
                seen(effect, 0)
            )
        }
        ("dead_zone", _) => {
            format!("What is measured{of} is zero within {} of zero.", number(effect, "width"))
        }
        ("noise", "offset_of_runs") => {
            format!(
                "The offset of what is measured{of} differs from run to run by {size}, and stays within each."
            )
        }
        ("noise", "correlated_noise") => {
            let memory = time(effect, "correlation_time");
            format!("What is measured{of} wanders by {size} and comes back after about {memory}.")
        }
        ("noise", name) => {
            let after = first.map_or("", |one| one.name.as_str()).replace('_', " ");
            let how = if name == "random_walk" { "as a random walk does" } else { "slowly" };
            format!(
                "What is measured{of} wanders {how}: by {size} {after}, farther with the root of time."
            )
        }
        ("quantisation", _) => {
            format!("What is measured{of} is rounded to steps of {size}.")
        }
        ("saturation", _) if (value - 1.0).abs() > WHOLE => {
            let more = more_or_less("less", "more");
            let limit = number(effect, "limit");
            format!("What is measured{of} rises {} % {more} beyond {limit}.", percent())
        }
        ("saturation", _) => {
            let limits = effect.parameters.iter().filter(|one| one.name.ends_with("limit"));
            let known: Vec<String> =
                limits.filter(|one| one.standard_error.is_some()).map(with_unit).collect();
            format!("What is measured{of} is clipped at {}.", known.join(" and at "))
        }
        _ => by_form(effect, value, &size, unit),
    }
}

/// A cause by the form of its dependence alone.
fn by_form(effect: &Effect, value: f64, size: &str, unit: &str) -> String {
    let (subject, what) = (subject(effect), seen(effect, 0));
    match effect.form.as_str() {
        "constant" => format!("{subject} is off by {size}."),
        "linear" => format!("{subject} changes with {what}: {size}."),
        "quadratic" => format!("{subject} changes with the square of {what}: {size}."),
        "cubic" => format!("{subject} changes with the cube of {what}: {size}."),
        "product" => format!("{subject} changes with {what} times {}: {size}.", seen(effect, 1)),
        "exponential" => format!(
            "{subject} settles after the start: {size}, with a time constant of {}.",
            time(effect, "time_constant")
        ),
        "harmonic" | "periodic" => {
            let other = effect.parameters.get(1).map_or(0.0, |sin| sin.value);
            let amplitude = quantity(value.hypot(other), unit);
            let cycle = match effect.form.as_str() {
                "periodic" => format!("a period of {}", time(effect, "period")),
                _ => what,
            };
            format!("{subject} swings with {cycle}: amplitude {amplitude}.")
        }
        "step" => {
            let at = effect.parameters.iter().find(|one| one.name == "at");
            let at = at.map_or_else(String::new, |at| match is_in_rows(at) {
                true => format!(" at row {}", short(at.value)),
                false => format!(" at {} {}", short(at.value), at.unit),
            });
            format!("{subject} jumps by {size}{at}.")
        }
        _ => {
            let both = if effect.drivers.len() > 1 {
                format!("{what} and {}", seen(effect, 1))
            } else {
                what
            };
            format!("{subject} depends on {both}, in a way that has no name.")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::polynomial::join_powers;
    use super::{cause, causes};
    use crate::dataset::{Axis, Drive};
    use crate::finding::{Effect, Parameter};

    fn effect(name: &str, term: &str, form: &str, value: f64, unit: &str) -> Effect {
        Effect {
            name: name.to_owned(),
            known: true,
            term: term.to_owned(),
            axis: None,
            drivers: Vec::new(),
            form: form.to_owned(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: vec![Parameter {
                name: "value".to_owned(),
                value,
                standard_error: None,
                unit: unit.to_owned(),
                range: None,
            }],
            p_value: 0.0,
            held_out_before: 1.0,
            held_out_after: 0.5,
            rivals: Vec::new(),
        }
    }

    fn over(driver: &str, form: &str, value: f64, unit: &str) -> Effect {
        let drivers = vec![driver.to_owned()];
        Effect { drivers, axis: Some(Axis::Y), ..effect("any", "bias", form, value, unit) }
    }

    #[test]
    fn causes_are_said_as_an_engineer_says_them() {
        assert_eq!(
            cause(&effect("effective_track", "turn", "constant", -0.5, "1"), None),
            "The robot turns as if its wheels stood 2.00 times as far apart as the package says."
        );
        // Three digits of a track do not show it.
        assert_eq!(
            cause(&effect("effective_track", "turn", "constant", 2e-5, "1"), None),
            "It turns 0.00200 % farther than its wheels say."
        );
        let mut bent = effect("saturation", "saturation", "saturation", -0.79, "1");
        bent.parameters.push(Parameter {
            name: "limit".to_owned(),
            value: 52.3,
            unit: "V".to_owned(),
            ..bent.parameters[0].clone()
        });
        assert_eq!(cause(&bent, None), "What is measured rises 79.0 % more beyond 52.3 V.");
        // Wheels that are steered together have no distance that turns the robot.
        assert_eq!(
            cause(&effect("effective_track", "turn", "constant", -0.01, "1"), Some(Drive::Synchro)),
            "It turns 1.00 % less far than its steering says."
        );
        let drifts = |drive| cause(&effect("any", "curvature", "constant", -0.2, "deg/m"), drive);
        assert_eq!(
            [drifts(Some(Drive::Synchro)), drifts(Some(Drive::Differential))],
            ["its steering turns with the way", "the wheels are unequal"].map(|why| format!(
                "It drifts to the right by 0.200 deg/m while it drives straight: {why}."
            ))
        );
        assert_eq!(
            cause(&effect("delay", "delay", "delay", 0.00425, "s"), None),
            "What is measured comes 4.25 ms later than the reference."
        );
        // Later than any sensor.
        assert_eq!(
            cause(&effect("delay", "delay", "delay", -7682.4, "s"), None),
            "The clocks of what is measured and of the reference are 2.13 h apart: its time stamps come earlier."
        );
        assert_eq!(
            cause(&effect("bandwidth", "delay", "delay", 980.0, "s"), None),
            "What is measured follows with a time constant of 16.3 min."
        );
        assert_eq!(
            cause(&over("rate_of(coil)", "linear", 0.0123, "deg/s/(K/s)"), None),
            "The bias of axis y changes with the rate of change of coil: 0.0123 deg/s/(K/s)."
        );
        assert_eq!(
            cause(&over("harmonic_2(heading)", "harmonic", -3e-5, "rad/s"), None),
            "The bias of axis y swings with heading, 2 times a turn: amplitude 3.00e-5 rad/s."
        );
    }

    #[test]
    fn a_record_without_times_counts_in_rows() {
        let mut lags = over("lag_of(coil)", "linear", 0.1, "any");
        let constant = |name: &str, value, unit: &str| Parameter {
            name: name.to_owned(),
            value,
            unit: unit.to_owned(),
            ..lags.parameters[0].clone()
        };
        let (rows, seconds) =
            (constant("time_constant", 1299.0, "1"), constant("time_constant", 1299.0, "s"));
        let mut jumps = over("sample", "step", 0.1, "deg/h");
        jumps.parameters.push(constant("at", 4210.0, "1"));
        lags.parameters.push(rows);
        assert_eq!(
            causes(&[lags.clone(), jumps, effect("delay", "delay", "delay", 3.0, "1")], None),
            [
                "The bias of axis y changes with coil through a lag of 1299 rows: 0.100 any.",
                "The bias of axis y jumps by 0.100 deg/h at row 4210.",
                "What is measured comes 3.00 rows later than the reference.",
            ]
        );
        lags.parameters[1] = seconds;
        assert_eq!(
            cause(&lags, None),
            "The bias of axis y changes with coil through a lag of 21.6 min: 0.100 any."
        );
    }

    #[test]
    fn axes_that_are_late_together_have_one_delay() {
        let late = |axis, value| Effect {
            axis: Some(axis),
            ..effect("delay", "delay", "delay", value, "s")
        };
        let bias = over("coil", "linear", 0.1, "any");
        let all = [late(Axis::Z, 4.23e-3), bias, late(Axis::X, 4.24e-3), late(Axis::Y, 4.12e-3)];
        let found = causes(&all, None);
        assert_eq!(found.len(), 2);
        assert_eq!(
            found[0],
            "What is measured of axes z, x and y comes 4.12 to 4.24 ms later than the reference."
        );
        // Different delays stay separate.
        assert_eq!(causes(&[late(Axis::Z, 4e-3), late(Axis::X, -4e-3)], None).len(), 2);
    }

    #[test]
    fn powers_of_one_driver_are_one_polynomial() {
        let powers = ["linear", "quadratic", "cubic"].map(|form| over("coil", form, 0.1, "any"));
        let mut joined = powers.to_vec();
        join_powers(&mut joined);
        assert_eq!(
            causes(&joined, None),
            ["The bias of axis y changes with coil as a polynomial of order 3."]
        );
        assert_eq!(causes(&powers[..1], None).len(), 1);
        let two = [over("coil", "linear", 0.1, "any"), over("room", "quadratic", 0.1, "any")];
        assert_eq!(causes(&two, None).len(), 2);
    }
}
