//! Compensation: what firmware does with readings to reduce their errors, as the inverse of an error model.
//!
//! A reading is `r + e(r, ...)`, with `r` the truth. From a reading `x` the truth is estimated by subtracting the
//! errors at the current estimate, repeated a few times. A late reading is led by its slope, which is low-passed as far
//! as that pays: the slope of noise is noise.

mod formula;
mod inverse;
mod program;
mod reading;
mod terms;

use crate::corrections::reference_of;
use crate::dataset::{Column, Dataset, Dimension, Kind};
use crate::finding::{Compensation, LeftOut};
use crate::fit::{Data, Fold, Found, fit_terms, values_of};
use crate::judge::{Errors, Metric};
use crate::model::{Acts, Form, Shape};
use crate::noise::NoiseModel;
use crate::problem::{Channels, wrap};
use formula::{Formula, call, number};
use inverse::{refusal, rises_beyond, unbent};
use program::{Input, Program, Running};
pub use reading::{Reading, reading};
use std::f64::consts::{PI, TAU};
use terms::{Fields, adds, sees_reference, slope, within_half};

/// Low-pass lengths tried for slopes, in readings.
const SMOOTHINGS: [f64; 5] = [0.0, 2.0, 5.0, 12.0, 30.0];
/// Maximum number of passes that subtract the errors at the current estimate.
const PASSES_MAX: usize = 3;
/// A simpler way is preferred if its error is larger by no more than this share.
const AS_GOOD: f64 = 1e-3;

/// Why a term is left out that brings held-out readings nothing.
const AS_GOOD_WITHOUT: &str =
    "gain and offset alone leave no larger error on readings that took no part";

/// Whether it is the gain or the offset.
fn is_line(shape: &Shape) -> bool {
    matches!((shape.acts, shape.form), (Acts::Bias | Acts::Scale, Form::Constant))
}

/// A model of a sensor with what its inversion needs.
struct Sensor<'a> {
    dataset: &'a Dataset,
    channels: &'a Channels,
    reading: &'a Column,
    truth: &'a Column,
    /// Times what is right that `reading` is.
    factor: f64,
    /// The shapes of its terms.
    shapes: Vec<Shape>,
    /// Names of those that leave nothing of what is measured beyond a limit.
    flat: Vec<String>,
    /// Smallest angle that the sensor reads, if its angle wraps after a turn; SI.
    wraps_at: Option<f64>,
}

/// How a model is inverted.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    /// Low-pass length of the slope that leads a late reading, in readings; `None` without a lead.
    led_over: Option<f64>,
    passes: usize,
}

/// The compensation of a sensor with the terms `found`, if it improves the readings, which are `factor` times those of
/// `dataset`.
///
/// # Errors
///
/// Why there can be none.
pub(crate) fn compensation(
    dataset: &Dataset,
    data: Data<'_>,
    (factor, found): (f64, &[Found]),
    noise: &NoiseModel,
    seed: u64,
) -> Result<Option<Compensation>, String> {
    let right = dataset.named(&data.block.label).filter(|_| dataset.kind == Kind::Sensor);
    let pair = right.and_then(|right| Some((right, reference_of(dataset, right)?)));
    let Some((right, truth)) = pair else { return Ok(None) };
    if let Some(why) = refusal(&right.name, found) {
        return Err(why);
    }
    let stated = right.values.iter().map(|value| value * factor).collect();
    let reading = &Column { values: stated, ..right.clone() };
    let shapes = found.iter().map(|one| one.shape.clone().within_seen(data.channels));
    let shapes: Vec<Shape> = shapes.collect();
    let coefficients = values_of(found);
    let width: usize = shapes.iter().map(Shape::width).sum();
    if coefficients.len() != width || data.all_columns(&shapes).len() != width {
        return Ok(None);
    }
    let knees = found.iter().filter(|one| one.shape.acts == Acts::Saturation);
    let flat = knees.filter(|knee| !rises_beyond(knee, found)).map(|knee| knee.shape.name.clone());
    let flat: Vec<String> = flat.collect();
    let sensor = |shapes| Sensor {
        dataset,
        channels: data.channels,
        reading,
        truth,
        factor,
        shapes,
        flat: flat.clone(),
        wraps_at: wraps_at(reading, &data.channels.run),
    };
    let folds = data.trained(&shapes, noise);
    // Gain and offset alone, of readings that count alike.
    let constants: Vec<Shape> = shapes.iter().filter(|shape| is_line(shape)).cloned().collect();
    let left_out = noise.left_out.clone();
    let white = NoiseModel { left_out, ..NoiseModel::white(data.layout.runs()) };
    let line_folds = data.trained(&constants, &white);
    let (sensor, line) = (sensor(shapes), sensor(constants));
    let before = sensor.held_out(data, &folds, |_, _| Program::default());
    let mut after = sensor.held_out(data, &folds, |values, rows| sensor.best(values, rows).0);
    let all = vec![true; dataset.rows()];
    let (mut program, mut unused) = sensor.best(&coefficients, &all);
    let straight = fit_terms(data, &line.shapes, &white);
    // Where other causes move with what is measured, a line through the readings alone can fall.
    if refusal(&right.name, &straight).is_none() {
        let by_line = line.held_out(data, &line_folds, |values, rows| line.best(values, rows).0);
        if !(after.rmse() < by_line.rmse() * (1.0 - AS_GOOD)) {
            after = by_line;
            program = line.best(&values_of(&straight), &all).0;
            let others = sensor.shapes.iter().filter(|shape| !is_line(shape));
            let term = |shape: &Shape| LeftOut {
                term: shape.name.clone(),
                why: AS_GOOD_WITHOUT.to_owned(),
            };
            unused = others.map(term).collect();
        }
    }
    // Steps that gain nothing are no use to firmware.
    if !(after.rmse() < before.rmse() * (1.0 - AS_GOOD)) {
        return Ok(None);
    }
    let unit = data.block.unit.clone();
    let metric = |errors| Metric { name: reading.name.clone(), unit: unit.clone(), errors };
    let held_out = metric(after).held_out(&metric(before), false, seed);
    let unit_of =
        |name: &str| dataset.named(name).map_or_else(String::new, |one| one.unit.text().to_owned());
    let (inputs, steps) = program.written(&reading.name, unit_of);
    let (of, unit) = (reading.name.clone(), reading.unit.text().to_owned());
    Ok(Some(Compensation { of, unit, inputs, steps, held_out, left_out: unused }))
}

/// Where the angle wraps: at zero or at minus half a turn. `None` if it does not wrap.
fn wraps_at(reading: &Column, run: &[usize]) -> Option<f64> {
    let values: Vec<f64> = reading.si().collect();
    let jumps = (1..values.len())
        .any(|row| run[row] == run[row - 1] && (values[row] - values[row - 1]).abs() > PI);
    let least = values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::min);
    let turns = reading.unit.dimension() == Dimension::Angle && jumps;
    turns.then_some(if least < -0.5 * PI { -PI } else { 0.0 })
}

impl Sensor<'_> {
    /// Errors of held-out readings after the program that `made` makes of the coefficients and rows of each fold.
    fn held_out(
        &self,
        data: Data<'_>,
        folds: &[(Fold, Vec<f64>)],
        made: impl Fn(&[f64], &[bool]) -> Program,
    ) -> Errors {
        let mut found = Errors { folds: folds.len(), ..Errors::default() };
        let alone = self.dataset.run_labels.len() < 2;
        for (number, (Fold { test, train }, coefficients)) in folds.iter().enumerate() {
            let rows = |uses: &[bool]| -> Vec<bool> {
                let mut rows = vec![false; self.dataset.rows()];
                data.block.rows.iter().zip(uses).for_each(|(&row, uses)| rows[row] = *uses);
                rows
            };
            let (test, program) = (rows(test), made(coefficients, &rows(train)));
            for (row, error) in self.errors(&program).into_iter().enumerate() {
                let run = if alone { number } else { data.channels.run[row] };
                if test[row] && error.is_finite() {
                    found.add(run, error.powi(2), number);
                }
            }
        }
        found
    }

    /// The simplest way that is as good as any on these rows, and the terms it leaves out.
    fn best(&self, coefficients: &[f64], rows: &[bool]) -> (Program, Vec<LeftOut>) {
        let made = |way| {
            let (program, left_out) = self.program(coefficients, way);
            let errors = self.errors(&program);
            let used = errors.iter().zip(rows).filter(|(error, uses)| **uses && error.is_finite());
            let (sum, count) = used
                .fold((0.0, 0.0), |(sum, count), (error, _)| (sum + error * error, count + 1.0));
            ((sum / f64::max(count, 1.0)).sqrt(), program, left_out)
        };
        let remembers = self.shapes.iter().any(Shape::remembers);
        let smoothings = if remembers { &SMOOTHINGS[..] } else { &SMOOTHINGS[..1] };
        let led = smoothings.iter().copied().map(Some).rev();
        let mut best = made(Way { led_over: None, passes: PASSES_MAX });
        let mut over = None;
        for led_over in led {
            let one = made(Way { led_over, passes: PASSES_MAX });
            if one.0 < best.0 * (1.0 - AS_GOOD) {
                (best, over) = (one, led_over);
            }
        }
        for passes in 1..PASSES_MAX {
            let shorter = made(Way { led_over: over, passes });
            if shorter.0 <= best.0 * (1.0 + AS_GOOD) {
                return (shorter.1, shorter.2);
            }
        }
        (best.1, best.2)
    }

    /// What firmware reads of a field: of the truth of another axis, the reading.
    fn reading_of(&self, field: &str) -> String {
        let is_its = |one: &&Column| {
            reference_of(self.dataset, one).is_some_and(|other| other.name == field)
        };
        self.dataset.columns.iter().find(is_its).map_or(field, |one| &one.name).to_owned()
    }

    /// Coefficients of each shape.
    fn terms<'a>(
        &'a self,
        coefficients: &'a [f64],
    ) -> impl Iterator<Item = (&'a Shape, &'a [f64])> {
        let mut at = 0;
        self.shapes.iter().map(move |shape| {
            let mine = coefficients.get(at..at + shape.width()).unwrap_or_default();
            at += shape.width();
            (shape, mine)
        })
    }

    /// The inverted model.
    fn program(&self, coefficients: &[f64], way: Way) -> (Program, Vec<LeftOut>) {
        let mut program = Program::default();
        let mut left_out = Vec::new();
        let (mut bias, mut scale, mut late) = (0.0, 1.0, 0.0);
        let (mut others, mut knee) = (Vec::new(), None);
        for (shape, mine) in self.terms(coefficients) {
            let value = mine.first().copied().unwrap_or(0.0);
            let refused = |why: &str| LeftOut { term: shape.name.clone(), why: why.to_owned() };
            match (shape.acts, shape.form) {
                (Acts::Bias, Form::Constant) => bias += value,
                (Acts::Scale, Form::Constant) => scale += value,
                (Acts::Delay, Form::Delay) if way.led_over.is_some() => late += value,
                (Acts::Delay, Form::Delay) => {
                    left_out.push(refused("its noise would be more than what leading it brings"));
                }
                (Acts::Clock, _) => {
                    left_out
                        .push(refused("time stamps that run wrong are mended where they are made"));
                }
                (Acts::DeadZone, _) => {
                    left_out.push(refused("what a dead zone holds back is not in the readings"));
                }
                (Acts::Saturation, _) if self.flat.contains(&shape.name) => {
                    left_out.push(refused("what was clipped is not in the readings"));
                }
                // One knee has an exact inverse; of several, the others are taken off like any error.
                (Acts::Saturation, _) if knee.is_none() => knee = Some((shape, value)),
                _ => others.push((shape, mine)),
            }
        }
        let si_of = |field: &str| self.dataset.named(field).map_or(1.0, |one| one.unit.si());
        let fields = Fields {
            reference: &self.channels.rotation_name,
            time: &self.channels.time_name,
            si: &si_of,
            read: &|field| self.reading_of(field),
            smoothing: way.led_over.unwrap_or(SMOOTHINGS[0]),
        };
        let si = self.reading.unit.si();
        let mut reading = program.input(Input::Reading) * number(si / self.factor);
        let remembers = late != 0.0 || others.iter().any(|(shape, _)| shape.remembers());
        let unwrapped = self.wraps_at.is_some() && remembers;
        if unwrapped {
            let now = reading.clone();
            reading = program.remembering("turned", reading, |before| {
                let rise = within_half(now - before.clone());
                before + rise
            });
        }
        let mut led = (reading - number(bias)) / number(scale);
        if late != 0.0 {
            let level = program.step("level", led);
            led = level.clone() + number(late) * slope(&mut program, &level, fields.smoothing);
        }
        let sees = others.iter().any(|(shape, _)| sees_reference(shape, &fields));
        let straight = |led: Formula| match knee {
            Some((shape, less)) => unbent(led, shape, scale, less),
            None => led,
        };
        let is_bare = others.is_empty() && knee.is_none();
        let led = if is_bare { led } else { program.step("straight", led) };
        let mut estimate = straight(led.clone());
        if !others.is_empty() {
            estimate = program.step("estimate", estimate);
        }
        for pass in 0..if sees { way.passes } else { 1 } {
            let mut sum = number(0.0);
            for term in &others {
                match adds(&mut program, *term, &estimate, &fields) {
                    Ok(error) => sum = sum + error,
                    Err(why) if pass == 0 => {
                        left_out.push(LeftOut { term: term.0.name.clone(), why });
                    }
                    Err(_) => {}
                }
            }
            if sum.is_zero() {
                break;
            }
            let less = led.clone() - sum / number(scale);
            let less = if knee.is_some() { program.step("straight", less) } else { less };
            estimate = program.step("estimate", straight(less));
        }
        let mut result = estimate / number(si);
        if let Some(least) = self.wraps_at {
            let (turn, least) = (TAU / si, least / si);
            let angle = program.step("angle", result);
            let turns = call("floor", [(angle.clone() - number(least)) / number(turn)]);
            result = angle - number(turn) * turns;
        }
        program.step("corrected", result);
        (program, left_out)
    }

    /// Output of `program` minus the truth, SI; NaN where either is missing.
    fn errors(&self, program: &Program) -> Vec<f64> {
        let mut errors = vec![f64::NAN; self.dataset.rows()];
        let fields: Vec<(&str, &[f64])> = program
            .fields()
            .filter_map(|name| Some((name, &*self.dataset.named(name)?.values)))
            .collect();
        let (si, truth_si) = (self.reading.unit.si(), self.truth.unit.si());
        let turns = self.reading.unit.dimension() == Dimension::Angle;
        for range in &self.channels.segments {
            let mut running = Running::new(program);
            // A field without a new value keeps its last.
            let mut last = vec![f64::NAN; fields.len()];
            for row in range.clone() {
                for (last, (_, values)) in last.iter_mut().zip(&fields) {
                    *last = if values[row].is_finite() { values[row] } else { *last };
                }
                let reading = self.reading.values[row];
                if !reading.is_finite() {
                    continue;
                }
                let field = |name: &str| {
                    let place = fields.iter().position(|(known, _)| *known == name);
                    place.map_or(f64::NAN, |place| last[place])
                };
                let found = running.next(self.channels.time[row], reading, field);
                let error = found * si - self.truth.values[row] * truth_si;
                errors[row] = if turns { wrap(error) } else { error };
            }
        }
        errors
    }
}
