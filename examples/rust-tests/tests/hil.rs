//! The heading unit on the bench of `hil`, in virtual time: minutes of a rate table in milliseconds.

use harness::{Trial, TrialError};
use heading_unit::HeadingUnit;

fn turns() -> Result<Trial, TrialError> {
    Ok(Trial::load("plans/turns.toml")?.with_controller(HeadingUnit::new))
}

#[test]
fn the_heading_stays_within_its_band() -> Result<(), TrialError> {
    // Each seed gives another gyro and other noise.
    for seed in 1..=5 {
        let run = turns()?.with_seed(seed).run()?;
        assert!(run.passed(), "{run}");
    }
    Ok(())
}

#[test]
fn there_is_room_to_the_band() -> Result<(), TrialError> {
    let run = turns()?.run()?;
    let worst_deg = run.value("heading_error");
    assert!(worst_deg.is_some_and(|worst_deg| worst_deg.abs() < 0.2), "{run}");
    Ok(())
}

#[test]
fn after_any_fault_of_its_line_it_works_again_or_says_so() -> Result<(), TrialError> {
    let findings = turns()?.campaign().faults(&["disconnect", "drop", "insert"]).cases(40).run()?;
    assert!(findings.held(), "{findings}");
    // A property that is never judged would also hold.
    assert!(findings.campaign().tally.nearest.contains_key("recovers"), "{findings}");
    Ok(())
}

/// The stream has no checksum: a changed digit is believed. This holds until the limit is removed.
#[test]
fn a_known_limit_flipped_bits_break_the_plan() -> Result<(), TrialError> {
    let findings = turns()?.campaign().must_pass().faults(&["flip"]).cases(10).run()?;
    let broken: Vec<_> = findings.smallest().iter().map(|one| one.property.as_str()).collect();
    assert_eq!(broken, ["passes"], "{findings}");
    std::fs::remove_dir_all(findings.folder()).expect("a folder of this test");
    Ok(())
}

#[test]
fn a_device_of_ones_own_is_tested_without_a_controller() -> Result<(), TrialError> {
    let run = Trial::load("plans/warms.toml")?.run()?;
    assert!(run.passed(), "{run}");
    Ok(())
}
