//! The manager on a rig of emulated cells and charger, in virtual time: the correct manager passes, the relevant
//! measurement finds each planted mistake, and a campaign finds a mistake that only faults of the bus reveal.

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

/// The properties that broke.
fn broken(run: &TrialRun) -> Vec<&str> {
    let broken = run.summary().properties.iter().filter(|one| one.is_broken());
    broken.map(|one| one.name.as_str()).collect()
}

#[test]
fn each_mistake_is_found_by_the_line_that_is_about_it_and_by_none_else() -> Result<(), TrialError> {
    for plan in ["deadlines.toml", "silence.toml"] {
        let sound = run(plan, None)?;
        assert!(sound.passed(), "{sound}");
        assert!(sound.summary().properties.iter().all(|one| one.held == Some(true)), "{sound}");
    }
    for (mistake, plan, expected) in [
        (Mistake::NoDerating, "deadlines.toml", "derates when it is warm"),
        (Mistake::OpensLate, "deadlines.toml", "opens on over-voltage"),
        (Mistake::StuckCounter, "deadlines.toml", "counts"),
        (Mistake::SkipsPrecharge, "deadlines.toml", "charges behind a precharge"),
        (Mistake::LongTimeOut, "silence.toml", "opens when the cells fall silent"),
    ] {
        let run = run(plan, Some(mistake))?;
        assert_eq!(broken(&run), [expected], "{mistake:?}: {run}");
    }
    // Without faults this mistake does not show.
    let hidden = run("deadlines.toml", Some(Mistake::TrustsAfterError))?;
    assert!(hidden.passed(), "{hidden}");
    let late = run("charge.toml", Some(Mistake::OpensLate))?;
    assert_eq!(failed(&late), ["opens_in_time"], "{late}");
    let gives_up = run("charge.toml", Some(Mistake::GivesUp))?;
    assert_eq!(failed(&gives_up), ["stays_closed"], "{gives_up}");
    Ok(())
}

/// A wrong checksum followed by a counter that stands still: neither alone shows the mistake, and the correct manager
/// withstands both.
#[test]
fn a_campaign_finds_a_mistake_that_takes_two_faults() -> Result<(), TrialError> {
    const SILENT: &str = "opens when the cells fall silent";
    let trial = Trial::load("deadlines.toml")?
        .with_node("manager", || Manager::new(Some(Mistake::TrustsAfterError)));
    let findings =
        trial.campaign().faults(&["wrong_checksum", "stuck_counter"]).cases(300).run()?;
    let found = findings.smallest().iter().find(|one| one.property == SILENT);
    let found = found.unwrap_or_else(|| panic!("{findings}"));
    assert_eq!(found.plan.matches("[[fault]]").count(), 2, "{}", found.plan);
    for kind in ["wrong_checksum", "stuck_counter"] {
        assert!(found.plan.contains(kind), "{}", found.plan);
    }
    let path = found.path.to_str().unwrap_or_default();
    let again = |mistake: Option<Mistake>| {
        Trial::load(path)?
            .with_seed(found.seed)
            .with_node("manager", move || Manager::new(mistake))
            .run()
    };
    assert!(broken(&again(Some(Mistake::TrustsAfterError))?).contains(&SILENT));
    assert!(!broken(&again(None)?).contains(&SILENT));
    Ok(())
}

#[test]
fn a_campaign_looks_for_faults_that_break_a_deadline() -> Result<(), TrialError> {
    let trial = Trial::load("deadlines.toml")?.with_node("manager", || Manager::new(None));
    let findings = trial.campaign().faults(&["disconnect", "delay"]).cases(60).run()?;
    let found: Vec<&str> = findings.smallest().iter().map(|one| one.property.as_str()).collect();
    // A manager that does not receive the over-voltage cannot open: no manager could.
    assert!(found.contains(&"opens on over-voltage"), "{findings}");
    // No fault of the bus makes it request more than permitted.
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
    // A manager that falls silent, or does not receive the cells, cannot open in time.
    assert!(!findings.held(), "{findings}");
    Ok(())
}
