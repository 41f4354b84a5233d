//! Errors of a sensor over the quantity that it measures.

use super::cycles::{go_round, tells_cycles};
use super::library::{Builder, PLAYS, mean};
use crate::dataset::{Dimension, Role};
use crate::model::{Acts, Form, Wrap, narrowest_play};
use crate::problem::Channels;
use crate::robust;
use std::f64::consts::TAU;

/// Half widths of a hysteresis of the measured quantity, as multiples of the error.
const ERRORS_WIDE: [f64; 3] = [0.5, 1.0, 2.0];

impl Builder<'_> {
    /// Errors of a sensor over the quantity it measures: a curve, a hysteresis, cycles per turn.
    pub(super) fn over_reference(&mut self, on: Acts) {
        if on != Acts::Bias || self.block.is_blind {
            return;
        }
        let Channels { rotation, rotation_name: name, rotation_unit, .. } = self.channels;
        let origin = ("origin", mean(rotation));
        let turns = rotation_unit.dimension() == Dimension::Angle;
        let (low, high) = robust::ends(rotation.iter().copied());
        let repeats = turns && go_round(rotation) && high - low < 2.0 * TAU;
        if !repeats {
            self.add("nonlinearity", on, (Wrap::Plain, name), Form::Quadratic, &[origin]);
            self.add("nonlinearity_cubic", on, (Wrap::Plain, name), Form::Cubic, &[origin]);
        }
        self.add("rate_dependence", on, (Wrap::RateOf, name), Form::Linear, &[]);
        // A backlash is as wide as the error that it makes, however far the sensor travels.
        let error = robust::spread(&self.block.residual);
        let mut widths: Vec<f64> = ERRORS_WIDE.iter().map(|times| times * error).collect();
        widths.retain(|width| *width > 0.0 && *width < PLAYS[0] * (high - low));
        widths.extend(PLAYS.iter().map(|share| share * (high - low)));
        let least = narrowest_play(self.channels);
        for width in widths.into_iter().filter(|width| *width >= least) {
            let numbers = [("half_width", width)];
            self.add("hysteresis", on, (Wrap::BranchOf, name), Form::Linear, &numbers);
        }
        if !turns {
            for constant in self.time_constants() {
                let numbers = [origin, ("time_constant", constant)];
                self.add("creep", on, (Wrap::LagOf, name), Form::Linear, &numbers);
            }
        }
        let headings = self.channels.channels.iter().filter(|one| one.role == Role::Heading);
        let angles = turns.then_some((name, rotation)).into_iter();
        for (angle, values) in angles.chain(headings.map(|one| (&one.name, &one.values))) {
            for order in (1..=Wrap::HARMONICS).filter(|order| tells_cycles(*order, values)) {
                let driver = (Wrap::Harmonic(order), angle.as_str());
                self.add(&cycles(order), on, driver, Form::Harmonic, &[]);
            }
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
