//! The forms of terms: their values and the permitted numbers.

use super::{Driver, Form, Point};
use core::f64::consts::TAU;

/// Highest harmonic of the heading.
const HARMONIC_MAX: u8 = 2;

impl Form {
    /// The term's value if its driver is `x` and, for a product, its second driver `y`.
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        let waves =
            |cos: f64, sin: f64, angle: f64| cos * libm::cos(angle) + sin * libm::sin(angle);
        match self {
            Self::Constant { value } => *value,
            Self::Linear { slope, origin } => slope * (x - origin),
            Self::Quadratic { coefficient, origin } => coefficient * (x - origin) * (x - origin),
            Self::Cubic { coefficient, origin } => {
                let off = x - origin;
                coefficient * off * off * off
            }
            Self::Exponential { amplitude, time_constant } => {
                amplitude * libm::exp(-x / time_constant)
            }
            Self::Harmonic { order, cos, sin } => waves(*cos, *sin, f64::from(*order) * x),
            Self::Periodic { cos, sin, period } => waves(*cos, *sin, TAU * x / period),
            Self::Step { size, at } if x >= *at => *size,
            Self::Step { .. } => 0.0,
            Self::Hinge { slope, at } => slope * (x - at).max(0.0),
            Self::Bump { height, centre, width } => {
                let off = (x - centre) / width;
                height * libm::exp(-0.5 * off * off)
            }
            Self::Tanh { height, centre, width } => height * libm::tanh((x - centre) / width),
            Self::Table { points } => between(points, x),
            Self::Product { coefficient, origin, origin_2, .. } => {
                coefficient * (x - origin) * (y - origin_2)
            }
        }
    }

    pub(super) fn is_usable(&self) -> bool {
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        match self {
            Self::Constant { value } => value.is_finite(),
            Self::Linear { slope: a, origin: b }
            | Self::Quadratic { coefficient: a, origin: b }
            | Self::Cubic { coefficient: a, origin: b }
            | Self::Step { size: a, at: b }
            | Self::Hinge { slope: a, at: b } => finite(&[*a, *b]),
            Self::Exponential { amplitude, time_constant } => {
                finite(&[*amplitude, *time_constant]) && *time_constant > 0.0
            }
            Self::Harmonic { order, cos, sin } => {
                (1..=HARMONIC_MAX).contains(order) && finite(&[*cos, *sin])
            }
            Self::Periodic { cos, sin, period } => finite(&[*cos, *sin, *period]) && *period > 0.0,
            Self::Bump { height, centre, width } | Self::Tanh { height, centre, width } => {
                finite(&[*height, *centre, *width]) && *width > 0.0
            }
            Self::Table { points } => {
                !points.is_empty()
                    && points.iter().all(|point| finite(&[point.x, point.value]))
                    && points.windows(2).all(|pair| pair[0].x < pair[1].x)
            }
            Self::Product { coefficient, origin, second, origin_2 } => {
                finite(&[*coefficient, *origin, *origin_2])
                    && *second != Driver::None
                    && second.is_usable()
            }
        }
    }
}

/// Linear between points, constant beyond them; zero without points.
fn between(points: &[Point], x: f64) -> f64 {
    let above = points.partition_point(|point| point.x < x);
    match (above.checked_sub(1).and_then(|below| points.get(below)), points.get(above)) {
        (Some(low), Some(high)) => {
            let share = (x - low.x) / (high.x - low.x);
            low.value + share * (high.value - low.value)
        }
        (Some(only), None) | (None, Some(only)) => only.value,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::{Driver, Form, Point};

    #[test]
    fn each_form_is_its_formula() {
        let points = [(20.0, 1.0), (30.0, 3.0), (40.0, 2.0)]
            .map(|(x, value)| Point { x, value })
            .into_iter()
            .collect();
        let table = Form::Table { points };
        let bump = Form::Bump { height: 2.0, centre: 1.0, width: 0.5 };
        let product =
            Form::Product { coefficient: 2.0, origin: 1.0, second: Driver::Time, origin_2: 3.0 };
        for (form, x, expected) in [
            (Form::Constant { value: 2.0 }, 9.0, 2.0),
            (Form::Linear { slope: 2.0, origin: 1.0 }, 4.0, 6.0),
            (Form::Quadratic { coefficient: 2.0, origin: 1.0 }, 4.0, 18.0),
            (Form::Cubic { coefficient: 2.0, origin: 1.0 }, -1.0, -16.0),
            (Form::Exponential { amplitude: 2.0, time_constant: 3.0 }, 3.0, 2.0 / 1f64.exp()),
            (
                Form::Harmonic { order: 2, cos: 1.0, sin: 2.0 },
                0.3,
                0.6f64.cos() + 2.0 * 0.6f64.sin(),
            ),
            (Form::Periodic { cos: 1.0, sin: 2.0, period: 8.0 }, 2.0, 2.0),
            (Form::Step { size: 2.0, at: 1.0 }, 1.0, 2.0),
            (Form::Step { size: 2.0, at: 1.0 }, 0.9, 0.0),
            (Form::Hinge { slope: 2.0, at: 1.0 }, 3.0, 4.0),
            (Form::Hinge { slope: 2.0, at: 1.0 }, 0.0, 0.0),
            (bump, 1.5, 2.0 * (-0.5f64).exp()),
            (Form::Tanh { height: 2.0, centre: 1.0, width: 2.0 }, 3.0, 2.0 * 1f64.tanh()),
            (table.clone(), 10.0, 1.0),
            (table.clone(), 20.0, 1.0),
            (table.clone(), 25.0, 2.0),
            (table.clone(), 38.0, 2.2),
            (table, 90.0, 2.0),
            (product, 2.0, 2.0 * 1.0 * (7.0 - 3.0)),
        ] {
            assert!(form.is_usable(), "{form:?}");
            let value = form.value(x, 7.0);
            assert!((value - expected).abs() < 1e-12, "{form:?} at {x}: {value} != {expected}");
        }
    }

    #[test]
    fn numbers_that_divide_by_nothing_are_not_usable() {
        let falling = [2.0, 1.0].map(|x| Point { x, value: 0.0 }).into_iter().collect();
        for form in [
            Form::Constant { value: f64::NAN },
            Form::Exponential { amplitude: 1.0, time_constant: 0.0 },
            Form::Periodic { cos: 1.0, sin: 1.0, period: -1.0 },
            Form::Harmonic { order: 3, cos: 1.0, sin: 1.0 },
            Form::Bump { height: 1.0, centre: 0.0, width: 0.0 },
            Form::Tanh { height: 1.0, centre: f64::INFINITY, width: 1.0 },
            Form::Table { points: heapless::Vec::new() },
            Form::Table { points: falling },
            Form::Product { coefficient: 1.0, origin: 0.0, second: Driver::None, origin_2: 0.0 },
        ] {
            assert!(!form.is_usable(), "{form:?}");
        }
    }
}
