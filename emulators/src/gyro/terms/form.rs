//! The forms of terms: their values and their numbers.

use super::{Form, Point};
use crate::parameters::Domain;
use libm::{cos, exp, sin, tanh};
use std::f64::consts::TAU;

impl Form {
    /// The term's value if its driver is `x` and, for a product, its second driver `y`.
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        match self {
            Self::Constant { value } => *value,
            Self::Linear { slope, origin } => slope * (x - origin),
            Self::Quadratic { coefficient, origin } => coefficient * (x - origin) * (x - origin),
            Self::Cubic { coefficient, origin } => coefficient * libm::pow(x - origin, 3.0),
            Self::Exponential { amplitude, time_constant } => amplitude * exp(-x / time_constant),
            Self::Harmonic { order, cos: even, sin: odd } => {
                let angle = f64::from(*order) * x;
                even * cos(angle) + odd * sin(angle)
            }
            Self::Periodic { cos: even, sin: odd, period } => {
                let angle = TAU * (x / period);
                even * cos(angle) + odd * sin(angle)
            }
            Self::Step { size, at } => {
                if x < *at {
                    0.0
                } else {
                    *size
                }
            }
            Self::Hinge { slope, at } => slope * (x - at).max(0.0),
            Self::Bump { height, centre, width } => {
                height * exp(-libm::pow((x - centre) / width, 2.0) / 2.0)
            }
            Self::Tanh { height, centre, width } => height * tanh((x - centre) / width),
            Self::Table { points } => between(points, x),
            Self::Product { coefficient, origin, origin_2, .. } => {
                coefficient * (x - origin) * (y - origin_2)
            }
        }
    }

    /// Its numbers by name, with their permitted values. A table has no parameters.
    pub(super) fn numbers(&mut self) -> Vec<(&'static str, &mut f64, Domain)> {
        const ANY: Domain = Domain::FINITE;
        const ABOVE_ZERO: Domain = Domain::POSITIVE;
        match self {
            Self::Constant { value } => vec![("value", value, ANY)],
            Self::Linear { slope, origin } => vec![("slope", slope, ANY), ("origin", origin, ANY)],
            Self::Quadratic { coefficient, origin } | Self::Cubic { coefficient, origin } => {
                vec![("coefficient", coefficient, ANY), ("origin", origin, ANY)]
            }
            Self::Exponential { amplitude, time_constant } => {
                vec![("amplitude", amplitude, ANY), ("time_constant", time_constant, ABOVE_ZERO)]
            }
            Self::Harmonic { cos, sin, .. } => vec![("cos", cos, ANY), ("sin", sin, ANY)],
            Self::Periodic { cos, sin, period } => {
                vec![("cos", cos, ANY), ("sin", sin, ANY), ("period", period, ABOVE_ZERO)]
            }
            Self::Step { size, at } => vec![("size", size, ANY), ("at", at, ANY)],
            Self::Hinge { slope, at } => vec![("slope", slope, ANY), ("at", at, ANY)],
            Self::Bump { height, centre, width } | Self::Tanh { height, centre, width } => {
                vec![("height", height, ANY), ("centre", centre, ANY), ("width", width, ABOVE_ZERO)]
            }
            Self::Table { .. } => Vec::new(),
            Self::Product { coefficient, origin, origin_2, .. } => vec![
                ("coefficient", coefficient, ANY),
                ("origin", origin, ANY),
                ("origin_2", origin_2, ANY),
            ],
        }
    }
}

/// Linear between points, constant beyond them; zero without points.
fn between(points: &[Point], x: f64) -> f64 {
    let Some((first, last)) = points.first().zip(points.last()) else { return 0.0 };
    for pair in points.windows(2) {
        if x >= pair[0].x && x < pair[1].x {
            let slope = (pair[1].value - pair[0].value) / (pair[1].x - pair[0].x);
            return pair[0].value + slope * (x - pair[0].x);
        }
    }
    if x < first.x { first.value } else { last.value }
}
