//! Unnamed shapes: splines, hinges, bumps and sigmoids of a driver, surfaces over two, steps and periods in time.

use super::library::OPEN;
use super::names::acts;
use super::{Candidate, Family};
use crate::dataset::Role;
use crate::model::{Acts, Driver, Form, Shape, Wrap, exposure, quantile_knots, see};
use crate::problem::{Block, Channels};
use crate::robust;

/// Knots of a spline.
const KNOTS: usize = 8;
/// Knots of a surface along each axis.
const SURFACE_KNOTS: usize = 4;
/// Places where a hinge or a bump is tried.
const PLACES: usize = 12;
/// A driver with fewer distinct values is not continuous.
const DIFFERENT_MIN: usize = 5;

/// Drivers of smooth functions. Time is excluded: warm-up, ageing and jumps have their own forms, and any other
/// function of time only states when the run was made.
fn drivers(block: &Block, channels: &Channels) -> Vec<Driver> {
    let mut found = Vec::new();
    for channel in &channels.channels {
        match channel.role {
            Role::Heading
            | Role::Duration
            | Role::Reference
            | Role::ReferenceRate
            | Role::GyroRate
            | Role::GyroCounts
            | Role::GyroAngleIncrement => {}
            _ => {
                found.push(Driver::plain(&channel.name));
                if channel.role == Role::Temperature {
                    found.push(Driver::new(Wrap::RateOf, &channel.name));
                }
            }
        }
    }
    if !channels.rotation.is_empty() && !block.is_blind {
        found.push(Driver::plain(&channels.rotation_name));
    }
    found
}

/// Whether values cover most of the range. Two rates, one per direction, are not a continuous driver.
fn fills_its_range(values: &[f64]) -> bool {
    const PARTS: usize = 10;
    let (low, high) = robust::ends(values.iter().copied());
    let mut counts = [0_usize; PARTS];
    for value in values {
        let part = (PARTS as f64 * (value - low) / (high - low)) as usize;
        counts[part.min(PARTS - 1)] += 1;
    }
    counts.iter().filter(|count| **count * 200 >= values.len()).count() >= DIFFERENT_MIN
}

/// The driver's part of a name.
fn word(driver: &Driver) -> String {
    match driver.wrap {
        Wrap::RateOf => format!("rate_of_{}", driver.field),
        _ => driver.field.clone(),
    }
}

/// Every smooth function of one driver.
pub fn smooth(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let mut found = Vec::new();
    for driver in drivers(block, channels) {
        let Some(values) = see(channels, &driver, &Vec::new()) else {
            continue;
        };
        let knots = quantile_knots(&values, KNOTS);
        if knots.len() < DIFFERENT_MIN || !fills_its_range(&values) {
            continue;
        }
        // A drift over the rate of turning is a scale of turns that varies with it.
        let turns_twice =
            |on: Acts| on == Acts::Curvature && driver.field == channels.rotation_name;
        let is_open = |on: &Acts| {
            exposure(block, *on).is_some()
                && !turns_twice(*on)
                && !is_by_a_chosen_zero(channels, *on, &driver)
        };
        for on in OPEN.into_iter().filter(is_open) {
            let name = format!("{}_shape_over_{}", acts(on), word(&driver));
            let mut shape = Shape::new(&name, on, driver.clone(), Form::Spline).unnamed();
            shape.knots.clone_from(&knots);
            found.push(Candidate { shape, family: Family::Smooth });
        }
    }
    found
}

/// Whether a scale error over what the sensor measures would depend on where its zero is, as that of an angle, a length or a
/// temperature does. The same curve is an error of the bias there.
fn is_by_a_chosen_zero(channels: &Channels, on: Acts, driver: &Driver) -> bool {
    on == Acts::Scale
        && !channels.rotation_has_zero()
        && *driver == Driver::plain(&channels.rotation_name)
}

/// Hinges, bumps and sigmoids of one driver.
pub fn narrow_on(channels: &Channels, on: Acts, driver: &Driver) -> Vec<Candidate> {
    let Some(values) = see(channels, driver, &Vec::new()) else {
        return Vec::new();
    };
    if !fills_its_range(&values) || is_by_a_chosen_zero(channels, on, driver) {
        return Vec::new();
    }
    let places = quantile_knots(&values, PLACES);
    let Some((first, last)) = places.first().zip(places.last()) else {
        return Vec::new();
    };
    let span = last - first;
    let mut found = Vec::new();
    let mut push = |form: Form, what: &str, numbers: &[(&str, f64)]| {
        let name = format!("{}_{what}_over_{}", acts(on), word(driver));
        let mut shape = Shape::new(&name, on, driver.clone(), form).unnamed();
        for (name, value) in numbers {
            shape.set(name, *value);
        }
        found.push(Candidate { shape, family: Family::Narrow });
    };
    for &place in &places[1..places.len() - 1] {
        push(Form::Hinge, "hinge", &[("at", place)]);
        for share in [0.05, 0.15] {
            push(Form::Bump, "bump", &[("centre", place), ("width", share * span)]);
        }
        push(Form::Tanh, "sigmoid", &[("centre", place), ("width", 0.1 * span)]);
    }
    found
}

/// Every product of two channels, each with its own zero: the simplest function of both.
pub fn products(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let plain: Vec<(Driver, f64)> = drivers(block, channels)
        .into_iter()
        .filter(|driver| driver.wrap == Wrap::Plain && driver.field != channels.rotation_name)
        .filter_map(|driver| {
            let values = see(channels, &driver, &Vec::new())?;
            let middle = values.iter().sum::<f64>() / values.len().max(1) as f64;
            fills_its_range(&values).then_some((driver, middle))
        })
        .collect();
    let mut found = Vec::new();
    for (i, (a, origin)) in plain.iter().enumerate() {
        for (b, origin_2) in &plain[i + 1..] {
            for on in OPEN.into_iter().filter(|on| exposure(block, *on).is_some()) {
                let name = format!("{}_product_of_{}_and_{}", acts(on), word(a), word(b));
                let mut shape = Shape::new(&name, on, a.clone(), Form::Product).unnamed();
                shape.drivers.push(b.clone());
                let shape = shape.with("origin", *origin).with("origin_2", *origin_2);
                found.push(Candidate { shape, family: Family::Pair });
            }
        }
    }
    found
}

/// Every function of two drivers.
pub fn pairs(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let drivers: Vec<(Driver, Vec<f64>)> = drivers(block, channels)
        .into_iter()
        .filter_map(|driver| {
            let values = see(channels, &driver, &Vec::new())?;
            let knots = quantile_knots(&values, SURFACE_KNOTS);
            (knots.len() == SURFACE_KNOTS && fills_its_range(&values)).then_some((driver, knots))
        })
        .collect();
    let mut found = Vec::new();
    for (i, (a, knots)) in drivers.iter().enumerate() {
        for (b, knots_2) in &drivers[i + 1..] {
            if a.field == b.field {
                continue;
            }
            for on in OPEN.into_iter().filter(|on| exposure(block, *on).is_some()) {
                let name = format!("{}_surface_over_{}_and_{}", acts(on), word(a), word(b));
                let mut shape = Shape::new(&name, on, a.clone(), Form::Surface).unnamed();
                shape.drivers.push(b.clone());
                shape.knots.clone_from(knots);
                shape.knots_2.clone_from(knots_2);
                found.push(Candidate { shape, family: Family::Pair });
            }
        }
    }
    found
}

/// Number of times at which a step is tried.
const MOMENTS: usize = 48;
/// A step must leave this share of the rows on each side.
const MARGIN: f64 = 0.02;

/// Steps in time.
pub fn steps(block: &Block, channels: &Channels) -> Vec<Candidate> {
    let mut times: Vec<f64> = block.rows.iter().map(|&row| channels.time[row]).collect();
    times.sort_by(f64::total_cmp);
    let n = times.len();
    let mut found = Vec::new();
    for i in 0..MOMENTS {
        let share = MARGIN + (1.0 - 2.0 * MARGIN) * i as f64 / (MOMENTS - 1) as f64;
        let at = times[((n - 1) as f64 * share) as usize];
        for on in OPEN.into_iter().filter(|on| exposure(block, *on).is_some()) {
            let driver = Driver::new(Wrap::Step, &channels.time_name);
            let shape = Shape::new(&format!("{}_step", acts(on)), on, driver, Form::Step);
            found.push(Candidate { shape: shape.with("at", at), family: Family::Step });
        }
    }
    found
}

/// A term with a period.
pub fn periodic(on: Acts, channels: &Channels, period: f64) -> Candidate {
    let driver = Driver::new(Wrap::Periodic, &channels.time_name);
    let shape = Shape::new(&format!("{}_periodic", acts(on)), on, driver, Form::Periodic);
    Candidate { shape: shape.with("period", period), family: Family::Periodic }
}
