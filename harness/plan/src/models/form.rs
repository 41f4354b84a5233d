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
    let inside = TABLE_POINTS_MAX - 2;
    let length = last - first;
    let xs = (0..inside).map(|n| first + length * n as f64 / (inside - 1) as f64);
    let reach = model::SPLINE_REACH * length;
    let xs: Vec<f64> =
        std::iter::once(first - reach).chain(xs).chain(std::iter::once(last + reach)).collect();
    let columns = model::spline_columns(&knots, &xs);
    let value = |row: usize| values.iter().zip(&columns).map(|(value, one)| value * one[row]).sum();
    let points = xs.iter().enumerate().map(|(row, &x)| Point { x, value: value(row) }).collect();
    Ok(Form::Table { points })
}
