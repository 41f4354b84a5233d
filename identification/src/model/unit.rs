//! Units of the numbers of a term.
//!
//! A place on the axis of a field is in the field's own unit, a difference along it in the unit of differences: a
//! temperature is in `Cel`, the width of a bump over it in `K`.

use super::see::{Field, fixed_or};
use super::{Acts, Driver, Form, LATE_SHARE, Shape, Wrap, field};
use crate::problem::{Channels, DisplayUnit};
use crate::units::per;

/// Unit of a driver's differences, as written and in SI.
pub fn difference_unit(channels: &Channels, driver: &Driver) -> DisplayUnit {
    unit(channels, driver, crate::dataset::Unit::difference_text)
}

/// Unit of places on the axis of the `which`th driver of `shape`, as written and in SI. A rate of change and the
/// distance of a play from its input are differences.
pub fn place_unit(channels: &Channels, shape: &Shape, which: usize) -> DisplayUnit {
    let Some(driver) = shape.drivers.get(which) else {
        return DisplayUnit::new(channels.time_unit.text(), 1.0);
    };
    let is_difference = match driver.wrap {
        Wrap::RateOf => true,
        Wrap::BranchOf => fixed_or(&shape.fixed, "through", 0.0) == 0.0,
        _ => false,
    };
    if is_difference {
        difference_unit(channels, driver)
    } else {
        unit(channels, driver, crate::dataset::Unit::text)
    }
}

fn unit(
    channels: &Channels,
    driver: &Driver,
    text: impl Fn(crate::dataset::Unit) -> &'static str,
) -> DisplayUnit {
    let plain = match field(channels, driver) {
        Some(Field::Rotation) => {
            DisplayUnit::new(channels.rotation_unit.text(), channels.rotation_unit.si())
        }
        Some(Field::Channel(channel)) => DisplayUnit::new(text(channel.unit), channel.unit.si()),
        Some(Field::Time) => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Some(Field::Direction) | None => DisplayUnit::one(),
    };
    match driver.wrap {
        Wrap::RateOf => DisplayUnit::new(&per(&plain.text, channels.time_unit.text()), plain.si),
        Wrap::Sign => DisplayUnit::one(),
        _ => plain,
    }
}

/// Unit of a number of `shape` that is not a coefficient.
pub fn fixed_unit(shape: &Shape, channels: &Channels, name: &str) -> DisplayUnit {
    let time = DisplayUnit::new(channels.time_unit.text(), 1.0);
    match name {
        "time_constant" | "delay" => time,
        "stretch" | "through" | LATE_SHARE => DisplayUnit::one(),
        "origin" | "at" | "centre" | "seen_from" | "seen_to" => place_unit(channels, shape, 0),
        "origin_2" | "seen_from_2" | "seen_to_2" => place_unit(channels, shape, 1),
        _ => shape.drivers.first().map_or(time, |driver| difference_unit(channels, driver)),
    }
}

/// Unit of the coefficients of a shape, where a term's own unit is `unit`.
pub fn coefficient_unit(shape: &Shape, channels: &Channels, unit: &DisplayUnit) -> DisplayUnit {
    let drivers: Vec<DisplayUnit> =
        shape.drivers.iter().map(|driver| difference_unit(channels, driver)).collect();
    let over = |power: i32| {
        let Some(driver) = drivers.first() else {
            return unit.clone();
        };
        let text = match (power, driver.text.contains('/')) {
            (_, _) if driver.text == "1" => "1".to_owned(),
            (1, _) => driver.text.clone(),
            (_, true) => format!("({})^{power}", driver.text),
            (_, false) => format!("{}^{power}", driver.text),
        };
        let written = if text.starts_with('(') {
            format!("{}/{text}", unit.text)
        } else {
            per(&unit.text, &text)
        };
        DisplayUnit::new(&written, unit.si / driver.si.powi(power))
    };
    match shape.form {
        Form::Linear | Form::Hinge => over(1),
        Form::Quadratic => over(2),
        Form::Cubic => over(3),
        Form::Product => {
            let first = over(1);
            drivers.get(1).map_or(first.clone(), |second| {
                DisplayUnit::new(&per(&first.text, &second.text), first.si / second.si)
            })
        }
        Form::Delay if shape.acts == Acts::Clock => DisplayUnit::one(),
        Form::Delay => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Form::DeadZone | Form::Saturation => DisplayUnit::one(),
        _ => unit.clone(),
    }
}
