//! Wheels that slip at random turn a robot for good: its positions follow, and no cause is behind it.

use evaluation::catalogue::{Case, Purpose, nulls};
use evaluation::noise::Noise;
use evaluation::run::dataset;
use identification::identify::{Options, identify};

#[test]
fn wheels_that_slip_at_random_have_no_cause() {
    let is_slipping = |case: &Case| case.purpose == Purpose::Null(Noise::Slip);
    let cases: Vec<Case> = nulls(1).into_iter().filter(is_slipping).collect();
    assert!(!cases.is_empty());
    for case in cases {
        let found = identify(&dataset(&case).unwrap(), None, &Options::default(), &mut |_, _| ());
        let effects = found.unwrap().finding.effects;
        assert_eq!(effects, [], "{}", case.name());
    }
}
