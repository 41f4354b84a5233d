//! A campaign as a suite: one case per property, with the smallest case that breaks it.

use super::{attachment, failure, of_suite, skipped};
use campaign::{Account, Campaign};
use judge::properties::Unjudged;
use quick_junit::{NonSuccessKind, Property, TestCase, TestCaseStatus, TestSuite};
use record::figures;
use record::run_folder::REPORT;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

const CAMPAIGN_CASE: &str = "the campaign itself";

/// Returns the document for a campaign; `account` states its plan and duration. `saved` are the plans of the smallest
/// cases, one for each property that broke; `unjudged` are the properties that the bench cannot judge; `folder` is the
/// campaign's. States that no case reached fail if the plan demands
/// them, and are skipped otherwise; so are properties that no case put to the test.
///
/// # Errors
/// When the XML cannot be written, which happens only if memory runs out.
pub fn campaign(
    account: &Account,
    done: &Campaign,
    saved: &[PathBuf],
    unjudged: &[Unjudged],
    folder: &Path,
) -> Result<String, quick_junit::SerializeError> {
    let (plan, tally) = (&account.plan, &done.tally);
    let wall_s = account.end.as_ref().map_or(0.0, |end| end.wall_s);
    let time = Duration::try_from_secs_f64(wall_s).unwrap_or_default();
    let report_page = attachment(&folder.join(REPORT));
    let mut suite = TestSuite::new(format!("campaign {plan}"));
    suite.set_time(time);
    suite.add_property(Property::new("seed", account.seed.to_string()));
    suite.add_property(Property::new("cases", tally.cases.to_string()));
    suite.add_property(Property::new("passed", tally.passed.to_string()));
    let case = |name: &str, status: TestCaseStatus| {
        let mut case = TestCase::new(name, status);
        case.set_classname(format!("campaign.{plan}")).set_time(Duration::ZERO);
        case
    };
    let ended = if done.stopped {
        let message = format!("stopped after {} cases", tally.cases);
        failure(NonSuccessKind::Error, "aborted", &message, &message)
    } else {
        TestCaseStatus::success()
    };
    let mut itself = case(CAMPAIGN_CASE, ended);
    itself.set_time(time).set_system_out(&*report_page);
    suite.add_test_case(itself);

    let found: BTreeSet<&str> = done.found.iter().map(|found| &*found.property).collect();
    for (found, path) in done.found.iter().zip(saved) {
        let what = found.shrunk.result.violated.iter().find(|one| one.property == found.property);
        let what = what.map_or("broken", |violated| &*violated.what);
        let text = format!(
            "{what}\nbroken by {} of {} cases; the smallest again: hil run {} --seed {} {}",
            found.times,
            tally.cases,
            path.display(),
            found.shrunk.case.seed,
            account.replay
        );
        let status = failure(NonSuccessKind::Failure, "broken", what, text.trim_end());
        let mut broken = case(&found.property, status);
        broken.set_system_out(attachment(path) + &report_page);
        suite.add_test_case(broken);
    }
    for (property, (margin, _)) in &tally.nearest {
        if !found.contains(&**property) && tally.untested().all(|untested| untested != property) {
            let mut held = case(property, TestCaseStatus::success());
            let margin = figures::least_margin(*margin);
            let margin = margin.map(|margin| format!("; least margin {margin} of its limit"));
            let times = tally.unjudged.get(property).map(|(times, why)| {
                format!(
                    "; nothing to judge in {}: {why}",
                    figures::counted(*times, "case", "cases")
                )
            });
            let [margin, times] = [margin, times].map(Option::unwrap_or_default);
            held.set_system_out(format!("held{margin}{times}"));
            suite.add_test_case(held);
        }
    }
    for one in unjudged {
        suite.add_test_case(case(&one.name, skipped(&one.why)));
    }
    for (state, times) in &tally.reached {
        let mut reached = case(state, TestCaseStatus::success());
        reached.set_system_out(format!("reached by {times} cases"));
        suite.add_test_case(reached);
    }
    for property in tally.untested().filter(|property| !found.contains(property)) {
        suite.add_test_case(case(property, skipped("no case put it to the test")));
    }
    for state in &done.never {
        if !done.missed.contains(state) {
            suite.add_test_case(case(state, skipped("no case reached it")));
            continue;
        }
        let why = "the plan demands it sometimes, and no case reached it";
        let mut missed = case(state, failure(NonSuccessKind::Failure, "missed", why, why));
        missed.set_system_out(&*report_page);
        suite.add_test_case(missed);
    }
    of_suite(suite)
}
