//! Builds the finding and the model from the fits of all blocks.

use crate::dataset::{Dataset, Drive};
use crate::done::Done;
use crate::experiment::{self, Doubt, Experiment};
use crate::finding::{Effect, Figure, Finding, HeldOut, Left, Parameter, SCHEMA, Verdict, in_unit};
use crate::fit::{Found, residual};
use crate::judge::{Metric, Whiteness, of_innovations, stretches};
use crate::model::{Acts, Driver, Model, Shape, Term, is_frame};
use crate::noise::Whitener;
use crate::options::Options;
use crate::outcome::{self, BlockDiagnostics, Diagnostics, OffsetOfRuns};
use crate::problem::{Aggregate, Problem};
use crate::select::Contender;
use crate::units::short;
use crate::untold::of_blind;

/// Result of an identification.
#[derive(Debug, Clone)]
pub struct Identified {
    /// For `finding.json`.
    pub finding: Finding,
    /// For `model.toml`: the given model plus what was found.
    pub model: Model,
    /// For a report.
    pub diagnostics: Diagnostics,
    /// The plan that would decide between an effect and its rivals, if there are any.
    pub experiment: Option<Experiment>,
}

/// Builds the finding, the model and the report data from all blocks.
pub(crate) fn assemble(
    dataset: &Dataset,
    problem: &Problem,
    done: &[Done<'_>],
    set_right: Vec<Effect>,
    options: &Options,
) -> Identified {
    let (seed, noise_is_known) = (options.seed, options.noise_from.is_some());
    let offsets: Vec<Option<OffsetOfRuns>> =
        done.iter().map(|one| outcome::offset_of_runs(one.data, &one.fit)).collect();
    let mut notices: Vec<String> =
        dataset.notices.iter().chain(&problem.notices).cloned().collect();
    let mut left = Vec::new();
    for (one, offset) in done.iter().zip(&offsets) {
        left.extend(one.fit.left.iter().map(|contender| certain(one, contender)));
        left.extend(above_floor(one, offset.as_ref(), noise_is_known));
        left.extend(one.fit.goes.iter().map(|goes| goes.left(&one.data.block.label)));
        let whiteness = whiteness(one);
        let coloured = whiteness.filter(|found| !found.is_white(done.len()));
        left.extend(coloured.map(|found| found.left(one.data, done.len())));
        notices.extend(error_over_floor(one));
        notices.extend(errors_of_choice(one));
        notices.push(match whiteness {
            Some(found) => found.notice(one.data, done.len()),
            None => format!(
                "`{}` has too few observations to judge whether what is left is white",
                one.data.block.label
            ),
        });
    }
    let mut effects = by_benefit(set_right, done);
    outcome::lines_before_their_zero(&mut effects);
    let (held_out, held_out_also) = errors(done, seed);
    left.extend(gainless(&effects, std::iter::once(&held_out).chain(&held_out_also)));
    let verdict = verdict(&left, &effects, std::iter::once(&held_out).chain(&held_out_also));
    for (one, offset) in done.iter().zip(offsets) {
        effects.extend(one.rounding());
        // Each quantity has its share of the risk of a false alarm.
        let share = 1.0 / done.len() as f64;
        if let Some(offset) = offset.filter(|offset| offset.is_certain(share)) {
            effects.push(offset.effect);
        } else if let Some(slow) = outcome::slow_noise(one.data, &one.fit, share) {
            effects.push(slow.effect);
            notices.extend(slow.notice);
        }
    }
    let main = &done[main_block(done)];
    let terms: Vec<Term> = done.iter().flat_map(terms).collect();
    let of_plain = |one: &Done<'_>| -> Vec<Term> {
        let all = of_blind(one.data.block).into_iter().chain(one.plain.iter().cloned());
        all.map(|found| outcome::term(one.data, &found)).collect()
    };
    let drivers = terms.iter().flat_map(|term| &term.drivers);
    let field = |driver: &Driver| Some((driver.field.clone(), dataset.named(&driver.field)?.role));
    let fields = drivers.filter_map(field).collect();
    let doubts: Vec<Doubt<'_>> =
        done.iter().map(|one| Doubt { data: one.data, fit: &one.fit }).collect();
    let mut cases = experiment::cases(&doubts);
    experiment::refuse(&mut cases, &mut effects);
    let experiment = experiment::next(dataset, problem, &doubts, &cases);
    let (mut compensation, mut compensation_also) = (None, Vec::new());
    for one in done {
        match one.compensation(dataset, seed) {
            Ok(found) if compensation.is_none() => compensation = found,
            Ok(found) => compensation_also.extend(found),
            Err(why) => notices.push(why),
        }
    }
    let mut identified = Identified {
        finding: Finding {
            schema: SCHEMA,
            dataset: dataset.name.clone(),
            kind: dataset.kind,
            drive: dataset.drive.filter(|drive| *drive != Drive::Differential),
            rows: dataset.rows(),
            runs: dataset.run_labels.len(),
            seed,
            verdict,
            noise_floor: Figure {
                value: main.fit.floor / main.data.block.unit.si,
                unit: main.data.block.unit.text.clone(),
            },
            held_out,
            held_out_also,
            base: done.iter().flat_map(|one| base(one, done.len() > 1)).collect(),
            effects,
            path: outcome::path(&done.iter().map(|one| &one.fit).collect::<Vec<_>>()),
            left,
            compensation: compensation.clone(),
            compensation_also: compensation_also.clone(),
            next_experiment: None,
            set_aside: Vec::new(),
            notices,
        },
        model: Model {
            schema: SCHEMA,
            kind: dataset.kind,
            dataset: Some(dataset.name.clone()),
            fields,
            counts_per_rad_per_s: problem.counts_per_unit,
            closing_lever_m: problem.closing_lever_m,
            corrections: Vec::new(),
            compensation,
            compensation_also,
            terms,
            plain: done.iter().flat_map(of_plain).collect(),
        },
        diagnostics: Diagnostics {
            blocks: done.iter().map(diagnosed).collect(),
            run_labels: dataset.run_labels.clone(),
        },
        experiment,
    };
    if let Some(experiment) = &identified.experiment {
        experiment.note(&mut identified.finding);
    }
    outcome::join_powers(&mut identified.finding.effects);
    identified
}

/// Terms of the model, with the values to apply.
fn terms(one: &Done<'_>) -> Vec<Term> {
    let fixed = of_blind(one.data.block).into_iter().chain(one.clipping().map(|(found, _)| found));
    let all = fixed.chain(one.fit.applied.iter().cloned());
    all.map(|found| outcome::term(one.data, &found)).collect()
}

/// Parameters of the given model, each by the name of its term, and by its axis if it `is_one_of_several`.
fn base(one: &Done<'_>, is_one_of_several: bool) -> Vec<Parameter> {
    let axis = one.data.block.axis.filter(|_| is_one_of_several);
    let of = |found: &Found| {
        let Term { mut name, parameters, .. } = outcome::term(one.data, found);
        name += &axis.map_or_else(String::new, |axis| format!("_{axis:?}").to_lowercase());
        let numbers = parameters.into_iter().filter(|one| !is_frame(&one.name));
        numbers.map(move |parameter| Parameter { name: name.clone(), ..parameter })
    };
    of_blind(one.data.block).iter().chain(&one.fit.base).flat_map(of).collect()
}

fn diagnosed(one: &Done<'_>) -> BlockDiagnostics {
    let (before, after) = one.errors();
    outcome::diagnose(one.data, &one.plain, &one.fit, (&before[0].errors, &after[0].errors))
}

/// Effects with those that are `set_right`, first the one without which held-out errors rise most. What the package states
/// wrongly and only one thing can be goes before all: a scale error could take it up.
fn by_benefit(set_right: Vec<Effect>, done: &[Done<'_>]) -> Vec<Effect> {
    let mut effects = set_right;
    for one in done {
        effects.extend(one.clipping().map(|(_, effect)| effect));
        for (index, found) in one.fit.effects.iter().enumerate() {
            let after = &one.fit.path[one.fit.chosen].metrics[0];
            let without = &one.without(index)[0];
            let mut effect = outcome::effect(one.data, found, without.value(), after.value());
            if found.shape.acts == Acts::Axis && sees_little(one) && sees_most(found) {
                effect.name = "wrong_axis".to_owned();
            }
            effects.push(effect);
        }
    }
    let rise = |effect: &Effect| {
        let rise = effect.held_out_before / effect.held_out_after.max(f64::MIN_POSITIVE);
        if is_fitted(effect) { rise } else { f64::INFINITY }
    };
    effects.sort_by(|a, b| rise(b).total_cmp(&rise(a)));
    effects
}

fn is_fitted(effect: &Effect) -> bool {
    effect.parameters.iter().any(|one| one.standard_error.is_some())
}

/// Whether held-out errors fall.
fn falls(one: &HeldOut) -> bool {
    one.after < one.before * (1.0 - ALIKE)
}

/// Fitted effects beside which no held-out error falls: they are certain where they were fitted, and explain nothing elsewhere.
fn gainless<'a>(effects: &[Effect], mut errors: impl Iterator<Item = &'a HeldOut>) -> Vec<Left> {
    if errors.any(falls) {
        return Vec::new();
    }
    let of = |effect: &Effect| Left {
        drivers: effect.drivers.clone(),
        shape: format!("{}, which lowers no error on held-out runs", effect.name),
        share_of_residual_variance: 0.0,
    };
    effects.iter().filter(|effect| is_fitted(effect)).map(of).collect()
}

fn verdict<'a>(
    left: &[Left],
    effects: &[Effect],
    mut errors: impl Iterator<Item = &'a HeldOut> + Clone,
) -> Verdict {
    // Within a standard error: a unit or a sign that is stated wrongly is no more than a scale.
    let stays = |one: &HeldOut| one.after <= one.before + (one.ci95[1] - one.ci95[0]) / 4.0;
    if !left.is_empty() {
        Verdict::StructureLeft
    } else if effects.is_empty() {
        Verdict::NothingMissing
    } else if errors.clone().any(falls) {
        Verdict::Explained
    } else if errors.all(stays) {
        Verdict::NothingMissing
    } else {
        Verdict::StructureLeft
    }
}

/// A contender that is certain and was not added.
fn certain(one: &Done<'_>, contender: &Contender) -> Left {
    let Shape { name, drivers, .. } = &contender.candidate.shape;
    let share = contender.score.statistic / one.data.block.rows.len().max(1) as f64;
    Left {
        drivers: drivers.iter().map(ToString::to_string).collect(),
        shape: name.clone(),
        share_of_residual_variance: share.min(1.0),
    }
}

fn error_over_floor(one: &Done<'_>) -> Option<String> {
    let ratio = one.error_over(0.0)?;
    Some(format!(
        "the held-out error of `{}` is {ratio:.1} times the noise that is new in a reading",
        one.data.block.label
    ))
}

/// What sets the errors of the headline apart from those of the chosen model on the path, where they differ.
fn errors_of_choice(one: &Done<'_>) -> Vec<String> {
    let chosen = &one.fit.path[one.fit.chosen].metrics;
    let differ = |(nested, chosen): (&Metric, &Metric)| {
        let [of_choice, of_model] = [nested, chosen].map(|one| short(one.value()));
        let unit = in_unit(&chosen.unit.text);
        (of_choice != of_model).then(|| {
            format!(
                "the held-out error of `{}`, {of_choice}{unit}, counts the choice of the model: each run is predicted by \
                 the model that is chosen without it; the model chosen from all runs has {of_model}{unit} on the path",
                chosen.name
            )
        })
    };
    one.errors().1.iter().zip(chosen).filter_map(differ).collect()
}

/// Largest ratio of error to innovation noise that still counts as noise.
const ABOVE_FLOOR_MAX: f64 = 5.0;

/// Errors within this share are one and the same.
const ALIKE: f64 = 1e-9;

/// A residual far above the innovation noise: it holds something slow that no cause explains.
fn above_floor(
    one: &Done<'_>,
    offset: Option<&OffsetOfRuns>,
    noise_is_known: bool,
) -> Option<Left> {
    let ratio = one.error_over_known(offset)?;
    (ratio > ABOVE_FLOOR_MAX && !noise_is_known).then(|| Left {
        drivers: vec![one.data.channels.time_name.clone()],
        shape: format!(
            "error of {} at {ratio:.0} times the noise that is new in a reading",
            one.data.block.label
        ),
        share_of_residual_variance: 1.0 - ratio.powi(-2),
    })
}

/// Whether what is left of the quantity is white; `None` if there are too few observations to tell.
fn whiteness(Done { data, fit, .. }: &Done<'_>) -> Option<Whiteness> {
    let whitener = Whitener::new(data.layout, &fit.noise);
    of_innovations(&whitener.apply(&residual(*data, &fit.all())), &stretches(*data))
}

/// Whether the gyro sees less than half of the rotation that it should measure.
fn sees_little(one: &Done<'_>) -> bool {
    of_blind(one.data.block)
        .iter()
        .chain(&one.fit.base)
        .find(|found| found.shape.acts == Acts::Scale && found.shape.drivers.is_empty())
        .and_then(|found| found.coefficients.first())
        .is_some_and(|(scale, _)| *scale < -0.5)
}

/// Whether it sees more than half of the rotation about another axis.
fn sees_most(found: &Found) -> bool {
    found.coefficients.first().is_some_and(|(share, _)| share.abs() > 0.5)
}

/// The block of the headline: the one with the strongest effect.
fn main_block(done: &[Done<'_>]) -> usize {
    let strength =
        |one: &Done<'_>| one.fit.effects.iter().map(|found| found.strength).fold(0.0, f64::max);
    let mut best = 0;
    for index in 1..done.len() {
        if strength(&done[index]) > strength(&done[best]) {
            best = index;
        }
    }
    best
}

/// Held-out errors in every metric; for a driven path, the final position comes first.
fn errors(done: &[Done<'_>], seed: u64) -> (HeldOut, Vec<HeldOut>) {
    let main = main_block(done);
    let is_pose = |index: &usize| done[*index].data.block.aggregate == Aggregate::Pose;
    let mut order: Vec<usize> = (0..done.len()).filter(is_pose).collect();
    order.extend((0..done.len()).filter(|index| *index == main && !is_pose(index)));
    order.extend((0..done.len()).filter(|index| *index != main && !is_pose(index)));
    let several = done.iter().map(|one| one.errors().0.len()).sum::<usize>() > 1;
    let mut all: Vec<HeldOut> = order
        .into_iter()
        .flat_map(|index| {
            let (before, after) = done[index].errors();
            after
                .iter()
                .zip(before)
                .map(move |(after, before)| after.held_out(before, several, seed))
        })
        .collect();
    let first = all.remove(0);
    (first, all)
}

#[cfg(test)]
mod tests {
    use super::{Effect, HeldOut, Parameter, Verdict, gainless, verdict};

    fn error(before: f64, after: f64) -> HeldOut {
        HeldOut {
            metric: "rmse".to_owned(),
            quantity: None,
            unit: "deg/s".to_owned(),
            before,
            after,
            ci95: [0.9 * after, 1.1 * after],
            folds: 5,
        }
    }

    /// An effect of p = 1e-187 stood beside `nothing_missing`, since the choice without each run left it out.
    #[test]
    fn beside_a_fitted_effect_that_lowers_no_error_something_is_left() {
        let size =
            Parameter { standard_error: Some(0.1), ..Parameter::new("slope", 3.0, "deg/s/V") };
        let fitted = Effect {
            parameters: vec![size],
            p_value: 1e-187,
            ..Effect::new("supply", "bias", "linear")
        };
        let said = |effects: &[Effect], error: &HeldOut| {
            let left = gainless(effects, std::iter::once(error));
            verdict(&left, effects, std::iter::once(error))
        };
        assert_eq!(said(std::slice::from_ref(&fitted), &error(1.0, 1.0)), Verdict::StructureLeft);
        assert_eq!(said(&[fitted], &error(1.0, 0.5)), Verdict::Explained);
        // A sign that is stated wrongly is no more than a scale.
        let sign = Effect::new("reversed", "scale", "constant");
        assert_eq!(said(&[sign], &error(1.0, 1.0)), Verdict::NothingMissing);
        assert_eq!(said(&[], &error(1.0, 1.0)), Verdict::NothingMissing);
    }
}
