//! The form of a term: its dependence on the drivers, as a controller evaluates it.

use super::numbers::Numbers;
use controller::correction::{BIAS_SUM_MAX, Driver, Form, Point, SCALE_SUM_MAX, TABLE_POINTS_MAX};
use identification::model::{self, KNOT, Wrap};

/// The form of `term` for these drivers.
pub(super) fn of(
    term: &model::Term,
    first: Option<Driver>,
    second: Option<Driver>,
    numbers: &Numbers<'_>,
) -> Result<Form, String> {
    let one = |name| numbers.get(name);
    let origin = || numbers.or_zero("origin");
    if first.is_none() && term.form != model::Form::Constant {
        return Err("it has no driver".to_owned());
    }
    if second.is_some() && term.form != model::Form::Product {
        return Err(format!("two drivers make a product, and not a {:?}", term.form));
    }
    Ok(match term.form {
        model::Form::Constant => Form::Constant { value: one("value")? },
        model::Form::Linear => {
            Form::Linear { slope: numbers.any(&["slope", "h"])?, origin: origin()? }
        }
        model::Form::Quadratic => {
            Form::Quadratic { coefficient: one("coefficient")?, origin: origin()? }
        }
        model::Form::Cubic => Form::Cubic { coefficient: one("coefficient")?, origin: origin()? },
        model::Form::Exponential => {
            if matches!(first, Some(Driver::TemperatureLag { .. })) {
                return Err("one time constant cannot be a lag's and an exponential's".to_owned());
            }
            let time_constant = one("time_constant")?;
            Form::Exponential { amplitude: one("amplitude")?, time_constant }
        }
        model::Form::Harmonic => {
            if first != Some(Driver::Heading) {
                return Err("a harmonic needs a heading".to_owned());
            }
            let twice = term.drivers.iter().any(|driver| driver.wrap == Wrap::Harmonic(2));
            Form::Harmonic { order: 1 + u8::from(twice), cos: one("cos")?, sin: one("sin")? }
        }
        model::Form::Periodic => {
            Form::Periodic { cos: one("cos")?, sin: one("sin")?, period: one("period")? }
        }
        model::Form::Step => Form::Step { size: one("size")?, at: one("at")? },
        model::Form::Hinge => Form::Hinge { slope: one("slope")?, at: one("at")? },
        model::Form::Bump => {
            Form::Bump { height: one("height")?, centre: one("centre")?, width: one("width")? }
        }
        model::Form::Tanh => {
            Form::Tanh { height: one("height")?, centre: one("centre")?, width: one("width")? }
        }
        model::Form::Spline => spline(term, first.unwrap_or_default(), numbers)?,
        model::Form::Product => {
            let Some(second) = second else { return Err("a product needs two drivers".to_owned()) };
            Form::Product {
                coefficient: one("coefficient")?,
                origin: origin()?,
                second,
                origin_2: numbers.or_zero("origin_2")?,
            }
        }
        model::Form::Surface => {
            return Err("a surface over two drivers has no place in a controller".to_owned());
        }
        model::Form::Delay | model::Form::DeadZone | model::Form::Saturation => {
            return Err(format!("a {:?} is neither of bias nor of scale", term.form));
        }
    })
}

/// A natural cubic spline as a table. Beyond its ends it continues straight over the range that the identification
/// intends, and is constant from there.
fn spline(term: &model::Term, driver: Driver, numbers: &Numbers<'_>) -> Result<Form, String> {
    let unit = match driver {
        _ if numbers.has(KNOT[0]) => numbers.get(KNOT[0])?,
        Driver::Rate | Driver::AbsRate | Driver::Heading => {
            return Err(format!(
                "the unit of its knots is not known: a parameter `{}` of 1 in that unit says it",
                KNOT[0]
            ));
        }
        _ => 1.0,
    };
    let values: Vec<f64> = (1..=term.knots.len())
        .map(|n| numbers.get(&format!("value_{n}")))
        .collect::<Result<_, _>>()?;
    let knots: Vec<f64> = term.knots.iter().map(|knot| knot * unit).collect();
    let rises = knots.windows(2).all(|pair| pair[0] < pair[1]);
    let (Some(&first), Some(&last)) = (knots.first(), knots.last()) else {
        return Err("a spline needs knots".to_owned());
    };
    if knots.len() < 2 || !rises {
        return Err("a spline needs two knots at least, in rising order".to_owned());
    }
    let limit = match term.term {
        model::Acts::Scale => SCALE_SUM_MAX,
        _ => BIAS_SUM_MAX.rad_per_s(),
    };
    if values.iter().any(|value| value.abs() > limit) {
        return Err(
            "it says more than a controller takes off: beside another term the data do not \
                    tell it, and the two cancel in them alone"
                .to_owned(),
        );
    }
    let bends = second_derivatives(&knots, &values);
    let inside = TABLE_POINTS_MAX - 2;
    let length = last - first;
    let xs = (0..inside).map(|n| first + length * n as f64 / (inside - 1) as f64);
    let reach = model::SPLINE_REACH * length;
    let points = std::iter::once(first - reach)
        .chain(xs)
        .chain(std::iter::once(last + reach))
        .map(|x| Point { x, value: interpolate(&knots, &values, &bends, x) })
        .collect();
    Ok(Form::Table { points })
}

/// Second derivatives at the knots of the natural spline through `values`: the tridiagonal system
/// h0 m0 + 2 (h0 + h1) m1 + h1 m2 = 6 (slope1 - slope0), solved by elimination (Thomas).
fn second_derivatives(knots: &[f64], values: &[f64]) -> Vec<f64> {
    let count = knots.len();
    let (mut diagonal, mut right) = (vec![1.0; count], vec![0.0; count]);
    for i in 1..count - 1 {
        let (before, after) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
        let bend = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
        let factor = if i == 1 { 0.0 } else { before / diagonal[i - 1] };
        diagonal[i] = 2.0 * (before + after) - factor * before;
        right[i] = 6.0 * bend - factor * right[i - 1];
    }
    let mut second = vec![0.0; count];
    for i in (1..count - 1).rev() {
        second[i] = (right[i] - (knots[i + 1] - knots[i]) * second[i + 1]) / diagonal[i];
    }
    second
}

fn interpolate(knots: &[f64], values: &[f64], second: &[f64], x: f64) -> f64 {
    let i = knots.partition_point(|knot| *knot <= x).clamp(1, knots.len() - 1) - 1;
    let h = knots[i + 1] - knots[i];
    let inside = x.clamp(knots[0], knots[knots.len() - 1]);
    let (a, b) = ((knots[i + 1] - inside) / h, (inside - knots[i]) / h);
    let value = a * values[i]
        + b * values[i + 1]
        + ((a * a * a - a) * second[i] + (b * b * b - b) * second[i + 1]) * h * h / 6.0;
    let slope = (values[i + 1] - values[i]) / h
        + ((3.0 * b * b - 1.0) * second[i + 1] - (3.0 * a * a - 1.0) * second[i]) * h / 6.0;
    value + slope * (x - inside)
}

#[cfg(test)]
mod tests {
    use super::{interpolate, second_derivatives};
    use proptest::prelude::*;

    proptest! {
        /// It passes through its knots, is smooth, and is straight at and beyond the ends.
        #[test]
        fn it_is_the_natural_spline(
            steps in prop::collection::vec((0.2f64..3.0, -5f64..5.0), 2..9), first in -10f64..10.0,
        ) {
            let mut at = first;
            let knots: Vec<f64> = steps.iter().map(|(step, _)| { at += step; at }).collect();
            let values: Vec<f64> = steps.iter().map(|(_, value)| *value).collect();
            let second = second_derivatives(&knots, &values);
            let f = |x: f64| interpolate(&knots, &values, &second, x);
            let h = 1e-4;
            let slope = |x: f64, side: f64| (f(x + side * h) - f(x)) / (side * h);
            for (knot, value) in knots.iter().zip(&values) {
                prop_assert!((f(*knot) - value).abs() < 1e-9);
                let bend = second.iter().fold(0.0f64, |a, b| a.max(b.abs()));
                prop_assert!((slope(*knot, 1.0) - slope(*knot, -1.0)).abs() < 2.0 * h * bend + 1e-6);
            }
            let last = knots[knots.len() - 1];
            prop_assert!((f(last + 2.0) - 2.0 * f(last + 1.0) + f(last)).abs() < 1e-9);
            prop_assert_eq!(second[0], 0.0);
        }
    }
}
