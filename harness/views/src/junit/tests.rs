//! JUnit has no standard schema: these tests cover what its readers share.

use super::{campaign, document};
use crate::console::example;
use ::campaign::{Account, End};
use quick_junit::{Report, TestCaseStatus};
use record::outcome::samples::{properties, summary};
use record::outcome::{Outcome, Summary, Verdict};
use std::collections::BTreeSet;
use std::path::Path;

fn account() -> Account {
    let end = End { wall_s: 4.5, ..End::default() };
    Account { plan: "live-side".to_owned(), seed: 3, end: Some(end), ..Account::new() }
}

const FOLDER: &str = "runs/laps-observed-seed7";

#[test]
fn verdicts_become_cases() {
    // What went to its end and failed has no reason of its own.
    let failed = Summary { reason: None, ..summary() };
    insta::assert_snapshot!(document(&failed, Some(Path::new(FOLDER))).unwrap());
}

#[test]
fn a_broken_bench_is_an_error() {
    let reason = Some("gyro: \u{1b}[31mno such port <ttyUSB0>".to_owned());
    let measurements = Vec::new();
    let broken = Summary { outcome: Outcome::Error, reason, measurements, ..summary() };
    insta::assert_snapshot!(document(&broken, None).unwrap());
}

#[test]
fn a_broken_property_names_its_moment_its_seed_and_the_files() {
    let run = Summary { properties: properties(), ..summary() };
    let text = document(&run, Some(Path::new(FOLDER))).unwrap();
    let case = text.split("<testcase ").find(|case| case.contains("stops_on_loss")).unwrap();
    assert!(case.contains("at 12.500 s: moves 1.20 s after"), "{case}");
    assert!(case.contains(&format!("seed {}", run.seed)), "{case}");
    assert!(case.contains("[[ATTACHMENT|"), "{case}");
}

#[test]
fn what_no_device_of_the_bench_gives_is_skipped_with_its_reason() {
    let mut run = summary();
    run.measurements.truncate(1);
    run.measurements[0].verdict = Verdict::NotJudged;
    run.measurements[0].statistic = "the base is real".to_owned();
    let report = Report::deserialize_from_str(&document(&run, None).unwrap()).unwrap();
    let cases = &report.test_suites[0].test_cases;
    let case = cases.iter().find(|case| case.name.as_str() == run.measurements[0].name).unwrap();
    let TestCaseStatus::Skipped { message, .. } = &case.status else { panic!("{case:?}") };
    assert_eq!(message.as_ref().unwrap().as_str(), "the base is real");
}

/// For example a program under test that ended when all was measured.
#[test]
fn a_run_that_failed_for_a_reason_of_its_own_is_a_failure() {
    let reason = Some("`manager`, which is under test, exited during the run".to_owned());
    let failed =
        Summary { outcome: Outcome::Failed, reason, measurements: Vec::new(), ..summary() };
    let report = Report::deserialize_from_str(&document(&failed, None).unwrap()).unwrap();
    let TestCaseStatus::NonSuccess { message, .. } = &report.test_suites[0].test_cases[0].status
    else {
        panic!("a success")
    };
    assert!(message.as_ref().unwrap().as_str().contains("`manager`, which is under test"));
    assert_eq!((report.test_suites[0].failures, report.test_suites[0].errors), (1, 0));
}

#[test]
fn what_a_broken_bench_did_not_measure_is_skipped() {
    let mut run = Summary { outcome: Outcome::Error, ..summary() };
    for measurement in &mut run.measurements {
        (measurement.verdict, measurement.value) = (Verdict::Unset, None);
    }
    let report = Report::deserialize_from_str(&document(&run, None).unwrap()).unwrap();
    assert_eq!((report.test_suites[0].failures, report.test_suites[0].errors), (0, 1));
}

/// A program can say anything in its last words.
#[test]
fn what_xml_has_no_place_for_is_replaced() {
    let reason = Some("bad \u{FFFE}\u{FFFF}\u{0} end".to_owned());
    let xml = document(&Summary { outcome: Outcome::Error, reason, ..summary() }, None).unwrap();
    assert!(!xml.contains(['\u{FFFE}', '\u{FFFF}', '\u{0}']), "{xml}");
    assert!(xml.contains("bad \u{FFFD}\u{FFFD}"), "{xml}");
}

#[test]
fn a_property_named_like_a_measurement_has_a_case_of_its_own() {
    let mut run = Summary { properties: properties(), ..summary() };
    run.properties[0].name.clone_from(&run.measurements[0].name);
    let notes = vec!["fault 0 never began: drop of gyro".to_owned()];
    let xml = document(&Summary { notes, ..run.clone() }, None).unwrap();
    let report = Report::deserialize_from_str(&xml).unwrap();
    let names: Vec<_> = report.test_suites[0].test_cases.iter().map(|case| &case.name).collect();
    assert!(names.iter().all(|name| names.iter().filter(|other| *other == name).count() == 1));
    let told = format!("{} (property)", run.measurements[0].name);
    assert!(names.iter().any(|name| name.as_str() == told), "{names:?}");
    let of_run = report.test_suites[0].test_cases[0].system_out.as_ref().unwrap();
    assert!(of_run.as_str().contains("fault 0 never began"), "{xml}");
}

#[test]
fn a_campaign_has_a_case_for_each_property() {
    let (done, saved) = example();
    insta::assert_snapshot!(campaign(&account(), &done, &saved, &[], Path::new("runs/x")).unwrap());
}

/// Jenkins tells cases apart by class and name, GitLab by suite, class and name.
#[test]
fn two_seeds_of_a_plan_have_suites_and_classes_of_their_own() {
    let named = |seed| {
        let xml = document(&Summary { seed, ..summary() }, None).unwrap();
        let report = Report::deserialize_from_str(&xml).unwrap();
        let [suite] = &report.test_suites[..] else { panic!("{xml}") };
        let classes: BTreeSet<_> =
            suite.test_cases.iter().map(|case| case.classname.clone().unwrap()).collect();
        assert_eq!(classes.len(), 1, "{xml}");
        (suite.name.clone(), classes)
    };
    let (one, other) = (named(1), named(2));
    assert!(one.0 != other.0 && one.1.is_disjoint(&other.1), "{one:?} {other:?}");
}

/// The attributes and counts that Jenkins, GitLab and GitHub's reporters rely on.
#[test]
fn what_readers_rely_on_is_there() {
    let run = Summary { properties: properties(), ..summary() };
    let (done, saved) = example();
    let of_run = document(&run, Some(Path::new(FOLDER))).unwrap();
    for xml in [of_run, campaign(&account(), &done, &saved, &[], Path::new("runs/x")).unwrap()] {
        let report = Report::deserialize_from_str(&xml).unwrap();
        for suite in &report.test_suites {
            let failed = suite
                .test_cases
                .iter()
                .filter(|case| matches!(case.status, TestCaseStatus::NonSuccess { .. }));
            assert_eq!(suite.tests, suite.test_cases.len());
            assert_eq!(suite.failures + suite.errors, failed.count());
            assert!(suite.failures > 0, "{xml}");
            for case in &suite.test_cases {
                assert!(case.classname.is_some(), "{}", case.name.as_str());
                if let TestCaseStatus::NonSuccess { message, ty, description, .. } = &case.status {
                    assert!(message.is_some() && ty.is_some() && description.is_some());
                    let out = case.system_out.as_ref().map_or("", |text| text.as_str());
                    let is_property =
                        run.properties.iter().any(|one| one.name == case.name.as_str());
                    assert!(out.contains("[[ATTACHMENT|runs/") || is_property, "{xml}");
                }
            }
        }
    }
}
