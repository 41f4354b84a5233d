//! Search over one block: a path of models, and the choice of the one to report.

use super::choose::Contender;
use super::found::{Asked, BlockFit, Step, Waypoint};
use super::gain::fall;
use super::jointly::{Joint, Outliers, cross_thresholds};
use super::material::Material;
use super::record::Record;
use super::roughly::unreportable;
use super::state::{State, is_within_physics, settle};
use super::wheels::one_wheel;
use super::{finish, values};
use crate::fit::{Data, robust_fit};
use crate::judge::{
    Goes, Holding, Judge, Metric, Standing, Whiteness, best, confirmed, goes_with, margin,
    of_innovations, stretches,
};
use crate::model::{Acts, Driver, Shape, Wrap};
use crate::noise::NoiseModel;
use crate::problem::Aggregate;

/// Risk of a false alarm for a whole data set, where what is left is white.
const RISK: f64 = 0.011;

/// Number of effects after which the residual should be noise.
const PATIENCE: usize = 3;

/// Finds what the `base` terms lack to explain a block. `judge` measures how well a model predicts held-out data.
pub fn identify_block(
    data: Data<'_>,
    judge: &Judge<'_>,
    base: Vec<Shape>,
    asked: Asked<'_>,
    progress: &mut dyn FnMut(f64),
) -> BlockFit {
    let threshold = -(RISK * asked.share).ln();
    let record = Record::new(data, asked.timing);
    let mut state = State {
        record: &record,
        data,
        base: base.len(),
        terms: base,
        families: Vec::new(),
        noise: NoiseModel::white(data.layout.runs()),
    };
    if let Some(noise) = asked.noise {
        state.noise = NoiseModel { run_scale: vec![1.0; data.layout.runs()], ..noise.clone() };
    } else {
        state.fit_noise();
    }
    let mut path = vec![Step::new(state.clone(), judge)];
    let mut left = Vec::new();
    let material = Material::new(judge, &record);
    // A residual that depends on the input or has a memory unlike noise is not noise, and probabilities under noise are
    // meaningless for it: the search then looks for causes that matter to the user, whatever the rest is.
    let base = state.clone();
    if remains(&base).goes.is_some() {
        let rough = material.path(&base, asked);
        let mut last = rough[rough.len() - 1].state.clone();
        last.fit_noise();
        if rough.len() == 1 || remains(&last).goes.is_some() {
            return reported(rough, left, asked, judge, &material);
        }
    }
    for round in 0..2 * asked.effects_max {
        progress(round as f64 / (round as f64 + 2.0));
        let added = state.terms.len() - state.base;
        if Shape::causes(&state.terms[state.base..]) >= asked.effects_max
            || (added >= PATIENCE && !remains(&state).is_noise())
        {
            break;
        }
        let before = state.terms.clone();
        match state.step(threshold, asked.noise.is_some()) {
            Ok(()) => {
                match state.terms.len() - state.base {
                    1 => state.retime(),
                    _ => state.exchange(threshold),
                }
                state.prune();
                if let Some(one) = one_wheel(&state, false) {
                    state = one;
                }
                // The added term was dropped again: the next round would repeat this one.
                if are_alike(&state.terms, &before) {
                    break;
                }
                path.push(Step::new(state.clone(), judge));
            }
            Err(failed) => {
                left = failed;
                break;
            }
        }
    }
    if !remains(&state).is_noise() {
        return reported(material.path(&base, asked), left, asked, judge, &material);
    }
    let misleads = misleads(&path);
    // Noise can absorb a sparse cause, as colour or as outliers: the raw residual is searched as well. Slow noise
    // continues from run to run and must not help to predict the next run.
    if asked.noise.is_none() && is_swallowing(&state, &path[path.len() - 1].metrics) {
        let together = Judge { holding: Holding::Together, ..*judge };
        let material = Material::new(&together, &record);
        material.look_again(&mut path, judge);
        material.extend(&mut path, judge, asked);
    }
    if misleads {
        let raw = material.path(&base, asked);
        if falls_to(&raw) > falls_to(&path) {
            path = raw;
        }
    }
    reported(path, left, asked, judge, &material)
}

/// Whether runs that took no part are predicted worse with what is certain under the noise than without it: that need not be
/// their noise.
fn misleads(path: &[Step<'_>]) -> bool {
    path.last().is_some_and(|last| fall(&path[0].metrics, &last.metrics) < 0.0)
}

/// How far the errors fall along a path.
fn falls_to(path: &[Step<'_>]) -> f64 {
    path.iter().map(|step| fall(&path[0].metrics, &step.metrics)).fold(0.0, f64::max)
}

/// Share within which a number of a term is the same. A term that was added and dropped again has moved the others a little.
const SAME_NUMBER: f64 = 0.05;

/// Whether both hold the same terms with about the same numbers.
fn are_alike(one: &[Shape], other: &[Shape]) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SAME_NUMBER * a.abs().max(b.abs());
    let numbers = |shape: &Shape| {
        let fixed = shape.fixed.iter().map(|(_, number)| *number);
        fixed.chain(shape.knots.iter().chain(&shape.knots_2).copied()).collect::<Vec<f64>>()
    };
    let same = |(a, b): (&Shape, &Shape)| {
        let (a_has, b_has) = (numbers(a), numbers(b));
        a.says(b)
            && a.name == b.name
            && a_has.len() == b_has.len()
            && a_has.iter().zip(&b_has).all(|(a, b)| near(*a, *b))
    };
    one.len() == other.len() && one.iter().zip(other).all(same)
}

/// Keeps one of the models that have the same terms and differ in the weights of the readings: the one that predicts better, at
/// the place of the first.
pub(super) fn keep_better(path: &mut Vec<Step<'_>>) {
    for index in (1..path.len()).rev() {
        let is_same = |step: &Step<'_>| are_alike(&step.state.terms, &path[index].state.terms);
        let Some(first) = path[..index].iter().position(is_same) else { continue };
        let again = path.remove(index);
        if fall(&path[first].metrics, &again.metrics) > 0.0 {
            path[first] = again;
        }
    }
}

/// Returns the reported model with the path.
fn reported(
    path: Vec<Step<'_>>,
    left: Vec<Contender>,
    asked: Asked<'_>,
    judge: &Judge<'_>,
    material: &Material<'_>,
) -> BlockFit {
    let mut path = path;
    for step in &mut path {
        if settle(&mut step.state) {
            *step = Step::new(step.state.clone(), judge);
        }
    }
    let is_noise = remains(&path[path.len() - 1].state).is_noise();
    // A term that was certain, or physical, while the residual counted as noise or beside fewer terms may no longer be.
    for step in path.iter_mut().skip(1).filter(|_| !is_noise) {
        let mut state = step.state.clone();
        while let Some(index) = unreportable(&state, asked.share) {
            state.remove(index);
            state = material.fitted(state);
        }
        if state.terms.len() < step.state.terms.len() {
            *step = Step::new(state, judge);
        }
    }
    let mut is_plain = true;
    path.retain(|step| std::mem::take(&mut is_plain) || is_within_physics(&step.state));
    let richest = &path[path.len() - 1].state.clone();
    keep_better(&mut path);
    // If the residual is noise, the innovation of each reading is the most informative.
    let innovations: Vec<Metric> = path
        .iter()
        .filter(|_| is_noise)
        .map(|step| judge.innovation(&step.state.terms, &richest.noise))
        .collect();
    let standings: Vec<Standing<'_>> = path
        .iter()
        .enumerate()
        .map(|(index, step)| Standing {
            numbers: step.numbers(),
            unnamed: step.state.terms.iter().filter(|term| !term.known).count(),
            metrics: &step.metrics,
            innovation: innovations.get(index),
            of_readings: richest.data.block.aggregate == Aggregate::Row,
        })
        .collect();
    let (chosen, nested) = confirmed(&standings);
    let waypoints = path
        .iter()
        .map(|step| {
            let state = &step.state;
            let margins = (0..step.metrics.len())
                .map(|metric| {
                    let best = &path[best(&standings, metric)].metrics[metric];
                    margin(&step.metrics[metric], best)
                })
                .collect();
            Waypoint {
                effects: state.terms[state.base..].iter().map(|term| term.name.clone()).collect(),
                causes: Shape::causes(&state.terms[state.base..]),
                metrics: step.metrics.clone(),
                margins,
            }
        })
        .collect();
    let mut state = path[chosen].state.clone();
    let mut left = left;
    if is_noise {
        left.extend(richest.surely_beyond(&state.terms, -(RISK * asked.share).ln()));
    }
    let outliers = if is_noise { Outliers::Less } else { Outliers::Alike };
    let has_crossed = cross_thresholds(&mut state, outliers);
    let mut fit = if is_noise {
        if asked.noise.is_none() && (has_crossed || chosen + 1 < path.len()) {
            state.fit_noise();
        }
        let joint = Joint::new(&state, outliers);
        let mut fit = finish::of_noise(&state, &joint, left);
        values::of_noise(&mut fit, &joint.state, judge);
        fit
    } else {
        let joint = Joint::new(&state, outliers);
        let mut fit = finish::of_structure(material, (&state, &joint), &path[chosen].metrics);
        values::of_structure(&mut fit, &joint.state);
        fit
    };
    (fit.path, fit.chosen, fit.goes) = (waypoints, chosen, remains(&state).goes);
    fit.nested = nested;
    fit
}

/// Ratio of error to white noise from which the noise may hide a cause, as colour or as outliers.
const SWALLOWING: f64 = 5.0;

/// Whether the error of readings is so far above the white noise that it may hide a cause.
fn is_swallowing(state: &State<'_>, metrics: &[Metric]) -> bool {
    let scene = state.scene(&state.terms);
    let floor = scene.floor(&state.noise);
    let is_row = state.data.block.aggregate == Aggregate::Row;
    is_row && metrics.iter().any(|metric| metric.errors.rmse() > SWALLOWING * floor)
}

/// Properties of a residual.
struct Remains {
    /// The input that its size depends on, if any.
    goes: Option<Goes>,
    /// Whether it is white.
    whiteness: Option<Whiteness>,
}

/// Probability under noise below which a memory is not noise. An effect that the model names but fits imperfectly must
/// not count as one (assumption, measured on synthetic sets).
const MEMORY: f64 = 1e-10;

impl Remains {
    fn is_noise(&self) -> bool {
        self.goes.is_none() && self.whiteness.is_none_or(|found| found.p_value > MEMORY)
    }
}

/// Examines the residual of `state`.
fn remains(state: &State<'_>) -> Remains {
    let data = state.data;
    let white = data.whitened(&state.terms, &state.noise.of_all());
    let white = white.left(&robust_fit(&white.columns, &white.target).coefficients);
    let channels = data.channels;
    let of_rows = |values: &[f64]| -> Vec<f64> {
        data.block.rows.iter().map(|&row| values[row].abs()).collect()
    };
    let mut inputs: Vec<(&str, Vec<f64>)> = Vec::new();
    let rate = Driver::new(Wrap::RateOf, &channels.rotation_name).to_string();
    if !channels.rotation.is_empty() && data.block.exposure(Acts::Bias).is_none()
        || data.block.exposure(Acts::Scale).is_some()
    {
        if channels.rotation_has_zero() {
            inputs.push((&channels.rotation_name, of_rows(&channels.rotation)));
        }
        let slope = channels.smooth(&channels.rotation).slope;
        inputs.push((&rate, of_rows(&slope)));
    }
    for name in ["speed", "acceleration"] {
        if let Some(channel) = channels.named(name) {
            inputs.push((name, of_rows(&channel.values)));
        }
    }
    let whiteness = of_innovations(&white, &stretches(data));
    Remains { goes: goes_with(&white, &inputs), whiteness }
}

#[cfg(test)]
mod tests {
    use super::are_alike;
    use crate::model::{Acts, Driver, Form, Shape};

    #[test]
    fn a_number_that_has_moved_a_little_is_no_other_model() {
        let late = |by: f64, share: f64| {
            let shape = Shape::new("delay", Acts::Delay, Driver::plain("x"), Form::Delay);
            vec![shape.with("delay", by).with("share", share)]
        };
        assert!(are_alike(&late(0.04, 1.0), &late(0.0401, 0.999)));
        assert!(!are_alike(&late(0.04, 1.0), &late(0.044, 1.0)));
        assert!(!are_alike(&late(0.04, 1.0), &[]));
    }
}
