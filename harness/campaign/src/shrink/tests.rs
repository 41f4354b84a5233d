use super::change::rounded_up;
use super::shrink;
use crate::toy::{Toy, size, space};
use crate::{Executor as _, Random, Search as _};

#[test]
fn digits_are_few_and_the_value_no_less() {
    for (value, one, two) in [(0.0231, 0.03, 0.024), (97.0, 100.0, 97.0), (5.0, 5.0, 5.0)] {
        assert_eq!(rounded_up(value, 1), one);
        assert_eq!(rounded_up(value, 2), two);
    }
}

/// The toy breaks with two faults at a time: two remain, no worse than necessary.
#[test]
fn two_faults_are_left_as_weak_and_as_early_as_they_can_be() {
    let (toy, space) = (Toy::default(), space());
    let mut random = Random::new(&space, 5);
    let (mut found, mut tries) = (0, 0);
    while found < 10 {
        tries += 1;
        assert!(tries < 2000);
        let case = random.next();
        let result = toy.execute(&case);
        if !result.breaks("held") {
            continue;
        }
        found += 1;
        let shrunk = shrink(&toy, &case, &result, "held", 500);
        let faults = &shrunk.case.schedule.faults;
        assert_eq!(faults.len(), 2, "{}", shrunk.case.schedule.to_toml());
        assert!(shrunk.result.breaks("held"));
        // Within one digit of the limit at which it breaks.
        assert!(faults.iter().all(|fault| size(fault) < 0.65), "{faults:?}");
        assert!(shrunk.executions <= 500);
        assert_eq!(shrunk, shrink(&toy, &case, &result, "held", 500));
    }
}
