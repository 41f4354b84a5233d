//! Judges a recorded run again.
//!
//! The record holds every observation; only the summary says how the run ended. Therefore:
//!
//! | summary | record | outcome | documents |
//! |---|---|---|---|
//! | the run went to its end | whole | by the checks, as in the run itself | rewritten |
//! | the run broke off | whole | as it was, with its reason | rewritten |
//! | any | cut short or damaged | error, or as it was where that is worse | left as they are |
//! | none: the run was killed | any | error | written |
//!
//! A run went to its end if its outcome is passed, or failed without a reason: a run that itself fails, for example at
//! a refused mission, has a reason.
//!
//! Properties are judged again if the record holds their data; others keep the verdict of the run, and
//! [`JudgedAgain::kept`] lists them with the reason. One of which there is no verdict does not hold. A run that failed only for
//! a broken property went to its end.
//!
//! An incomplete record never passes, whatever the summary says: a summary is written after the record, so the record
//! was damaged later, and the verdicts in the summary rest on more than what is left. For the same reason the documents
//! are left as they are.

use super::absent::name_absent;
use super::header;
use super::keep::{breach, worsen};
use super::recorded::plan_of;
use super::recorded_properties::Replayed;
use super::unheard::Unheard;
use crate::checks::judge_all;
use crate::observation::Observations;
use crate::outcome::{Outcome, PropertySummary, Summary, Verdict};
use crate::plan::{Plan, Rig};
use crate::properties::{Limits, Unjudged};
use crate::record::header::Header;
use crate::record::reader::RecordError;
use crate::record::{Record, RecordKind, VERSION};
use emulators::device_file::Devices;
use judge::unseen;
use rig::bench::Bench;
use std::collections::BTreeSet;
use wire::time::Timestamp;

/// Clock of a run that was imported from a bus log.
pub const IMPORTED: &str = "recorded";

/// Result of judging again.
#[derive(Debug)]
pub struct JudgedAgain {
    /// The summary, with new measurements.
    pub summary: Summary,
    /// Header for the report, from the plan that judged.
    pub header: Header,
    /// Why the record could not be read to its end.
    pub record_error: Option<RecordError>,
    /// Properties that keep the verdict of the run, or are absent if it gave none: the record does not hold their data.
    pub kept: Vec<Unjudged>,
    /// Whether the documents in the run folder should be rewritten.
    pub rewrite: bool,
}

/// Judges `records` by `plan` on `rig`. `summary` is that of the run; `recorded` is the record's header.
pub fn judge_again(
    plan: &Plan,
    rig: &Rig,
    summary: Option<Summary>,
    recorded: &Header,
    records: impl IntoIterator<Item = Result<Record, RecordError>>,
) -> JudgedAgain {
    let of_plan = header(plan, recorded.seed, &rig.speakers);
    let header = Header { quantities: of_plan.quantities, ..recorded.clone() };
    let of = |robot: &Devices| Bench::new(robot.clone(), recorded.seed).controller_config();
    let limits = rig.robot.as_deref().map(|robot| Limits::of(&of(robot)));
    let has_any = !plan.properties.is_empty();
    let mut replayed = has_any.then(|| Replayed::new(&plan.properties, limits.as_ref(), rig));
    let ended = |summary: &Summary| Timestamp::from_secs_f64(summary.simulated_s);
    // In virtual time, what was still under way at the end of the plan arrived at nodes that no longer ran.
    let plan_end = summary.as_ref().filter(|summary| summary.clock != "real").map(ended);
    let read = Read::of(records, &header, &mut |record| {
        let is_judged = plan_end.is_none_or(|end| record.at <= end);
        if let Some(replayed) = replayed.as_mut().filter(|_| is_judged) {
            replayed.take(record);
        }
    });
    // Nodes may have been silent from the last record to the end of the run.
    let end = summary.as_ref().filter(|_| read.error.is_none()).map(ended);
    if let (Some(replayed), Some(end)) = (&mut replayed, end) {
        replayed.goes_on_until(end);
    }
    let summary = summary.map(without_verdicts);
    let (mut measurements, mut judged) = judge_all(&plan.measurements, &read.observations);
    let of_run = plan_of(recorded);
    if name_absent(plan, of_run.as_ref(), recorded, &mut measurements) {
        judged = Outcome::Failed;
    }
    let unheard = Unheard::of(rig, summary.as_ref().filter(|summary| summary.clock == IMPORTED));
    if unheard.unset(plan, &mut measurements) {
        judged = Outcome::Failed;
    }
    // What the bench could not give, its record does not hold.
    let before = summary.iter().flat_map(|summary| &summary.measurements);
    if let Some(known) = before.into_iter().find(|one| one.verdict == Verdict::NotJudged) {
        judged = unseen::without_truth(&plan.measurements, &mut measurements, &known.statistic);
    }
    let rewrite = read.error.is_none() || summary.is_none();
    let (outcome, reason) = match (&summary, &read.error) {
        (None, _) => (Outcome::Error, Some(NO_SUMMARY.to_owned())),
        (Some(summary), Some(error)) => {
            let why = format!("judged on what is left of the record: {error}");
            (summary.outcome.max(Outcome::Error), Some(why))
        }
        (Some(summary), None) if went_to_its_end(summary) => (judged, None),
        (Some(summary), None) => (summary.outcome, summary.reason.clone()),
    };
    let mut summary = summary.unwrap_or_else(|| unfinished(recorded, &plan.title, read.last));
    if read.error.is_some() {
        summary.simulated_s = summary.simulated_s.min(read.last.as_secs_f64());
    }
    let real = summary.clock == "real";
    let before = &stated_alike(plan, of_run.as_ref(), &summary.properties);
    let (mut properties, mut kept) = match replayed {
        // An imported bus log holds no reports of the controller.
        Some(_) if summary.clock == IMPORTED && limits.is_some() => (before.clone(), Vec::new()),
        Some(replayed) => replayed.judge(&plan.properties, limits.as_ref(), real, before),
        None => Default::default(),
    };
    kept.extend(unheard.unjudged(plan, &mut properties));
    let mut summary = Summary { outcome, reason, measurements, properties, ..summary };
    summary.notes.retain(|note| !note.starts_with(JUDGED_BY));
    summary.notes.extend(judged_by(plan, of_run.as_ref()));
    // What the bench of the run did not show is no fault of the record, and has another reason.
    let lacks = |one: &&PropertySummary| {
        let why =
            |kept: &Unjudged| kept.name == one.name && Some(&kept.why) == one.not_judged.as_ref();
        one.held.is_none() && kept.iter().any(why)
    };
    let lacking = summary.properties.iter().find(lacks).and_then(without_verdict);
    for why in lacking.into_iter().chain(breach(&summary.properties)) {
        worsen(&mut summary, Outcome::Failed, why);
    }
    let is_unjudged = |one: &PropertySummary| one.held.is_none();
    if has_any && summary.measurements.is_empty() && summary.properties.iter().all(is_unjudged) {
        worsen(&mut summary, Outcome::Failed, NOTHING_JUDGED.to_owned());
    }
    JudgedAgain { summary, header, record_error: read.error, kept, rewrite }
}

const NOTHING_JUDGED: &str =
    "nothing was judged: the record does not hold what the properties need";

/// Begins the note on another plan than that of the run.
const JUDGED_BY: &str = "judged again by ";

/// A sentence about a plan that is not that of the run: what calls itself a verdict on the run is one of this plan.
fn judged_by(plan: &Plan, of_run: Option<&Plan>) -> Option<String> {
    let of_run = of_run.filter(|of_run| *of_run != plan)?;
    let (name, of_run) = (plan.name.as_str(), of_run.name.as_str());
    Some(match of_run == name {
        true => format!("{JUDGED_BY}{name} as it is now, and not as it was in the run"),
        false => format!("{JUDGED_BY}{name}, and not by {of_run}, the plan of the run"),
    })
}

/// A sentence about a property that was not judged.
fn without_verdict(property: &PropertySummary) -> Option<String> {
    let why = property.not_judged.as_ref().filter(|_| property.held.is_none())?;
    Some(format!("{} is not judged: {why}", property.name))
}

/// The summary before its properties were judged: they are judged again.
fn without_verdicts(mut summary: Summary) -> Summary {
    let unjudged = summary.properties.iter().filter_map(without_verdict);
    let reasons = breach(&summary.properties).into_iter().chain(unjudged);
    let reasons: Vec<_> = [NOTHING_JUDGED.to_owned()].into_iter().chain(reasons).collect();
    for why in &reasons {
        let left = summary.reason.as_deref().and_then(|reason| reason.strip_suffix(why));
        // Runs of earlier versions have a semicolon between their reasons.
        let left = left.map(|left| {
            left.strip_suffix(". ").or_else(|| left.strip_suffix("; ")).unwrap_or(left)
        });
        match left {
            Some("") => summary.reason = None,
            Some(left) => summary.reason = Some(left.to_owned()),
            None => {}
        }
    }
    summary
}

/// The verdicts on properties that `plan` states as the plan of the run did: others are of another property, whatever its
/// name. A record without a plan says nothing of the difference.
fn stated_alike(
    plan: &Plan,
    of_run: Option<&Plan>,
    verdicts: &[PropertySummary],
) -> Vec<PropertySummary> {
    let Some(of_run) = of_run else { return verdicts.to_vec() };
    let stated = |of: &Plan, name: &str| {
        of.properties.iter().find(|property| property.name() == name).cloned()
    };
    let is_same = |one: &&PropertySummary| stated(plan, &one.name) == stated(of_run, &one.name);
    verdicts.iter().filter(is_same).cloned().collect()
}

fn went_to_its_end(summary: &Summary) -> bool {
    match summary.outcome {
        Outcome::Passed => true,
        Outcome::Failed => summary.reason.is_none(),
        Outcome::Error | Outcome::Timeout | Outcome::Aborted => false,
    }
}

/// Why a run without a summary is an error.
const NO_SUMMARY: &str = "no summary says how the run ended: it was killed, or is still running";

/// Summary of a run that wrote none, from the record alone: its header and the time of its last record. Nothing is
/// judged.
pub fn unfinished(recorded: &Header, title: &str, last: Timestamp) -> Summary {
    let not_known = || "unknown".to_owned();
    let version = if recorded.harness.is_empty() { VERSION } else { &recorded.harness };
    Summary {
        outcome: Outcome::Error,
        reason: Some(NO_SUMMARY.to_owned()),
        plan: recorded.plan.clone(),
        title: title.to_owned(),
        version: version.to_owned(),
        seed: recorded.seed,
        clock: not_known(),
        bus: not_known(),
        device_under_test: not_known(),
        simulated_s: last.as_secs_f64(),
        wall_s: 0.0,
        events: 0,
        measurements: Vec::new(),
        artifacts: Vec::new(),
        bench: recorded.bench.clone(),
        timing: None,
        ports: Vec::new(),
        commands: Vec::new(),
        notes: Vec::new(),
        faults: Vec::new(),
        properties: Vec::new(),
    }
}

/// Contents of a record.
#[derive(Debug)]
struct Read {
    /// Observations of the judged quantities.
    observations: Observations,
    last: Timestamp,
    error: Option<RecordError>,
}

impl Read {
    fn of(
        records: impl IntoIterator<Item = Result<Record, RecordError>>,
        header: &Header,
        watch: &mut impl FnMut(&Record),
    ) -> Self {
        let judged: BTreeSet<&str> =
            header.quantities.iter().map(|one| one.name.as_str()).collect();
        let mut read =
            Self { observations: Observations::default(), last: Timestamp::ZERO, error: None };
        for record in records {
            let record = match record {
                Ok(record) => record,
                Err(error) => {
                    read.error = Some(error);
                    break;
                }
            };
            read.last = record.at;
            watch(&record);
            let RecordKind::Observation(observation) = record.kind else { continue };
            if judged.contains(observation.quantity.as_str()) {
                // The engine ends a run before this limit; no real run has such a record.
                let _full = read.observations.push(&observation);
            }
        }
        read
    }
}

#[cfg(test)]
mod tests {
    use super::super::load_rig;
    use super::{JudgedAgain, judge_again};
    use crate::library::Library;
    use crate::outcome::samples::summary;
    use crate::outcome::{Outcome, Summary, Verdict};
    use crate::plan::Plan;
    use crate::record::header::Header;
    use crate::record::reader::RecordError;
    use crate::record::samples::observation;
    use crate::record::{Device, Record};
    use wire::time::Timestamp;

    const PLAN: &str = r#"
        name = "turns"
        title = "Turns"
        devices = "paper"
        steps = [{ turn = { angle_deg = 90 } }]

        [[measurement]]
        name = "stop"
        doc = "Stop error"
        quantity = "turn.stop_error"
        unit = "deg"
        check = { all_within = [-1, 1] }
    "#;

    fn again(was: Option<Summary>, value: f64, end: Option<RecordError>) -> JudgedAgain {
        let plan = Plan::parse("turns.toml", PLAN).unwrap();
        let kind = observation("turn.stop_error", value, &[]);
        let at = Timestamp::from_nanos(3_000_000_000);
        let record = Record { at, device: Device::Plan, kind };
        let records = [Ok(record)].into_iter().chain(end.map(Err));
        let header = Header { plan: "turns".into(), seed: 7, ..Header::default() };
        let rig = load_rig(&Library::shipped(), &plan).unwrap();
        judge_again(&plan, &rig, was, &header, records)
    }

    fn ended(outcome: Outcome, reason: Option<&str>) -> Option<Summary> {
        Some(Summary { outcome, reason: reason.map(str::to_owned), ..summary() })
    }

    fn cut() -> Option<RecordError> {
        Some(RecordError::CutShort { offset: 9, trailing: 1 })
    }

    #[test]
    fn a_run_that_went_to_its_end_is_judged_anew() {
        for was in [ended(Outcome::Passed, None), ended(Outcome::Failed, None)] {
            let passed = again(was.clone(), 0.1, None);
            assert_eq!((passed.summary.outcome, passed.rewrite), (Outcome::Passed, true));
            assert_eq!(passed.summary.measurements.len(), 1);
            assert_eq!(again(was, 1.1, None).summary.outcome, Outcome::Failed);
        }
    }

    #[test]
    fn a_run_that_broke_off_stays_so() {
        for outcome in [Outcome::Failed, Outcome::Error, Outcome::Timeout, Outcome::Aborted] {
            let judged = again(ended(outcome, Some("the controller refused")), 0.1, None);
            assert_eq!(judged.summary.outcome, outcome);
            assert_eq!(judged.summary.reason.as_deref(), Some("the controller refused"));
            assert_eq!(judged.summary.measurements[0].verdict, Verdict::Pass);
            assert!(judged.rewrite);
        }
    }

    #[test]
    fn what_is_left_of_a_record_cannot_pass_and_replaces_nothing() {
        let judged = again(ended(Outcome::Passed, None), 0.1, cut());
        assert_eq!((judged.summary.outcome, judged.rewrite), (Outcome::Error, false));
        assert!(judged.summary.reason.unwrap().contains("cut short"));
        let aborted = again(ended(Outcome::Aborted, Some("stopped by request")), 0.1, cut());
        assert_eq!((aborted.summary.outcome, aborted.rewrite), (Outcome::Aborted, false));
    }

    #[test]
    fn a_quantity_that_the_run_did_not_measure_is_named() {
        let plan = PLAN.replace("turn.stop_error", "turn.odometry_error");
        let plan = Plan::parse("turns.toml", &plan).unwrap();
        let rig = load_rig(&Library::shipped(), &plan).unwrap();
        let was = ended(Outcome::Passed, None);
        let found = judge_again(&plan, &rig, was, &Header::default(), []).summary;
        assert_eq!(
            (found.outcome, found.measurements[0].verdict),
            (Outcome::Failed, Verdict::Unset)
        );
        let statistic = &found.measurements[0].statistic;
        assert!(statistic.ends_with("the plan of the run did not measure it"), "{statistic}");
    }

    #[test]
    fn a_killed_run_gets_a_summary_that_says_so() {
        for end in [None, cut()] {
            let judged = again(None, 0.1, end);
            assert_eq!((judged.summary.outcome, judged.rewrite), (Outcome::Error, true));
            assert_eq!((judged.summary.plan.as_str(), judged.summary.seed), ("turns", 7));
            assert_eq!(judged.summary.simulated_s, 3.0);
            // Judged once more, the run still has not ended properly.
            let twice = again(Some(judged.summary), 0.1, None);
            assert_eq!(twice.summary.outcome, Outcome::Error);
        }
    }
}
