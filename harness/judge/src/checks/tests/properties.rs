//! Invariants for all bands and all observations.

use super::{Observation, Verdict, declared, judge, observation};
use plan::Declared;
use proptest::prelude::*;

/// Rank of a verdict; higher is better.
fn rank(verdict: Verdict) -> u8 {
    match verdict {
        Verdict::Unset | Verdict::NotJudged | Verdict::Fail => 0,
        Verdict::Marginal => 1,
        Verdict::Pass => 2,
    }
}

/// Every kind of check, with this band if it has one.
fn checks(lower: f64, upper: f64) -> Vec<Declared> {
    let band = format!("[{lower:?}, {upper:?}]");
    let error = [
        format!("{{ all_within = {band} }}"),
        format!("{{ share_within = {{ share = 0.5, band = {band} }} }}"),
        format!("{{ all_but_within = {{ count = 2, band = {band} }} }}"),
        format!("{{ mean_within = {band} }}"),
        format!("{{ rms_within = {band} }}"),
        format!("{{ rms_ratio_within = {{ to = \"table.angle\", band = {band} }} }}"),
        format!("{{ slope_within = {{ against = \"temperature\", band = {band} }} }}"),
        format!("{{ intercept_within = {{ against = \"temperature\", band = {band} }} }}"),
        format!("{{ correlation_within = {{ against = \"temperature\", band = {band} }} }}"),
        format!("{{ eventually_within = {{ band = {band}, within_s = 5 }} }}"),
        format!("{{ never_outside = {{ band = {band}, during = \"turn\" }} }}"),
        format!(
            "{{ umbmark_within = {{ figure = \"e_max_syst\", y = \"table.angle\", band = {band} }} }}"
        ),
        format!(
            "{{ umbmark_within = {{ figure = \"beta\", y = \"table.angle\", band = {band} }} }}"
        ),
    ];
    let side = upper - lower + 1e-3;
    let square = format!(
        "{{ all_but_in_square = {{ count = 2, side_m = {side:?}, y = \"table.angle\" }} }}"
    );
    error.iter().chain([&square]).map(|check| declared("table.error", check)).collect()
}

fn observations() -> impl Strategy<Value = Vec<Observation>> {
    let one = (-2.0f64..2.0, -2.0f64..2.0, 0.0f64..0.3, 15.0f64..45.0, any::<bool>());
    prop::collection::vec(one, 0..12).prop_map(|all| {
        let both = |(index, (x, y, uncertainty, temperature, ccw)): (usize, _)| {
            let (time, direction) = (index as f64, if ccw { 1.0 } else { -1.0 });
            let tags = [
                ("during.turn", 1.0),
                ("run", time),
                ("time", time),
                ("temperature", temperature),
                ("direction", direction),
            ];
            [
                observation("table.error", x, uncertainty, &tags),
                observation("table.angle", y, uncertainty, &tags),
            ]
        };
        all.into_iter().enumerate().flat_map(both).collect()
    })
}

proptest! {
    #[test]
    fn a_smaller_band_is_never_easier(
        observations in observations(), lower in -2.0f64..0.0, upper in 0.0f64..2.0,
        cut_below in 0.0f64..1.0, cut_above in 0.0f64..1.0,
    ) {
        let shrunk = checks(lower * (1.0 - cut_below), upper * (1.0 - cut_above));
        for (wide, narrow) in checks(lower, upper).iter().zip(&shrunk) {
            let (wide, narrow) = (judge(wide, &observations), judge(narrow, &observations));
            prop_assert!(rank(narrow.verdict) <= rank(wide.verdict), "{wide:?} {narrow:?}");
        }
    }

    #[test]
    fn the_order_of_observations_is_irrelevant(
        (observations, shuffled) in observations()
            .prop_flat_map(|all| (Just(all.clone()), Just(all).prop_shuffle())),
    ) {
        for declared in checks(-1.0, 1.0) {
            prop_assert_eq!(judge(&declared, &observations), judge(&declared, &shuffled));
        }
    }

    #[test]
    fn all_are_within_when_each_is(observations in observations(), reach in 0.0f64..2.0) {
        let all = declared("table.error", &format!("{{ all_within = [{:?}, {reach:?}] }}", -reach));
        let errors: Vec<_> = observations.iter().filter(|o| o.quantity == "table.error").collect();
        prop_assume!(!errors.is_empty());
        let verdict = judge(&all, &observations).verdict;
        let inside = errors.iter().all(|o| o.value.abs() <= reach);
        let clear = errors.iter().all(|o| reach - o.value.abs() >= 2.0 * o.uncertainty);
        prop_assert_eq!(verdict.is_acceptable(), inside);
        prop_assert_eq!(verdict == Verdict::Pass, clear);
    }

    #[test]
    fn nothing_that_is_no_number_passes(
        observations in observations(), at in any::<prop::sample::Index>(),
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
        in_uncertainty in any::<bool>(),
    ) {
        prop_assume!(!observations.is_empty());
        let mut observations = observations;
        // Observations with even index are of the measured quantity.
        let at = at.index(observations.len() / 2) * 2;
        let place = &mut observations[at];
        *(if in_uncertainty { &mut place.uncertainty } else { &mut place.value }) = bad;
        for declared in checks(-400.0, 400.0) {
            let measured = judge(&declared, &observations);
            prop_assert!(!measured.verdict.is_acceptable(), "{measured:?}");
            prop_assert_eq!(measured.value, None);
        }
    }

    #[test]
    fn no_numbers_make_it_panic(
        values in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>()), 0..8),
    ) {
        let observations: Vec<_> = values.iter().flat_map(|&(x, y, uncertainty, tag)| {
            let tags = [("temperature", tag), ("time", tag), ("direction", tag), ("during.turn", tag)];
            [observation("table.error", x, uncertainty, &tags),
             observation("table.angle", y, uncertainty, &tags)]
        }).collect();
        for declared in checks(-1.0, 1.0) {
            let value = judge(&declared, &observations).value;
            prop_assert!(value.is_none_or(f64::is_finite));
        }
    }
}
