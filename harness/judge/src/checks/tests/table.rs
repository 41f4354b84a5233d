//! A table of inputs and expected verdicts.

use super::{Verdict, declared, judge, judged, observation, table_errors, verdict};
use crate::checks::judge_all;
use Verdict::{Fail, Marginal, Pass, Unset};
use plan::Declared;
use plan::observation::Observation;
use record::outcome::Outcome;

#[test]
fn verdicts_on_single_values_and_shares() {
    let ten = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.3];
    let all = "{ all_within = [-0.25, 0.25] }";
    let nine_tenths = "{ share_within = { share = 0.9, band = [-0.1, 0.1] } }";
    let but_one = "{ all_but_within = { count = 1, band = [-0.1, 0.1] } }";
    for (check, values, uncertainty, expected) in [
        (all, &[-0.25, 0.25][..], 0.0, Pass),
        (all, &[0.0, 0.2], 0.02, Pass),
        (all, &[0.0, 0.2], 0.03, Marginal),
        (all, &[0.0, 0.2500001], 0.0, Fail),
        (all, &[0.0, 0.26], 1.0, Fail),
        (all, &[0.0, f64::NAN], 0.0, Fail),
        (all, &[f64::INFINITY], 0.0, Fail),
        (all, &[], 0.0, Unset),
        ("{ all_within = { at_most = 0 } }", &[-1e9, 0.0], 0.0, Pass),
        ("{ all_within = { at_least = 0 } }", &[-1e-9], 0.0, Fail),
        (nine_tenths, &ten, 0.001, Pass),
        (nine_tenths, &ten, 0.011, Marginal),
        ("{ share_within = { share = 0.91, band = [-0.1, 0.1] } }", &ten, 0.0, Fail),
        ("{ share_within = { share = 0.91, band = [-0.1, 0.1] } }", &ten, 9.0, Fail),
        (but_one, &ten, 0.001, Pass),
        (but_one, &ten, 0.011, Marginal),
        ("{ all_but_within = { count = 0, band = [-0.1, 0.1] } }", &ten, 0.0, Fail),
        (but_one, &[0.3], 0.0, Unset),
        (but_one, &[0.3, 0.0], 0.0, Pass),
    ] {
        assert_eq!(
            verdict(check, &table_errors(values, uncertainty)),
            expected,
            "{check} {values:?}"
        );
    }
}

/// Found by a user: a device that was silent for a minute had nearly all of its messages in time.
#[test]
fn a_share_of_periods_is_a_share_of_the_time() {
    let check = "{ share_within = { share = 0.9, band = [0.09, 0.11] } }";
    let judged = |quantity: &str, silent_s: f64| {
        let periods = std::iter::repeat_n(0.1, 900).chain([silent_s]);
        let observed = periods.map(|value| observation(quantity, value, 0.0, &[]));
        judge(&declared(quantity, check), &Vec::from_iter(observed)).verdict
    };
    assert_eq!(judged("period.a.M", 9.9), Pass);
    assert_eq!(judged("period.a.M", 10.1), Fail);
    assert_eq!(judged("table.turn_error", 60.0), Pass);
}

#[test]
fn verdicts_on_moments_and_lines() {
    // Mean 2, standard uncertainty 1 / sqrt(3) = 0.577, widened by 2.195 for three values.
    let three = [1.0, 2.0, 3.0];
    // Exactly -0.52 T + 19.23; readings of +-0.1: u(slope) = 0.1 / sqrt(sum (T - Tm)^2) = 0.1 / sqrt(10).
    let line: Vec<f64> = (0..5).map(|i| 19.23 - 0.52 * (20.0 + f64::from(i))).collect();
    let slope = "{ slope_within = { against = \"temperature\", band = [-0.54, -0.50] } }";
    let intercept = "{ intercept_within = { against = \"temperature\", band = [18, 20] } }";
    let tracks = "{ correlation_within = { against = \"temperature\", band = [-1, -0.9] } }";
    for (check, values, uncertainty, expected) in [
        ("{ mean_within = [-0.6, 4.6] }", &three[..], 0.1, Pass),
        ("{ mean_within = [1.0, 3.0] }", &three, 0.1, Marginal),
        ("{ mean_within = [0, 1.9] }", &three, 0.1, Fail),
        ("{ rms_within = { at_most = 2.1 } }", &three, 0.0, Fail),
        ("{ rms_within = { at_most = 2.2 } }", &three, 0.0, Marginal),
        ("{ rms_within = { at_most = 9 } }", &three, 0.0, Pass),
        (slope, &line, 0.01, Pass),
        (slope, &line, 0.1, Marginal),
        (slope, &three, 0.0, Fail),
        (slope, &line[..1], 0.0, Unset),
        (intercept, &line, 0.01, Pass),
        (intercept, &line, 0.1, Marginal),
        (tracks, &line, 0.0, Pass),
        (tracks, &three, 0.0, Fail),
        (tracks, &[1.0, 1.0, 1.0], 0.0, Unset),
        (tracks, &three[..2], 0.0, Unset),
        ("{ slope_within = { against = \"age\", band = [0, 1] } }", &line, 0.0, Fail),
    ] {
        assert_eq!(
            verdict(check, &table_errors(values, uncertainty)),
            expected,
            "{check} {values:?}"
        );
    }
}

#[test]
fn verdicts_on_settling() {
    let values = [5.0, 3.0, 0.5, 3.0, 0.8, 0.2, 0.1];
    for (within, uncertainty, expected) in
        [(4.0, 0.0, Pass), (3.9, 0.0, Fail), (4.0, 0.15, Marginal), (5.0, 0.15, Pass)]
    {
        let check = format!("{{ eventually_within = {{ band = [-1, 1], within_s = {within} }} }}");
        let measured = judged(&check, &table_errors(&values, uncertainty));
        assert_eq!((measured.verdict, measured.value), (expected, Some(4.0)), "{check}");
    }
    let check = "{ eventually_within = { band = [-1, 1], within_s = 100 } }";
    assert_eq!(verdict(check, &table_errors(&[0.0, 0.0, 2.0], 0.0)), Fail);
}

#[test]
fn a_phase_must_have_been_seen() {
    let during = |value, phase| observation("table.error", value, 0.0, &[(phase, 1.0)]);
    let check = "{ never_outside = { band = [-0.3, 0.3], during = \"straight\" } }";
    let (inside, outside) = (during(0.2, "during.straight"), during(0.9, "during.straight"));
    let elsewhere = during(0.9, "during.turn");
    assert_eq!(verdict(check, &[inside.clone(), elsewhere.clone()]), Pass);
    assert_eq!(verdict(check, &[inside, outside]), Fail);
    assert_eq!(verdict(check, &[elsewhere]), Unset);
}

/// Return positions of laps, alternately cw and ccw.
fn returns(positions: &[(f64, f64)], uncertainty: f64) -> Vec<Observation> {
    let lap = |(index, &(x, y)): (usize, &(f64, f64))| {
        let direction = if index % 2 == 0 { -1.0 } else { 1.0 };
        let tags = [("run", (index / 2) as f64), ("direction", direction)];
        [("lap.return_x", x), ("lap.return_y", y)]
            .map(|(quantity, value)| observation(quantity, value, uncertainty, &tags))
    };
    positions.iter().enumerate().flat_map(lap).collect()
}

#[test]
fn verdicts_on_return_positions() {
    let square = declared(
        "lap.return_x",
        "{ all_but_in_square = { count = 1, side_m = 0.1, y = \"lap.return_y\" } }",
    );
    let good = [(0.0, 0.0), (0.04, -0.04), (-0.05, 0.05), (0.2, 0.0)];
    for (positions, uncertainty, expected) in [
        (&good[..], 0.0, Pass),
        (&good, 0.002, Marginal),
        (&[(0.0, 0.051), (0.051, 0.0), (0.0, 0.0)], 0.0, Fail),
        (&[], 0.0, Unset),
    ] {
        let measured = judge(&square, &returns(positions, uncertainty));
        assert_eq!(measured.verdict, expected, "{positions:?}");
    }
    let mut unpaired = returns(&good, 0.0);
    unpaired.pop();
    assert_eq!(judge(&square, &unpaired).verdict, Fail);

    let alpha = "{ umbmark_within = { figure = \"alpha\", y = \"lap.return_y\", band = [0, 1] } }";
    let umbmark = declared("lap.return_x", alpha);
    // alpha = (-0.12 + 0.04) / -16 rad = 0.286 deg; a single direction gives no alpha.
    let both = judge(&umbmark, &returns(&[(-0.12, -0.05), (0.04, 0.03)], 0.002));
    assert!((both.value.unwrap() - 0.005f64.to_degrees()).abs() < 1e-12);
    assert_eq!(both.verdict, Pass);
    assert_eq!(judge(&umbmark, &returns(&[(-0.12, -0.05)], 0.002)).verdict, Unset);
}

#[test]
fn one_method_is_better_than_another() {
    let ratio = "{ rms_ratio_within = { to = \"bias.residual_table\", band = { at_most = 1 } } }";
    let better = declared("bias.residual_test", ratio);
    let observations = |ours: f64, theirs: f64| {
        let noisy = |quantity: &str, scale: f64| {
            [1.0, -1.1, 0.9, -1.0].map(|value| observation(quantity, scale * value, 0.0, &[]))
        };
        [noisy("bias.residual_test", ours), noisy("bias.residual_table", theirs)].concat()
    };
    for (ours, theirs, expected) in
        [(1.0, 2.0, Pass), (1.0, 1.02, Marginal), (2.0, 1.0, Fail), (1.0, 0.0, Fail)]
    {
        assert_eq!(
            judge(&better, &observations(ours, theirs)).verdict,
            expected,
            "{ours} {theirs}"
        );
    }
    assert_eq!(judge(&better, &observations(1.0, 2.0)[..4]).verdict, Unset);
}

#[test]
fn too_few_observations_are_unset() {
    let mut few = declared("table.error", "{ all_within = [-1, 1] }");
    few.observations_min = 3.try_into().unwrap();
    let observations = table_errors(&[0.0, 0.0, 0.0], 0.0);
    assert_eq!(judge(&few, &observations).verdict, Pass);
    assert_eq!(judge(&few, &observations[..2]).verdict, Unset);
    // What is outside is outside.
    let outside = judge(&few, &table_errors(&[0.0, 4.0], 0.0));
    assert_eq!((outside.verdict, outside.value), (Fail, Some(4.0)));
    let mut mean = declared("table.error", "{ mean_within = [-1, 1] }");
    mean.observations_min = 3.try_into().unwrap();
    assert_eq!(judge(&mean, &table_errors(&[0.0, 4.0], 0.0)).verdict, Unset);
}

#[test]
fn a_plan_passes_when_all_its_measurements_do() {
    let observations = table_errors(&[0.0], 0.0);
    let good = declared("table.error", "{ all_within = [-1, 1] }");
    let unset = declared("lap.gyro_error", "{ all_within = [-1, 1] }");
    let outcome = |declared: &[Declared]| judge_all(declared, &observations.iter().collect()).1;
    assert_eq!(outcome(&[good.clone(), good.clone()]), Outcome::Passed);
    assert_eq!(outcome(&[good, unset]), Outcome::Failed);
}

#[test]
fn what_is_judged_is_said() {
    let values = [0.1, -0.22, 0.05, 0.18, -0.03, 0.24];
    let observations = table_errors(&values, 0.02);
    let mut broken = observations.clone();
    broken[2].value = f64::NAN;
    let lines: Vec<_> = [
        ("{ all_within = [-0.25, 0.25] }", &observations),
        ("{ share_within = { share = 0.6, band = [-0.2, 0.2] } }", &observations),
        ("{ all_but_within = { count = 2, band = [-0.2, 0.2] } }", &observations),
        ("{ mean_within = { at_most = 0.1 } }", &observations),
        ("{ rms_within = { at_most = 0.2 } }", &observations),
        ("{ slope_within = { against = \"temperature\", band = [-0.1, 0.1] } }", &observations),
        ("{ intercept_within = { against = \"temperature\", band = [-9, 9] } }", &observations),
        ("{ correlation_within = { against = \"temperature\", band = [-1, 1] } }", &observations),
        ("{ eventually_within = { band = [-0.23, 0.3], within_s = 10 } }", &observations),
        ("{ never_outside = { band = [-1, 1], during = \"lap\" } }", &observations),
        ("{ all_within = [-1, 1] }", &broken),
        ("{ slope_within = { against = \"age\", band = [-1, 1] } }", &observations),
    ]
    .into_iter()
    .map(|(check, observations)| {
        let m = judged(check, observations);
        let value = m.value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        let bound = |bound: Option<f64>| bound.map_or("..".to_owned(), |bound| bound.to_string());
        format!(
            "{:<9} {value:>8} +- {:<7.4} {:>5} to {:<5} {}",
            format!("{:?}", m.verdict).to_lowercase(),
            m.uncertainty,
            bound(m.lower),
            bound(m.upper),
            m.statistic,
        )
    })
    .collect();
    insta::assert_snapshot!(lines.join("\n"));
}

#[test]
fn a_band_that_holds_the_references_error_is_not_narrowed_by_it_again() {
    let observed = table_errors(&[0.1, 0.9], 0.16);
    let mut declared = declared("table.error", "{ all_within = [-1, 1] }");
    assert_eq!(judge(&declared, &observed).verdict, Verdict::Marginal);
    declared.band_holds_reference = true;
    let judged = judge(&declared, &observed);
    assert_eq!(
        (judged.verdict, judged.value, judged.uncertainty),
        (Verdict::Pass, Some(0.9), 0.16)
    );
    assert_eq!(judge(&declared, &table_errors(&[0.1, 1.1], 0.16)).verdict, Verdict::Fail);
}
