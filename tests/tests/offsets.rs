//! The offsets that `static-bias` names follow from its gyro's own model of the drift.
//!
//! A run compares windows over 3.3 h with a table that was made just before, or with no correction. The drift that does
//! not change meanwhile is an offset of all windows. Their scatter shows the rest: that of eight block means over the
//! root of eight (`harness/plan/src/check/jackknife.rs`).

use harness::run::Prepared;
use plan::check::{Check, RmsRatioWithin};
use plan::made::Made;
use tests::devices::shipped;

/// The plan: 120 tests a minute apart, and then windows over 100 times 120 s.
const TABLE_S: f64 = 7_200.0;
const COMPARED_S: f64 = 12_000.0;
const BLOCKS: usize = 8;
/// Pieces into which both are cut.
const PIECE_S: f64 = 40.0;
const PIECES: usize = ((TABLE_S + COMPARED_S) / PIECE_S) as usize;

/// Covariance of the drift at two times apart by `apart_s`, relative to its variance: evenly over the logarithm of the
/// correlation time (IEEE Std 952, bias instability).
fn correlation(apart_s: f64, shortest_s: f64, longest_s: f64) -> f64 {
    const TIMES: u32 = 40;
    let step = (longest_s / shortest_s).ln() / f64::from(TIMES);
    let time = |n: u32| shortest_s * ((f64::from(n) + 0.5) * step).exp();
    (0..TIMES).map(|n| (-apart_s / time(n)).exp()).sum::<f64>() / f64::from(TIMES)
}

/// Variance of the windows' mean minus the reference that their scatter does not show.
fn unseen(reference: &[f64], correlations: &[f64]) -> f64 {
    let variance = |weights: &[f64]| {
        let mut sum = 0.0;
        for (i, a) in weights.iter().enumerate() {
            for (j, b) in weights.iter().enumerate() {
                sum += a * b * correlations[i.abs_diff(j)];
            }
        }
        sum
    };
    let first = (TABLE_S / PIECE_S) as usize;
    let windows = PIECES - first;
    let mean: Vec<f64> =
        (0..PIECES).map(|i| f64::from(u8::from(i >= first)) / windows as f64).collect();
    let offset: Vec<f64> = mean.iter().zip(reference).map(|(mean, made)| mean - made).collect();
    let scatter: f64 = (0..BLOCKS)
        .map(|block| {
            let cut = |n: usize| first + n * windows / BLOCKS;
            let inside = cut(block)..cut(block + 1);
            let share = 1.0 / inside.len() as f64;
            let of = |i: usize| if inside.contains(&i) { share } else { 0.0 };
            let weights: Vec<f64> = (0..PIECES).map(|i| of(i) - mean[i]).collect();
            variance(&weights)
        })
        .sum();
    variance(&offset) - scatter / ((BLOCKS - 1) * BLOCKS) as f64
}

#[test]
fn the_offsets_of_static_bias_are_those_of_its_gyros_drift() {
    let gyro = shipped("paper-table").gyro.1;
    let (shortest, longest) = (gyro.bias_instability_shortest_s, gyro.bias_instability_longest_s);
    let correlations: Vec<f64> =
        (0..PIECES).map(|n| correlation(n as f64 * PIECE_S, shortest, longest)).collect();
    // At the steady temperature the table has the mean of the tests within half of its last step.
    let warming = |s: f64| gyro.self_heating_kelvin * (-s / gyro.thermal_time_constant_s).exp();
    let half_a_step = (warming(0.0) - warming(TABLE_S)) / 15.0 / 2.0;
    let in_table: Vec<f64> = (0..PIECES)
        .map(|i| i as f64 * PIECE_S)
        .map(|s| f64::from(u8::from(s < TABLE_S && warming(s) < warming(TABLE_S) + half_a_step)))
        .collect();
    let tests: f64 = in_table.iter().sum();
    let table: Vec<f64> = in_table.iter().map(|of| of / tests).collect();

    let plan = Prepared::load("static-bias", &Made::default()).expect("the plan ships").plan;
    for (name, reference) in
        [("test_against_table", table), ("test_against_none", vec![0.0; PIECES])]
    {
        let declared = plan.measurements.iter().find(|one| one.name.as_str() == name);
        let Some(Check::RmsRatioWithin(RmsRatioWithin { to_offset, .. })) =
            declared.map(|one| &one.check)
        else {
            panic!("{name} is a ratio");
        };
        let expected =
            gyro.bias_instability_rms_deg_per_s * unseen(&reference, &correlations).sqrt();
        assert!((to_offset / expected - 1.0).abs() < 0.05, "{name}: {to_offset} for {expected}");
    }
}
