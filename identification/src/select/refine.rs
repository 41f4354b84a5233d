//! Tunes the nonlinear numbers of a shape to their best values.
use super::scene::Scene;
use crate::fit::{Data, RobustFit, robust_fit};
use crate::model::{Form, Shape};
use crate::robust;

/// Steps of the golden section.
const STEPS: usize = 10;
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// `shape` with the numbers that explain most in `scene`.
pub fn refine(scene: &Scene<'_>, shape: &Shape) -> Shape {
    let mut best = shape.clone();
    if shape.form == Form::Delay {
        delay(scene, &mut best);
        return best;
    }
    // A single view throughout: values of different views are not comparable.
    let view = scene.record.view(shape);
    let mut value = scene.look_at(&best, view).statistic;
    let names = shape.nonlinear();
    for sweep in 0..if names.len() > 1 { 2 } else { 1 } {
        for name in &names {
            let Some(now) = best.number(name) else { continue };
            let (low, high) = bounds(&best, scene.data, name, now, sweep);
            if !(high > low) {
                continue;
            }
            let (found, number) = golden(low, high, |number| {
                let mut tried = best.clone();
                tried.set(name, number);
                scene.look_at(&tried, view).statistic
            });
            if found > value {
                best.set(name, number);
                value = found;
            }
        }
    }
    best
}

/// Range of a number: around its present value, wide enough to reach the next value that was tried.
fn bounds(shape: &Shape, data: Data<'_>, name: &str, now: f64, sweep: usize) -> (f64, f64) {
    let narrow = if sweep == 0 { 1.0 } else { 0.4 };
    match name {
        "period" => {
            // Within half a bin of the transform.
            let span = data.channels.span().max(now);
            let half = now / span * 0.6;
            (now * (1.0 - half), now * (1.0 + half))
        }
        "origin" | "origin_2" => {
            let which = usize::from(name == "origin_2");
            let reach = spread_of(shape, data, which) * narrow;
            (now - reach, now + reach)
        }
        "at" | "centre" => {
            let reach = match shape.form {
                Form::Bump | Form::Tanh => shape.number("width").unwrap_or(0.0) * 2.0,
                Form::Step => data.channels.span() / 30.0,
                _ => spread_of(shape, data, 0) / 8.0,
            } * narrow;
            (now - reach, now + reach)
        }
        _ => {
            let factor = 1.0 + 1.5 * narrow;
            (data.told(shape, name, now / factor), data.told(shape, name, now * factor))
        }
    }
}

fn spread_of(shape: &Shape, data: Data<'_>, driver: usize) -> f64 {
    crate::model::see(data.channels, &shape.drivers[driver], &shape.fixed).map_or(0.0, |values| {
        let (low, high) = robust::ends(values.iter().copied());
        high - low
    })
}

/// Maximum of `f` between `low` and `high`, and its position.
fn golden(low: f64, high: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    let (mut a, mut b) = (low, high);
    let (mut c, mut d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    for _ in 0..STEPS {
        if fc > fd {
            (b, d, fd) = (d, c, fc);
            c = b - GOLDEN * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + GOLDEN * (b - a);
            fd = f(d);
        }
    }
    if fc > fd { (fc, c) } else { (fd, d) }
}

/// Share of its standard error within which a delay is its own coefficient. A rougher one leaves an error that goes with the
/// slope of the reference, and a clock or a hysteresis would take it up.
const SETTLED: f64 = 0.05;

/// Tunes a delay, a lag or a clock, whose coefficient is its number: all of what is measured is late (Gauss and Newton's method
/// with shorter steps). Where the motion has one frequency, how much is late cannot be told from how late it is.
fn delay(scene: &Scene<'_>, best: &mut Shape) {
    const ROUNDS: usize = 10;
    let Some((name, start)) = best.fixed.first().cloned() else { return };
    let limit = robust::HUBER * scene.scale;
    let with = |number: f64| {
        let mut shape = best.clone();
        shape.set(&name, number);
        let left = left_by(scene, &shape, number)?;
        Some((robust::loss(&left, limit), number, left, shape))
    };
    let less = |most: f64, number: f64| with(number).filter(|tried| tried.0 < most);
    let Some(mut now) = with(start) else { return };
    // To first order a coefficient is the number, from wherever it is looked at.
    let is_lag = name == "time_constant";
    let first = Some(coefficient(scene, best)).filter(|first| !is_lag || *first > 0.0);
    now = first.and_then(|first| less(now.0, first)).unwrap_or(now);
    for _ in 0..ROUNDS {
        let Some((_, mut tangent)) = scene.data.by_lateness(&now.3) else { break };
        tangent = scene.whitener.apply(&tangent);
        scene.project(&mut tangent);
        let RobustFit { coefficients, errors, .. } = robust_fit(&[tangent], &now.2);
        let (&[mut by], &[error]) = (&coefficients[..], &errors[..]) else { break };
        let next = loop {
            if !(by.abs() > SETTLED * error) {
                break None;
            }
            // A lag cannot be negative.
            let number = if is_lag { (now.1 + by).max(now.1 / 4.0) } else { now.1 + by };
            if let Some(next) = less(now.0, number) {
                break Some(next);
            }
            by /= 4.0;
        };
        let Some(next) = next else { break };
        now = next;
    }
    *best = now.3;
}

/// What `shape` leaves in `scene` with its number as coefficient.
fn left_by(scene: &Scene<'_>, shape: &Shape, number: f64) -> Option<Vec<f64>> {
    let mut column = scene.whitener.apply(&scene.data.columns(shape).pop()?);
    scene.project(&mut column);
    Some(scene.white.iter().zip(&column).map(|(white, late)| white - number * late).collect())
}

/// Coefficient of a shape of one column, with the model so far in the fit.
fn coefficient(scene: &Scene<'_>, shape: &Shape) -> f64 {
    let mut columns = scene.whitener.apply_all(&scene.data.columns(shape));
    columns.iter_mut().for_each(|column| scene.project(column));
    robust_fit(&columns, &scene.white).coefficients.first().copied().unwrap_or(f64::NAN)
}
