//! The online evaluation equals the definition at every moment, in truth and robustness.

mod common;

use common::form::form;
use common::reference::evaluate;
use common::trace::{online, parsed, rows, trace, value};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, max_global_rejects: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn the_evaluator_says_what_the_definition_says(
        form in form(),
        trace in any::<bool>().prop_flat_map(|is_gappy| trace(1..40, is_gappy)),
    ) {
        let formula = parsed(&form, 1);
        prop_assert_eq!(formula.horizon().as_nanos(), form.horizon());
        let mut expected = evaluate(&form, &rows(&trace, form.horizon() + 1));
        expected.truncate(trace.len());
        let found: Vec<_> = online(&formula, &trace, 1).into_iter().map(value).collect();
        prop_assert_eq!(found, expected, "{}", form.text(1));
    }

    /// If nothing in the formula lasts a nanosecond, a step may have any length.
    #[test]
    fn steps_may_be_long(form in form(), trace in trace(1..30, true), step in 2..2_000_000i64) {
        prop_assume!(form.is_coarse());
        let found = online(&parsed(&form, step), &trace, step);
        prop_assert_eq!(found, online(&parsed(&form, 1), &trace, 1), "{}", form.text(step));
    }
}
