//! Which model of a path is reported: the simplest that is as good as the best (Breiman, Friedman, Olshen and Stone
//! 1984, section 3.4.3, the rule of one standard error), in every metric.

use super::{Errors, Metric};

/// A model on the path, from plain to rich, with its held-out errors.
#[derive(Clone, Copy)]
pub(crate) struct Standing<'a> {
    /// Number of parameters fitted beyond the plain model.
    pub numbers: usize,
    /// How many of its terms have no name: splines, surfaces.
    pub unnamed: usize,
    /// Its errors in each metric; all models of a path have the same metrics.
    pub metrics: &'a [Metric],
    /// Its error from one reading to the next, where the residual is noise.
    pub innovation: Option<&'a Metric>,
    /// Whether its metrics are errors of single readings, and not of the ends of runs.
    pub of_readings: bool,
}

/// Two errors count as equal when they differ by no more than this many standard errors.
const ERRORS: f64 = 1.0;

/// Margin within which the mean square of `one` counts as equal to the `best`. Some runs have errors that no model
/// explains, such as those of the reference at their ends, so a difference counts only if it exceeds the error of the
/// best model's own error.
pub(crate) fn margin(one: &Metric, best: &Metric) -> f64 {
    paired(one, best).max(alone(best))
}

/// The margin by the error of a model's own error, where it has several runs.
fn alone(best: &Metric) -> f64 {
    let error = best.errors.standard_error();
    if error.is_finite() { ERRORS * error } else { 0.0 }
}

/// The margin by what runs do not share alone. If the residual is noise, the innovation of each reading holds all that
/// the data say about a model, and models differ in it by little else.
fn paired(one: &Metric, best: &Metric) -> f64 {
    let error = one.errors.beyond(&best.errors).1;
    ERRORS * if error.is_finite() { error } else { best.errors.mean_square() }
}

/// Index of the best model in a metric.
pub(crate) fn best(path: &[Standing<'_>], metric: usize) -> usize {
    let errors: Vec<&Metric> = path.iter().map(|one| &one.metrics[metric]).collect();
    best_of(&errors)
}

fn best_of(errors: &[&Metric]) -> usize {
    let square = |index: usize| errors[index].errors.mean_square();
    (0..errors.len()).min_by(|a, b| square(*a).total_cmp(&square(*b))).unwrap_or(0)
}

/// Share of the mean square by which a model may exceed a simpler one within the error of that one alone: 5 % of the error
/// (assumption). Where readings favour a term and the errors that its user has rise by more, these decide.
const TOLERATED: f64 = 0.1;

/// Margin within which readings decide between `rich` and `simple`.
fn tolerated(rich: &Metric, simple: &Metric) -> f64 {
    paired(rich, simple).max(alone(simple).min(TOLERATED * simple.errors.mean_square()))
}

/// Whether model `rich` is worse than `simple` in some metric, beyond the standard error.
fn is_worse(rich: &Standing<'_>, simple: &Standing<'_>) -> bool {
    let (is_noise, of_readings) = (rich.innovation.is_some(), rich.of_readings);
    let exceeds = |rich: &Metric, simple: &Metric, margin: f64| {
        let (more, _) = rich.errors.beyond(&simple.errors);
        more > 0.0 && !(more <= margin)
    };
    let mut metrics = rich.metrics.iter().zip(simple.metrics);
    let mut innovations = rich.innovation.iter().zip(simple.innovation);
    metrics.any(|(rich, simple)| {
        let margin = match (is_noise, of_readings) {
            (false, _) => paired(rich, simple),
            (true, true) => tolerated(rich, simple),
            // The ends of runs have errors of the reference, in which no model differs.
            (true, false) => margin(rich, simple),
        };
        exceeds(rich, simple, margin)
    }) || innovations.any(|(rich, simple)| exceeds(rich, simple, paired(rich, simple)))
}

/// Whether terms without a name, which model `rich` has beyond `simple`, lower an error that its user has. Readings alone do not
/// tell: where a driver holds the noise of what it drives, as a speed that noisy wheels say does, a spline takes some of it up.
fn pays(rich: &Standing<'_>, simple: &Standing<'_>) -> bool {
    rich.unnamed <= simple.unnamed
        || rich
            .metrics
            .iter()
            .zip(simple.metrics)
            .any(|(rich, simple)| simple.errors.beyond(&rich.errors).0 > paired(rich, simple))
}

/// Index of the model to report.
pub(crate) fn choose(path: &[Standing<'_>]) -> usize {
    let Some(first) = path.first() else { return 0 };
    let simpler = |index: usize| {
        (0..path.len()).filter(move |&other| path[other].numbers < path[index].numbers)
    };
    let is_sound = |index: usize| {
        let stands = |other: usize| {
            pays(&path[index], &path[other]) && !is_worse(&path[index], &path[other])
        };
        simpler(index).all(stands)
    };
    let mut order: Vec<usize> = (0..path.len()).collect();
    order.sort_by_key(|&index| (path[index].numbers, index));
    let innovations: Vec<&Metric> = path.iter().filter_map(|one| one.innovation).collect();
    let is_within = |one: &Metric, best: &Metric, margin: f64| {
        one.errors.mean_square() - best.errors.mean_square() <= margin
    };
    let as_good = |index: usize| {
        let mut metrics = 0..first.metrics.len();
        let innovation = innovations.get(index);
        metrics.all(|metric| {
            let best = &path[best(path, metric)].metrics[metric];
            let one = &path[index].metrics[metric];
            is_within(one, best, margin(one, best))
        }) && innovation.is_none_or(|one| {
            let best = innovations[best_of(&innovations)];
            is_within(one, best, paired(one, best))
        })
    };
    if let Some(&found) = order.iter().find(|&&index| as_good(index) && is_sound(index)) {
        return found;
    }
    // No model is best in every metric: of those that are not worse than a simpler one, the model with the largest
    // total fall leads, and the simplest that is about as good wins.
    let fall = |index: usize| -> f64 {
        let all = |one: Standing<'_>| -> Vec<f64> {
            one.metrics.iter().chain(one.innovation).map(|metric| metric.errors.rmse()).collect()
        };
        let pairs = all(path[index]).into_iter().zip(all(*first));
        pairs.map(|(one, plain)| (plain / one.max(f64::MIN_POSITIVE)).ln()).sum()
    };
    let sound: Vec<usize> = order.into_iter().filter(|&index| is_sound(index)).collect();
    let most = sound.iter().map(|&index| fall(index)).fold(0.0, f64::max);
    sound.into_iter().find(|&index| fall(index) >= FALL_SHARE * most).unwrap_or(0)
}

/// Index of the model to report, and the errors of the choice itself: a model whose choice does not predict runs that took no part
/// in it better than the plain one gives way to a simpler one.
pub(crate) fn confirmed(path: &[Standing<'_>]) -> (usize, Vec<Metric>) {
    let mut seen = path;
    loop {
        let chosen = choose(seen);
        // Without an effect, nothing was chosen that single folds could have chosen otherwise.
        if chosen == 0 {
            return (0, path.first().map_or_else(Vec::new, |plain| plain.metrics.to_vec()));
        }
        let errors = nested(seen);
        if confirms(&errors, &path[0]) {
            return (chosen, errors);
        }
        let simpler = path.iter().take_while(|one| one.numbers < path[chosen].numbers).count();
        seen = &path[..simpler.min(seen.len() - 1)];
    }
}

/// Whether nested `errors` are below those of the `plain` model in some metric, beyond the standard error of the difference. Where
/// the residual is noise, what is new in a reading tells more, and the ends of runs do not see all: on a closed lap a distance
/// that is wrong ends where it begins. These only must not contradict.
fn confirms(errors: &[Metric], plain: &Standing<'_>) -> bool {
    let mut pairs = errors.iter().zip(plain.metrics);
    let falls = |(nested, plain): (&Metric, &Metric)| {
        plain.errors.beyond(&nested.errors).0 > paired(nested, plain)
    };
    let rises = |(nested, plain): (&Metric, &Metric)| {
        nested.errors.beyond(&plain.errors).0 > margin(nested, plain)
    };
    let tells_part = plain.innovation.is_some() || !plain.of_readings;
    pairs.clone().any(falls) || tells_part && !pairs.any(rises)
}

/// Errors of the choice itself: for each run, those of the model that would be chosen without the fold that held the
/// run out.
fn nested(path: &[Standing<'_>]) -> Vec<Metric> {
    let Some(first) = path.first() else { return Vec::new() };
    let folds = first.metrics.iter().map(|metric| metric.errors.folds).max().unwrap_or(0);
    let mut found: Vec<Metric> = first
        .metrics
        .iter()
        .map(|metric| Metric { errors: Errors::default(), ..metric.clone() })
        .collect();
    for fold in 0..folds {
        let part = |metric: &Metric, held_out: bool| Metric {
            errors: metric.errors.part(fold, held_out),
            ..metric.clone()
        };
        let seen: Vec<(Vec<Metric>, Option<Metric>)> = path
            .iter()
            .map(|one| {
                let metrics = one.metrics.iter().map(|metric| part(metric, false)).collect();
                (metrics, one.innovation.map(|metric| part(metric, false)))
            })
            .collect();
        let standings: Vec<Standing<'_>> = path
            .iter()
            .zip(&seen)
            .map(|(one, (metrics, innovation))| Standing {
                numbers: one.numbers,
                unnamed: one.unnamed,
                metrics,
                innovation: innovation.as_ref(),
                of_readings: one.of_readings,
            })
            .collect();
        let chosen = path[choose(&standings)];
        for (sum, metric) in found.iter_mut().zip(chosen.metrics) {
            sum.errors.join(part(metric, true).errors);
        }
    }
    found
}

/// Share of the largest fall that is enough if metrics disagree.
const FALL_SHARE: f64 = 0.95;

#[cfg(test)]
mod tests {
    use super::{Standing, choose, confirmed, is_worse, nested};
    use crate::judge::{Errors, Metric};

    use proptest::prelude::*;

    fn metric(squares: &[f64]) -> Metric {
        let runs = squares.iter().enumerate().map(|(run, square)| (run, *square, 1.0)).collect();
        Metric {
            name: "any".to_owned(),
            unit: crate::dataset::Unit::Metre.into(),
            errors: Errors {
                held_by: (0..squares.len()).map(|run| run % 5).collect(),
                runs,
                folds: 5,
            },
        }
    }

    /// The model that is chosen; the last metric is the innovation if the residual `is_noise`.
    fn chosen(path: &[Vec<Metric>], is_noise: bool) -> usize {
        choose(&standings(path, is_noise))
    }

    fn standings(path: &[Vec<Metric>], is_noise: bool) -> Vec<Standing<'_>> {
        let ends = path.first().map_or(0, |all| all.len() - usize::from(is_noise));
        path.iter()
            .enumerate()
            .map(|(numbers, all)| Standing {
                numbers,
                unnamed: 0,
                metrics: &all[..ends],
                innovation: all.get(ends),
                of_readings: true,
            })
            .collect()
    }

    #[test]
    fn the_simplest_within_a_standard_error_is_chosen() {
        let path = [
            vec![metric(&[90.0, 110.0, 100.0, 100.0])],
            vec![metric(&[10.0, 14.0, 12.0, 11.0])],
            vec![metric(&[9.9, 13.9, 11.9, 10.9])],
        ];
        // A little better in every run: it counts if the residual is noise, and does not otherwise.
        assert_eq!(chosen(&path, true), 2);
        assert_eq!(chosen(&path, false), 1);
    }

    #[test]
    fn what_ruins_a_metric_is_not_chosen() {
        let path = [
            vec![metric(&[4.0, 4.1, 3.9, 4.0]), metric(&[4.0, 4.1, 3.9, 4.0])],
            vec![metric(&[1.0, 1.1, 0.9, 1.0]), metric(&[3.0, 3.1, 2.9, 3.0])],
            vec![metric(&[0.1, 0.2, 0.1, 0.1]), metric(&[9.0, 9.1, 8.9, 9.0])],
        ];
        assert_eq!(chosen(&path, true), 1);
        assert_eq!(chosen(&path, false), 1);
    }

    /// A plain model, and one that readings favour, whose errors in the metric are these.
    fn favoured(metric_of_rich: [f64; 4]) -> [Vec<Metric>; 2] {
        [
            vec![metric(&[4.0, 2.0, 6.0, 4.0]), metric(&[4.0, 4.2, 3.8, 4.1])],
            vec![metric(&metric_of_rich), metric(&[3.0, 3.1, 2.9, 3.2])],
        ]
    }

    /// Ends of runs have the errors of the reference there, and only contradict readings beyond these.
    #[test]
    fn where_the_residual_is_noise_readings_decide() {
        let chosen = |path: &[Vec<Metric>], is_noise: bool| {
            let mut ends = standings(path, is_noise);
            ends.iter_mut().for_each(|one| one.of_readings = false);
            choose(&ends)
        };
        let unlucky = favoured([4.4, 2.5, 6.5, 4.5]);
        assert_eq!((chosen(&unlucky, true), chosen(&unlucky, false)), (1, 0));
        let bad = favoured([8.0, 6.0, 9.0, 7.0]);
        assert_eq!((chosen(&bad, true), chosen(&bad, false)), (0, 0));
    }

    /// Errors of readings may rise by a twentieth, a tenth of their squares.
    #[test]
    fn readings_favour_no_term_that_raises_their_own_errors() {
        assert_eq!(chosen(&favoured([4.1, 2.1, 6.2, 4.1]), true), 1);
        assert_eq!(chosen(&favoured([4.4, 2.5, 6.5, 4.5]), true), 0);
    }

    #[test]
    fn a_spline_lowers_an_error_that_its_user_has() {
        let readings = |one: f64| metric(&[one, one + 0.1, one - 0.1, one]);
        let path = [
            vec![metric(&[4.0, 2.0, 6.0, 4.0]), readings(4.0)],
            vec![metric(&[4.1, 2.0, 5.9, 4.0]), readings(3.0)],
        ];
        let mut standings = standings(&path, true);
        assert_eq!(choose(&standings), 1);
        standings[1].unnamed = 1;
        assert_eq!(choose(&standings), 0);
    }

    /// Better in four of five runs and bad in one: without any of the four, the plain model is chosen.
    #[test]
    fn a_choice_that_other_runs_do_not_confirm_gives_way() {
        let metrics = |rich: &[f64]| [vec![metric(&[10.0; 5])], vec![metric(rich)]];
        let unsure = metrics(&[4.0, 4.0, 4.0, 4.0, 17.0]);
        let standings = standings(&unsure, false);
        assert_eq!(choose(&standings), 1);
        assert_eq!(confirmed(&standings).0, 0);
        let sure = metrics(&[4.0, 4.2, 3.8, 4.1, 12.0]);
        assert_eq!(confirmed(&self::standings(&sure, false)).0, 1);
        // Where the ends of runs have the same errors, they do not contradict readings.
        let blind = [9.0, 3.0].map(|new| vec![metric(&[10.0; 5]), metric(&[new; 5])]);
        let mut ends = self::standings(&blind, true);
        ends.iter_mut().for_each(|one| one.of_readings = false);
        assert_eq!(confirmed(&ends).0, 1);
    }

    #[test]
    fn errors_of_the_choice_are_those_of_models_that_did_not_see_the_run() {
        // The second model is better in all runs but the last.
        let path =
            [vec![metric(&[4.0, 4.2, 3.8, 4.1, 3.9])], vec![metric(&[1.0, 1.1, 0.9, 1.0, 8.0])]];
        let errors = &nested(&standings(&path, false))[0].errors;
        let last = errors.runs.iter().find(|run| run.0 == 4).map(|run| run.1);
        assert_eq!(
            (errors.runs.len(), last),
            (5, Some(8.0)),
            "chosen without the run that it fails in"
        );
    }

    proptest! {
        #[test]
        fn never_worse_than_a_simpler_one(
            squares in prop::collection::vec(prop::collection::vec(0.01_f64..10.0, 12), 1..7),
            is_noise: bool,
        ) {
            let path: Vec<Vec<Metric>> = squares
                .iter()
                .map(|all| vec![metric(&all[..6]), metric(&all[6..])])
                .collect();
            let found = chosen(&path, is_noise);
            let standings = standings(&path, is_noise);
            for simple in &standings[..found] {
                prop_assert!(!is_worse(&standings[found], simple));
            }
        }
    }
}
