//! The manager on a rig of emulated cells and charger, in virtual time: the sound one passes, each planted mistake is found
//! by the measurement that is about it, and a campaign finds what a fault of the bus breaks.

use battery_pack::{Manager, Mistake};
use harness::{Trial, TrialError, TrialRun};

fn run(plan: &str, mistake: Option<Mistake>) -> Result<TrialRun, TrialError> {
    Trial::load(plan)?.with_node("manager", move || Manager::new(mistake)).run()
}

/// The measurements that failed.
fn failed(run: &TrialRun) -> Vec<&str> {
    let failed = run.summary().measurements.iter().filter(|one| one.verdict.name() == "fail");
    failed.map(|one| one.name.as_str()).collect()
}

#[test]
fn a_sound_manager_passes() -> Result<(), TrialError> {
    for plan in ["charge.toml", "silence.toml"] {
        let run = run(plan, None)?;
        assert!(run.passed(), "{run}");
    }
    Ok(())
}

#[test]
fn each_mistake_is_found_by_what_is_about_it() -> Result<(), TrialError> {
    for (mistake, plan, expected) in [
        (Mistake::OpensLate, "charge.toml", &["opens_in_time"][..]),
        (Mistake::ClosesAgain, "charge.toml", &["stays_open"]),
        (Mistake::LimitTooHigh, "charge.toml", &["derates"]),
    ] {
        let run = run(plan, Some(mistake))?;
        assert_eq!(failed(&run), expected, "{mistake:?}: {run}");
    }
    // What never comes is not measured: the step fails, and says which.
    for (mistake, plan, step) in [
        (Mistake::NeverOpens, "charge.toml", "ContactorClosed"),
        (Mistake::ForgetsSilence, "silence.toml", "ContactorClosed"),
    ] {
        let run = run(plan, Some(mistake))?;
        assert_eq!(run.summary().outcome.name(), "failed", "{mistake:?}: {run}");
        assert!(run.summary().reason.as_ref().is_some_and(|why| why.contains(step)), "{run}");
    }
    Ok(())
}

/// The properties that broke.
fn broken(run: &TrialRun) -> Vec<&str> {
    let broken = run.summary().properties.iter().filter(|one| one.is_broken());
    broken.map(|one| one.name.as_str()).collect()
}

#[test]
fn each_mistake_breaks_the_deadline_that_is_about_it_and_none_else() -> Result<(), TrialError> {
    let sound = run("deadlines.toml", None)?;
    assert!(sound.passed(), "{sound}");
    assert!(sound.summary().properties.iter().all(|one| one.held == Some(true)), "{sound}");
    for (mistake, expected) in [
        (Mistake::OpensLate, "opens on over-voltage"),
        (Mistake::NeverOpens, "opens on over-voltage"),
        (Mistake::ClosesAgain, "stays open"),
        (Mistake::LimitTooHigh, "keeps to the cells' rating"),
    ] {
        let run = run("deadlines.toml", Some(mistake))?;
        assert_eq!(broken(&run), [expected], "{mistake:?}: {run}");
    }
    Ok(())
}

#[test]
fn a_campaign_looks_for_faults_that_break_a_deadline() -> Result<(), TrialError> {
    let trial = Trial::load("deadlines.toml")?.with_node("manager", || Manager::new(None));
    let findings = trial.campaign().faults(&["disconnect", "delay"]).cases(60).run()?;
    let found: Vec<&str> = findings.smallest().iter().map(|one| one.property.as_str()).collect();
    // Who does not hear of an over-voltage cannot open: no manager could.
    assert!(found.contains(&"opens on over-voltage"), "{findings}");
    // No fault of the bus makes it ask for more than it may.
    assert!(!found.contains(&"keeps to the cells' rating"), "{findings}");
    Ok(())
}

#[test]
fn a_seed_gives_the_same_run_again() -> Result<(), TrialError> {
    let values = |run: TrialRun| format!("{:?}", run.summary().measurements);
    assert_eq!(values(run("charge.toml", None)?), values(run("charge.toml", None)?));
    Ok(())
}

#[test]
fn a_campaign_finds_what_a_fault_of_the_bus_breaks() -> Result<(), TrialError> {
    let trial = Trial::load("charge.toml")?.with_node("manager", || Manager::new(None));
    let findings = trial.campaign().faults(&["disconnect"]).cases(30).run()?;
    // A manager that falls silent, or does not hear the cells, cannot open in time.
    assert!(!findings.held(), "{findings}");
    Ok(())
}
