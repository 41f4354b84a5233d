//! Functional mock-up units in whole runs. `harness/fmu/tests` has their numbers, against FMPy, and their mistakes.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use ::fmu::samples;
use harness::TrialRun;
use harness::run::{Prepared, load_recorded};
use harness::trial::Smallest;
use plan::made::Made;
use tempfile::TempDir;
use tests::plans::record_file;
use tests::project;

const PAGE: &str = include_str!("../../docs/fmu.md");

/// The device and the plan of the page.
fn page(block: usize) -> &'static str {
    PAGE.split("```toml\n").nth(block).unwrap().split("```").next().unwrap()
}

/// The project of the page, with the oven of `version`.
fn oven(version: usize, device: &str, plan: &str) -> TempDir {
    let folder = project::of([("devices/oven.toml", device), ("heats.toml", plan)]);
    samples::oven(&folder.path().join("devices/oven.fmu"), version, str::to_owned);
    folder
}

fn run(folder: &TempDir) -> TrialRun {
    project::load(folder, "heats.toml").unwrap().run().unwrap()
}

fn prepared(folder: &TempDir) -> Prepared {
    let path = folder.path().join("heats.toml");
    Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap()
}

#[test]
fn the_plan_of_the_page_passes_with_both_versions_alike() {
    let records = [2, 3].map(|version| {
        let folder = oven(version, page(1), page(2));
        let passed = run(&folder);
        assert!(passed.passed(), "{passed}");
        let prepared = prepared(&folder);
        let once = record_file(&prepared, 1);
        assert!(once.len() > 10_000);
        assert!(once == record_file(&prepared, 1), "the second run differs");
        once
    });
    assert!(records[0] == records[1], "the versions differ");
}

#[test]
fn a_campaign_begins_its_cases_at_the_beginning_and_finds_what_a_run_reproduces() {
    let plan = format!(
        "{}[[measurement]]\nname = \"period\"\ndoc = \"Period\"\nquantity = \"period.Status\"\nunit = \"1\"\n\
         check = {{ share_within = {{ share = 1, band = [0.09, 0.11] }} }}\n",
        page(2)
    );
    let folder = oven(3, page(1), &plan);
    let trial = project::load(&folder, "heats.toml").unwrap();
    let findings = trial.campaign().faults(&["drop"]).cases(16).run().unwrap();
    assert_eq!(findings.campaign().tally.cases, 16);
    let again = trial.campaign().faults(&["drop"]).cases(16).run().unwrap();
    let smallest = findings.smallest();
    let plans = |of: &[Smallest]| of.iter().map(|one| one.plan.clone()).collect::<Vec<_>>();
    assert_eq!(plans(smallest), plans(again.smallest()));
    assert!(!smallest.is_empty(), "{findings}");
    for one in smallest {
        std::fs::write(folder.path().join("again.toml"), &one.plan).unwrap();
        let again = project::load(&folder, "again.toml").unwrap().with_seed(one.seed);
        let run = again.run().unwrap();
        assert!(!run.passed() && run.to_string().contains("period"), "{run}");
    }
}

#[test]
fn an_fmu_that_fails_ends_the_run_with_an_error_that_names_it() {
    let wrong = "parameters = { fail_at = 5, fail_how = 1, ambient";
    let device = page(1).replace("parameters = { ambient", wrong);
    let failed = run(&oven(2, &device, page(2)));
    assert!(failed.to_string().contains("error"), "{failed}");
    let expected = "`device`: `oven.fmu` at 5.02 s: fmi2DoStep returned Error: the door is open";
    assert!(failed.to_string().contains(expected), "{failed}");
    let never = page(1).replace("parameters = { ambient", &wrong.replace("how = 1", "how = 7"));
    let failed = run(&oven(3, &never, page(2)));
    assert!(failed.to_string().contains("error"), "{failed}");
    assert!(failed.to_string().contains("nothing to heat"), "{failed}");
}

#[test]
fn a_record_is_read_without_the_fmu() {
    let folder = oven(2, page(1), page(2));
    let header = prepared(&folder).header(1);
    drop(folder);
    let (_, rig) = load_recorded(&header, None).unwrap().unwrap();
    let device = rig.device().unwrap();
    assert_eq!(device.unit("temperature"), Some("degC"));
    let mut started = described::Device::new(std::sync::Arc::clone(device), 1);
    let why = started.failure(wire::time::Timestamp::ZERO).unwrap();
    assert!(why.contains("only the description of the FMU is here"), "{why}");
}

#[test]
fn a_mistake_in_the_fmu_is_shown_in_the_device_file() {
    let folder = oven(2, page(1), page(2));
    std::fs::write(folder.path().join("devices/oven.fmu"), "PK").unwrap();
    let error = project::load(&folder, "heats.toml").unwrap_err();
    let error = std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
    assert!(error.contains("oven.fmu: it is no FMU: "), "{error}");
}
