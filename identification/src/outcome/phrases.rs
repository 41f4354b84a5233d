//! Phrases on an effect: the quantity that it changes, what it goes with, and its numbers.

use crate::dataset::Drive;
use crate::finding::{Effect, Parameter};
use crate::model::{Driver, Wrap};
use crate::units::{lasting, short};

pub(super) fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// The quantity that the effect changes.
pub(super) fn subject(effect: &Effect) -> String {
    let what = match effect.term.as_str() {
        "scale" => "scale factor",
        "drive" => "distance scale",
        "turn" => "scale of turns",
        "curvature" => "drift to the side",
        term => term,
    };
    format!("The {}{}", plain(what), of_axis(effect))
}

pub(super) fn of_axis(effect: &Effect) -> String {
    effect.axis.map_or(String::new(), |axis| format!(" of axis {axis:?}").to_lowercase())
}

/// Describes a driver of the effect.
pub(super) fn seen(effect: &Effect, at: usize) -> String {
    let Some(text) = effect.drivers.get(at) else { return "nothing".to_owned() };
    let Some(Driver { wrap, field }) = Driver::parse(text) else { return text.clone() };
    match wrap {
        Wrap::RateOf => format!("the rate of change of {field}"),
        Wrap::LagOf => {
            format!("{field} through a lag of {}", time(effect, "time_constant"))
        }
        Wrap::BranchOf => format!("{field} and where it came from (hysteresis)"),
        Wrap::Abs => format!("the size of {field}"),
        Wrap::Sign => format!("the sign of {field}"),
        Wrap::Harmonic(1) => format!("{field}, once a turn"),
        Wrap::Harmonic(count) => format!("{field}, {count} times a turn"),
        Wrap::Plain | Wrap::Step | Wrap::Periodic | Wrap::Trend => field,
    }
}

/// A number of the effect with its unit.
pub(super) fn number(effect: &Effect, name: &str) -> String {
    effect.parameters.iter().find(|one| one.name == name).map_or_else(String::new, with_unit)
}

/// A time of the effect.
pub(super) fn time(effect: &Effect, name: &str) -> String {
    let found = effect.parameters.iter().find(|one| one.name == name);
    found.map_or_else(String::new, |one| match is_in_rows(one) {
        true => format!("{} rows", short(one.value)),
        false => with_unit(one),
    })
}

/// Whether a time of an effect counts rows, as where the record has no times.
pub(super) fn is_in_rows(time: &Parameter) -> bool {
    time.unit == "1"
}

pub(super) fn with_unit(parameter: &Parameter) -> String {
    quantity(parameter.value, &parameter.unit)
}

pub(super) fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "1" => short(value),
        "s" => lasting(value),
        unit => format!("{} {unit}", short(value)),
    }
}

/// Why a robot that is driven so drifts while it drives straight.
pub(super) fn why_it_drifts(effect: &Effect, drive: Option<Drive>) -> String {
    let between = effect.parameters.iter().find(|one| one.name == "difference");
    match (drive, between) {
        (Some(Drive::Synchro), _) => "its steering turns with the way".to_owned(),
        (Some(Drive::Tricycle), _) => "its steering is off".to_owned(),
        (_, Some(between)) => {
            let more = if between.value > 0.0 { "larger" } else { "smaller" };
            let percent = short(100.0 * between.value.abs());
            format!("the right wheel is {percent} % {more} than the left one")
        }
        _ => "the wheels are unequal".to_owned(),
    }
}
