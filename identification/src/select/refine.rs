//! Tunes the nonlinear numbers of a shape to their best values.
use super::limit::harden;
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
    // A single view throughout: values of different views are not comparable.
    let view = scene.record.view(shape);
    let mut value = scene.look_at(&best, view).statistic;
    if shape.form == Form::Delay {
        delay(scene, &mut best, &mut value);
        return best;
    }
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
    if shape.form == Form::Saturation
        && let Some(now) = best.number("limit")
    {
        let range = bounds(&best, scene.data, "limit", now, 0);
        harden(scene, &mut best, range, value);
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
        "limit" => {
            // Beyond what was seen nothing is clipped, and a search that begins there finds no slope.
            let values = crate::model::see(data.channels, &shape.drivers[0], &shape.fixed);
            let sizes = values.iter().flat_map(|values| values.iter().map(|value| value.abs()));
            let factor = 1.0 + 1.5 * narrow;
            (now / factor, (now * factor).min(robust::ends(sizes).1))
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
pub(super) const SETTLED: f64 = 0.05;

/// Tunes a delay. The coefficient of one that is longer than a sample says how much is late, and not how late it is.
fn delay(scene: &Scene<'_>, best: &mut Shape, value: &mut f64) {
    long_delay(scene, best, value);
    // A small part that is late by a sample or some is all of it, late by a part of a sample.
    let is_part = coefficient(scene, best).0.abs() < scene.data.channels.interval();
    if is_part || scene.data.by_delay(best).is_none() {
        short_delay(scene, best, value);
        long_delay(scene, best, value);
    }
}

/// A delay shorter than a sample is its own coefficient: finds the fixed point at which the fit returns the number.
fn short_delay(scene: &Scene<'_>, best: &mut Shape, value: &mut f64) {
    const ROUNDS: usize = 10;
    let name = best.fixed.iter().map(|(name, _)| name.clone()).next().unwrap_or_default();
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..ROUNDS {
        let Some(now) = best.number(&name) else { return };
        let (found, error) = coefficient(scene, best);
        let off = found - now;
        if !found.is_finite() || found == 0.0 || !(off.abs() > SETTLED * error) {
            break;
        }
        // The secant through the last two converges where repetition alone is slow.
        let secant = last.filter(|_| off.abs() < 0.1 * now.abs()).map(|(before, its)| {
            let slope = (off - its) / (now - before);
            if slope < -0.2 { now - off / slope } else { found }
        });
        let found = secant.unwrap_or(found);
        // Half steps if it would diverge; a lag cannot be negative.
        let next = found.clamp(now - 4.0 * now.abs(), now + 4.0 * now.abs());
        let next = if name == "time_constant" { next.max(now / 4.0) } else { next };
        if next == 0.0 {
            break;
        }
        let mut tried = best.clone();
        tried.set(&name, next);
        let score = scene.score(&tried).statistic;
        if score < 0.5 * *value {
            break;
        }
        last = Some((now, off));
        *value = score;
        *best = tried;
    }
}

/// Moves a delay longer than a sample to where it explains most.
fn long_delay(scene: &Scene<'_>, best: &mut Shape, value: &mut f64) {
    const ROUNDS: usize = 10;
    for _ in 0..ROUNDS {
        let Some((name, slope)) = scene.data.by_delay(best) else { return };
        let mut columns = scene.data.columns(best);
        columns.push(slope);
        let fit = fit(scene, &columns);
        let ([much, moves], [_, error]) = (&fit.coefficients[..], &fit.errors[..]) else { return };
        let most = scene.data.channels.interval();
        let mut by = (moves / much).clamp(-most, most);
        // Where the whole step is too long, as between two turns of the reference, a part of it is not.
        let next = loop {
            if !(by.abs() > SETTLED * (error / much).abs()) {
                return;
            }
            let mut tried = best.clone();
            tried.set(name, best.number(name).unwrap_or(0.0) + by);
            let score = scene.score(&tried).statistic;
            if score > *value {
                break (tried, score);
            }
            by /= 4.0;
        };
        (*best, *value) = next;
    }
}

/// Coefficient of a shape of one column and its standard error, with the model so far in the fit.
fn coefficient(scene: &Scene<'_>, shape: &Shape) -> (f64, f64) {
    let fit = fit(scene, &scene.data.columns(shape));
    let first = |of: &[f64]| of.first().copied().unwrap_or(f64::NAN);
    (first(&fit.coefficients), first(&fit.errors))
}

/// Fit of `columns` beside the model so far.
fn fit(scene: &Scene<'_>, columns: &[Vec<f64>]) -> RobustFit {
    let mut columns = scene.whitener.apply_all(columns);
    for column in &mut columns {
        scene.project(column);
    }
    robust_fit(&columns, &scene.scores)
}
