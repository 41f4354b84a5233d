//! Effects that no family of candidates can express exactly: the error falls nevertheless.

use super::{Story, unit};
use record::outcome::Outcome;

/// A sine over temperature within a bell; size: the class's 5 deg/h/K over 6 K.
#[test]
fn fringes() {
    let parameters = [
        ("fringe_bias_deg_per_h", 30.0),
        ("fringe_period_kelvin", 10.0),
        ("reference_celsius", 40.0),
    ];
    let story = Story::of(unit(&parameters));
    story.is_carried_out().falls_by(3.0);
    assert!(story.worst("before") > 3.0 * story.worst("after"), "{}", story.in_words());
}

/// A temperature coefficient that grows with time. A function of time is valid only for the hours in which it was
/// found: the test covers only those.
#[test]
fn a_coefficient_that_drifts() {
    Story::of(unit(&[("drifting_bias_deg_per_h_per_kelvin", 5.0)])).falls_by(5.0);
}

/// A cusp over the rate. The finding explains held-out turns; as it consists of two functions of the rate that cancel,
/// it is no model for a correction, and is refused.
#[test]
#[ignore = "known limit: of the seeds 1 to 8 it is explained at 2 alone; at others a dead zone takes its place"]
fn a_resonance() {
    let story = Story::of(unit(&[("resonance_ppm", 3_000.0), ("resonance_deg_per_s", 20.0)]));
    story.falls_by(10.0);
    // The error is a part in a thousand at some rates, whereas a dead zone would remove the whole rate.
    let found = story.finding().effects.iter().any(|effect| effect.name == "dead_zone");
    assert!(!found, "{}", story.in_words());
    let ending = &story.done.simulated.ending;
    let refused = ending.reason.as_ref().is_some_and(|reason| reason.contains("cannot be carried"));
    assert!(refused || ending.outcome == Outcome::Passed, "{ending:?}");
    let unread = ending.reason.as_ref().is_some_and(|reason| reason.contains("unit of its knots"));
    assert!(!unread, "a model says the unit of its knots: {ending:?}");
    assert!(story.worst("after") < story.worst("before"), "{}", story.in_words());
}
