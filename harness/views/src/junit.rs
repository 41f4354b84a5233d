//! `junit.xml`: verdicts in the format that build servers read.
//!
//! One suite per run, one case per measurement, and one for the run itself, which carries the whole duration. Suites and
//! classes carry a seed that is not the usual one, because build servers take two cases of one class and name for one.
//! JUnit has no marginal verdict: such a case passes, and its output states it. If the run folder is known, the run's case
//! and failed cases list its files as attachments, in lines that Jenkins (JUnit Attachments) and GitLab read.

mod campaign;
mod envelopes;

pub use campaign::campaign;
pub use envelopes::envelopes;

use chrono::DateTime;
use plan::{RUN_ITSELF, SEED};
use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};
use record::figures;
use record::outcome::{Measurement, Outcome, PropertySummary, Summary, Verdict};
use record::run_folder::{RECORD, REPORT};
use std::path::Path;
use std::time::Duration;

/// Returns the document for one run. `folder` is the run folder, relative to the build server's working directory.
///
/// # Errors
/// When the XML cannot be written, which happens only if memory runs out.
pub fn document(
    summary: &Summary,
    folder: Option<&Path>,
) -> Result<String, quick_junit::SerializeError> {
    of_suite(suite(summary, &attachments(folder)))
}

fn of_suite(suite: TestSuite) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new("hil");
    report.add_test_suite(suite);
    // XML 1.0 has no place for these two, and the writer leaves them.
    report.to_string().map(|xml| xml.replace(['\u{FFFE}', '\u{FFFF}'], "\u{FFFD}"))
}

fn failure(kind: NonSuccessKind, word: &str, message: &str, text: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message).set_type(word).set_description(text);
    status
}

/// Lists the run's files that explain a verdict, one per line.
fn attachments(folder: Option<&Path>) -> String {
    let line = |file: &str| folder.map(|folder| attachment(&folder.join(file)));
    [REPORT, RECORD].into_iter().filter_map(line).collect()
}

/// Formats an attachment for Jenkins' JUnit Attachments plugin and GitLab.
fn attachment(path: &Path) -> String {
    format!("[[ATTACHMENT|{}]]\n", path.display())
}

fn suite(summary: &Summary, attachments: &str) -> TestSuite {
    let mut suite = TestSuite::new(with_seed(summary, ", seed ", ", run "));
    let time = Duration::try_from_secs_f64(summary.wall_s).unwrap_or_default();
    suite.set_time(time);
    if let Some(bench) = &summary.bench {
        if let Ok(started) = DateTime::parse_from_rfc3339(&bench.started) {
            suite.set_timestamp(started);
        }
        suite.extra.insert("hostname".into(), bench.host.as_str().into());
        for (name, value) in &bench.about {
            suite.add_property(Property::new(name.as_str(), value.as_str()));
        }
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
    let mut run = run(summary);
    run.set_time(time);
    let notes: String = summary.notes.iter().map(|note| format!("{note}\n")).collect();
    if !notes.is_empty() || !attachments.is_empty() {
        run.set_system_out(notes + attachments);
    }
    suite.add_test_case(run);
    let cases = summary.measurements.iter().map(|one| case(summary, one, attachments));
    suite.add_test_cases(cases);
    let properties = summary.properties.iter();
    suite.add_test_cases(properties.map(|judged| property(summary, judged, attachments)));
    suite
}

/// Succeeds if the run reached its end, whatever it measured, and the bench did not break.
fn run(summary: &Summary) -> TestCase {
    let kind = match (summary.outcome, &summary.reason) {
        (Outcome::Passed, _) | (Outcome::Failed, None) => None,
        (Outcome::Failed, Some(_)) => Some(NonSuccessKind::Failure),
        _ => Some(NonSuccessKind::Error),
    };
    let reason = summary.reason.as_deref().unwrap_or("no reason was given");
    let status = kind.map_or_else(TestCaseStatus::success, |kind| {
        failure(kind, summary.outcome.name(), reason, reason)
    });
    named(RUN_ITSELF, summary, status)
}

/// A case without duration: the run carries it.
fn named(name: &str, summary: &Summary, status: TestCaseStatus) -> TestCase {
    let mut case = TestCase::new(name, status);
    // What stands before the last dot is a package in Jenkins: it lists the seeds of a plan under the plan.
    case.set_classname(with_seed(summary, ".seed", ".run")).set_time(Duration::ZERO);
    case
}

/// The plan, behind `seed` a seed that is not the usual one, and behind `run` the number of a repeated run.
fn with_seed(summary: &Summary, seed: &str, run: &str) -> String {
    let mut name = summary.plan.clone();
    if summary.seed != SEED {
        name += &format!("{seed}{}", summary.seed);
    }
    summary.repetition().map_or(name.clone(), |number| format!("{name}{run}{number}"))
}

fn case(summary: &Summary, measurement: &Measurement, attachments: &str) -> TestCase {
    let sentence = sentence(measurement);
    // A bench that breaks before anything was observed says nothing of the device.
    let is_broken = summary.outcome == Outcome::Error && measurement.verdict == Verdict::Unset;
    if measurement.verdict == Verdict::NotJudged || is_broken {
        return named(&measurement.name, summary, skipped(&measurement.statistic));
    }
    if measurement.verdict.is_acceptable() {
        let mut case = named(&measurement.name, summary, TestCaseStatus::success());
        case.set_system_out(sentence);
        return case;
    }
    let text = format!("{sentence}\nplan {}, seed {}", summary.plan, summary.seed);
    let word = measurement.verdict.name();
    let status = failure(NonSuccessKind::Failure, word, &sentence, &text);
    let mut case = named(&measurement.name, summary, status);
    if !attachments.is_empty() {
        case.set_system_out(attachments);
    }
    case
}

fn skipped(why: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(why);
    status
}

/// A property that was not judged is skipped.
fn property(summary: &Summary, property: &PropertySummary, attachments: &str) -> TestCase {
    let status = match &property.not_judged {
        Some(why) => skipped(why),
        None if property.is_broken() => {
            let what = property.what.as_deref().unwrap_or("broken");
            let at = property.broken_s.map_or(String::new(), |at| format!("at {at:.3} s: "));
            let text = format!("{at}{what}\nplan {}, seed {}", summary.plan, summary.seed);
            failure(NonSuccessKind::Failure, "broken", what, &text)
        }
        None => TestCaseStatus::success(),
    };
    // A build server takes two cases of one name for one.
    let is_taken = summary.measurements.iter().any(|one| one.name == property.name);
    let name =
        if is_taken { format!("{} (property)", property.name) } else { property.name.clone() };
    let mut case = named(&name, summary, status);
    if let Some(why) = property.untested() {
        case.set_system_out(format!("held, but was {why}"));
    }
    if property.is_broken() && !attachments.is_empty() {
        case.set_system_out(attachments);
    }
    case
}

/// Describes value, band and paper in one line.
fn sentence(measurement: &Measurement) -> String {
    let Measurement { unit, lower, upper, statistic, .. } = measurement;
    let measured = match measurement.figure() {
        Some(figure) => format!("{statistic}: {figure}"),
        None => statistic.clone(),
    };
    let verdict = measurement.verdict.name();
    let band = figures::band(*lower, *upper, unit);
    let paper = measurement.paper.as_ref().map(|paper| format!("; paper: {paper}"));
    format!("{verdict}: {measured}; band: {band}{}", paper.unwrap_or_default())
}

#[cfg(test)]
mod tests;
