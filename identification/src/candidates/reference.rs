//! Errors of a sensor over the quantity that it measures.

use super::Family;
use super::library::{Builder, PLAYS, mean};
use crate::dataset::{Dimension, Role};
use crate::model::{Acts, Driver, Form, Shape, Wrap, narrowest_play};
use crate::robust;

/// Half widths of a hysteresis of the measured quantity, as multiples of the error.
const ERRORS_WIDE: [f64; 3] = [0.5, 1.0, 2.0];

impl Builder<'_> {
    /// Errors of a sensor over the quantity it measures: a curve, a hysteresis, cycles per turn.
    pub(super) fn over_reference(&mut self, on: Acts) {
        if on != Acts::Bias {
            return;
        }
        let name = &self.channels.rotation_name;
        let values = &self.channels.rotation;
        let (low, high) = robust::ends(values.iter().copied());
        let shape =
            |name_of: &str, wrap, form| Shape::new(name_of, on, Driver::new(wrap, name), form);
        let origin = mean(values);
        let mut found = vec![
            shape("nonlinearity", Wrap::Plain, Form::Quadratic).with("origin", origin),
            shape("nonlinearity_cubic", Wrap::Plain, Form::Cubic).with("origin", origin),
            shape("rate_dependence", Wrap::RateOf, Form::Linear),
        ];
        // A backlash is as wide as the error that it makes, however far the sensor travels.
        let error = robust::spread(&self.block.residual);
        let mut widths: Vec<f64> = ERRORS_WIDE.iter().map(|times| times * error).collect();
        widths.retain(|width| *width > 0.0 && *width < PLAYS[0] * (high - low));
        widths.extend(PLAYS.iter().map(|share| share * (high - low)));
        let least = narrowest_play(self.channels);
        for width in widths.into_iter().filter(|width| *width >= least) {
            let play = shape("hysteresis", Wrap::BranchOf, Form::Linear);
            found.push(play.with("half_width", width));
        }
        if self.channels.rotation_unit.dimension() != Dimension::Angle {
            for constant in self.time_constants() {
                let creep = shape("creep", Wrap::LagOf, Form::Linear).with("origin", origin);
                found.push(creep.with("time_constant", constant));
            }
        }
        let turns = self.channels.rotation_unit.dimension() == Dimension::Angle;
        for order in (1..=Wrap::HARMONICS).filter(|_| turns) {
            found.push(shape(&cycles(order), Wrap::Harmonic(order), Form::Harmonic));
        }
        for heading in self.channels.channels.iter().filter(|one| one.role == Role::Heading) {
            for order in 1..=Wrap::HARMONICS {
                let driver = Driver::new(Wrap::Harmonic(order), &heading.name);
                found.push(Shape::new(&cycles(order), on, driver, Form::Harmonic));
            }
        }
        for shape in found {
            let remembers = matches!(shape.drivers[0].wrap, Wrap::BranchOf | Wrap::LagOf);
            self.push(if remembers { Family::Memory } else { Family::Library }, shape);
        }
    }
}

/// Name of an error that repeats that many times per turn.
fn cycles(order: u8) -> String {
    match order {
        1 => "once_a_turn".to_owned(),
        2 => "twice_a_turn".to_owned(),
        _ => format!("{order}_times_a_turn"),
    }
}
