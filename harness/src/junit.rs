//! `junit.xml`: verdicts in the form that build servers read.
//!
//! One suite a run, one case a measurement. JUnit knows no marginal: that passes, and its output says
//! so. A run that the bench broke has one more case, in error, because a suite itself cannot be.

use crate::figures;
use crate::outcome::{Measurement, Outcome, PropertySummary, Summary};
use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};
use std::time::Duration;

/// Name of the case that stands for the run itself.
const RUN_CASE: &str = "the run itself";

/// The document for one run or several.
///
/// # Errors
/// When the XML cannot be written, which memory running out would do.
pub fn document<'a>(
    summaries: impl IntoIterator<Item = &'a Summary>,
) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new("hil");
    for summary in summaries {
        report.add_test_suite(suite(summary));
    }
    report.to_string()
}

fn suite(summary: &Summary) -> TestSuite {
    let mut suite = TestSuite::new(&*summary.plan);
    if let Ok(time) = Duration::try_from_secs_f64(summary.wall_s) {
        suite.set_time(time);
    }
    for (name, value) in [
        ("title", summary.title.clone()),
        ("outcome", summary.outcome.name().to_owned()),
        ("version", summary.version.clone()),
        ("seed", summary.seed.to_string()),
        ("clock", summary.clock.clone()),
        ("bus", summary.bus.clone()),
        ("device_under_test", summary.device_under_test.clone()),
        ("simulated_s", summary.simulated_s.to_string()),
    ] {
        suite.add_property(Property::new(name, value));
    }
    if !matches!(summary.outcome, Outcome::Passed | Outcome::Failed) {
        suite.add_test_case(broken(summary));
    }
    suite.add_test_cases(summary.measurements.iter().map(|measurement| case(summary, measurement)));
    suite.add_test_cases(summary.properties.iter().map(|judged| property(summary, judged)));
    suite
}

fn broken(summary: &Summary) -> TestCase {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
    let reason = summary.reason.as_deref().unwrap_or("no reason was given");
    status.set_message(reason).set_type(summary.outcome.name());
    let mut case = TestCase::new(RUN_CASE, status);
    case.set_classname(&*summary.plan);
    case
}

fn case(summary: &Summary, measurement: &Measurement) -> TestCase {
    let sentence = sentence(measurement);
    let status = if measurement.verdict.is_acceptable() {
        TestCaseStatus::success()
    } else {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message(&*sentence).set_type(measurement.verdict.name());
        status
    };
    let mut case = TestCase::new(&*measurement.name, status);
    case.set_classname(&*summary.plan);
    if measurement.verdict.is_acceptable() {
        case.set_system_out(sentence);
    }
    case
}

/// One that was not judged is skipped; one that must come about in some run of a campaign need not in this.
fn property(summary: &Summary, property: &PropertySummary) -> TestCase {
    let status = match &property.not_judged {
        Some(why) => {
            let mut status = TestCaseStatus::skipped();
            status.set_message(why.as_str());
            status
        }
        None if property.is_broken() => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(property.what.as_deref().unwrap_or("broken")).set_type("broken");
            status
        }
        None => TestCaseStatus::success(),
    };
    let mut case = TestCase::new(&*property.name, status);
    case.set_classname(&*summary.plan);
    case
}

/// Value, band and paper in one line.
fn sentence(measurement: &Measurement) -> String {
    let Measurement { unit, lower, upper, statistic, .. } = measurement;
    let measured = match measurement.value {
        Some(value) => figures::quantity(value, measurement.uncertainty, unit),
        None => "nothing measured".to_owned(),
    };
    let verdict = measurement.verdict.name();
    let band = figures::band(*lower, *upper, unit);
    let paper = measurement.paper.as_deref().unwrap_or("gives nothing");
    format!("{verdict}: {statistic}: {measured}; band: {band}; paper: {paper}")
}

#[cfg(test)]
mod tests {
    use super::document;
    use crate::outcome::samples::summary;
    use crate::outcome::{Outcome, Summary};

    #[test]
    fn verdicts_become_cases() {
        insta::assert_snapshot!(document(&[summary()]).unwrap());
    }

    #[test]
    fn a_broken_bench_is_an_error() {
        let reason = Some("gyro: \u{1b}[31mno such port <ttyUSB0>".to_owned());
        let measurements = Vec::new();
        let broken = Summary { outcome: Outcome::Error, reason, measurements, ..summary() };
        insta::assert_snapshot!(document(&[broken]).unwrap());
    }
}
