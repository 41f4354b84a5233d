//! Imports the log of a bench's CAN bus as a run folder, to be judged by a plan.
//!
//! Identifiers distinguish the frames: `wire/dbc/k2a.dbc` states which are the base's and which its host's. The
//! base's motion is cut into moves from rest to rest ([`moves`]), which are matched to the plan's steps ([`follow`]).
//! The frames then yield those quantities that a run would have observed of the base:
//!
//! | quantity | from a log | reason |
//! |---|---|---|
//! | `straight.stop_error` | formed | a run also takes it from the displacement in MOTION |
//! | `pose_write.retries` | formed if the log contains the host's frames | a retry is a WRITE_POSE of the same pose |
//! | any other | `unset` | [`why_not`] |
//!
//! Quantities from the gyro, the table, the absolute measurement or the controller's reports are not on the CAN bus,
//! and nothing else substitutes for them: the base's odometry is no heading of the gyro, its pose no absolute one. A
//! measurement of such a quantity is `unset` and fails the plan; a plan for logs declares only the others. The record
//! notes the speed and duration of each move and where the base believes that it stopped.
//!
//! If a log contains another move than the plan, or ends before it, the run fails with a reason. Moves after the plan's
//! last are noted.

mod error;
pub mod follow;
pub mod moves;
mod scribe;
#[cfg(test)]
mod tests;
mod unjudged;

pub use error::ImportError;
pub use scribe::LeftOut;
pub use unjudged::{FORMED, why_not};

use bus_log::{Channel, Entry, LogError, Payload};
use harness::operator::Answers;
use harness::run::{IMPORTED, header, unfinished, write_documents};
use harness::run::{Options, Prepared, judge_again, logged, run_to_folder};
use harness::stopwatch::Stopwatch;
use judge::checks::judge_all;
use plan::replayed::{Logged, Named, of_unheard};
use plan::rig::RigLine;
use plan::{Plan, Step};
use record::figures;
use record::outcome::{Outcome, Summary};
use record::run_folder::RunFolder;
use record::sink::{Level, NullSink, RecordSink};
use scribe::Scribe;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

#[derive(Debug)]
pub struct Imported {
    pub summary: Summary,
    pub channel: Channel,
    /// Moves of the base that match the plan.
    pub moves: u64,
    /// Parts of the log that are not in the record.
    pub left_out: LeftOut,
    /// Measurements of the plan that no log of a CAN bus can make, and why not.
    pub unjudged: Vec<(String, &'static str)>,
}

/// The most frames of a log of a rig, which are all kept.
const ENTRIES_MAX: usize = 10_000_000;

/// Assumption: a bus on which nothing is sent for as long as this, or for as long as anywhere else in the log, may be
/// quiet. A plan that goes on for longer than that after the log's last frame has nothing to judge.
const QUIET: Span = Span::from_secs(1);

/// A log that begins this late, s, has times of day, or counts from 1970. Assumption: no bench logs for ten days.
const DATED_S: f64 = 864_000.0;

/// The frames, if there are at most so many, with notes on their times and on what is left out. A log without dates counts from
/// its zero, unless it is to count `from_first`.
fn kept(
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    from_first: bool,
    most: usize,
) -> Result<(Vec<Logged>, Vec<String>), ImportError> {
    let mut errors = 0_u64;
    let is_kept = |entry: &Result<Entry, LogError>| {
        let is_error = matches!(entry, Ok(Entry { payload: Payload::Error(_), .. }));
        errors += u64::from(is_error);
        !is_error
    };
    let mut begins_s = 0.0;
    let origin = |earliest: Timestamp| {
        begins_s = earliest.as_secs_f64();
        if begins_s < DATED_S && !from_first { Timestamp::ZERO } else { earliest }
    };
    let (log, note) = logged(entries.into_iter().filter(is_kept).take(most + 1), origin)?;
    if log.len() > most {
        return Err(ImportError::TooLong { most });
    }
    let mut notes = Vec::from_iter(note);
    if errors > 0 {
        let frames = figures::counted(errors, "error frame", "error frames");
        notes.push(format!("{frames} of the log left out"));
    }
    if (1.0..DATED_S).contains(&begins_s) && !from_first {
        notes.push(format!(
            "the log begins at {begins_s:.3} s, and the plan at its zero (at its first frame with --from-first)"
        ));
    }
    Ok((log, notes))
}

fn lasted(log: &[Logged]) -> Span {
    log.last().map_or(Span::ZERO, |last| last.at)
}

/// Why a plan that ended at this time had nothing to judge at its end; `None` if the log covers it.
fn outlasted(log: &[Logged], end_s: f64) -> Option<String> {
    let quiet = log.windows(2).map(|pair| pair[1].at - pair[0].at).fold(QUIET, Span::max);
    let last_s = lasted(log).as_secs_f64();
    (end_s > last_s + quiet.as_secs_f64())
        .then(|| format!("the log ends at {last_s:.3} s, before the plan, which took {end_s:.3} s"))
}

/// A sentence about the end of a plan after that of its log, where the log is silent for as long elsewhere.
fn silent_end(log: &[Logged], end_s: f64) -> Option<String> {
    let silent_s = end_s - lasted(log).as_secs_f64();
    (silent_s > QUIET.as_secs_f64() && outlasted(log, end_s).is_none())
        .then(|| format!("the log ends {silent_s:.3} s before the plan"))
}

/// A sentence about what the log holds after the end of the plan.
fn unjudged_rest(log: &[Logged], end_s: f64) -> Option<String> {
    let rest = log.iter().rev().take_while(|one| one.at.as_secs_f64() > end_s).count() as u64;
    let frames = figures::counted(rest, "frame", "frames");
    let were = if rest == 1 { "was" } else { "were" };
    (rest > 0).then(|| format!("{frames} after the end of the plan {were} not judged"))
}

/// A sentence about the steps by which the plan would act on devices; `None` if it only watches.
fn assumed(plan: &Plan) -> Option<String> {
    let acts = |step: &&Step| {
        use plan::Action::{PowerCycle, Send, SetParameter, StopSending, Sweep};
        let action = &step.action;
        matches!(action, SetParameter(_) | PowerCycle(_) | Send(_) | StopSending(_) | Sweep(_))
    };
    let acts: BTreeSet<String> = Step::walk(&plan.steps)
        .filter(acts)
        .map(|step| format!("`{}`", step.action.name()))
        .collect();
    let acts = Vec::from_iter(acts).join(", ");
    (!acts.is_empty()).then(|| {
        format!("nothing was done to a device: the log is assumed to show the effects of {acts}")
    })
}

/// Creates a run folder from a log of a rig and judges it by its plan: every node sends what it sent in the log, and
/// the plan listens. What the plan itself would do to the rig is assumed to be in the log. `named` states the channel of
/// a line; the plan begins with the first frame if it does so `from_first`, or if the log has dates, and else at the log's zero.
///
/// # Errors
/// When the log cannot be read, lacks lines of the rig, or the folder cannot be written.
pub fn import_rig_to_folder(
    prepared: &Prepared,
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    named: Named<'_>,
    from_first: bool,
    out: &Path,
) -> Result<Summary, ImportError> {
    let watch = Stopwatch::start();
    let (log, notes) = kept(entries, from_first, ENTRIES_MAX)?;
    let of_bench = &prepared.rig;
    let rig = of_bench.clone().replayed_by(&log, named);
    let rig = rig.map_err(|(line, known)| {
        let known = known.join(", ");
        match named(&line).map(str::to_owned) {
            _ if known.is_empty() => ImportError::NoFrames,
            Some(channel) => ImportError::NoChannel { channel, known },
            None => ImportError::NoLine { line, known },
        }
    })?;
    let mut plan = Plan::clone(&prepared.plan);
    plan.faults.faults.clear();
    let prepared = Prepared { rig, plan: Arc::new(plan), ..prepared.clone() };
    let (seed, level, answers) = (0, Level::Full, Answers::default());
    let options = Options { seed, out, level, answers };
    let done = run_to_folder(&prepared, &options, &mut |_| true, &|| 0.0)?;
    let mut summary = done.summary;
    IMPORTED.clone_into(&mut summary.clock);
    summary.bus = "can".to_owned();
    summary.device_under_test = "unknown".to_owned();
    summary.notes.extend(notes);
    summary.notes.extend(assumed(&prepared.plan));
    summary.notes.extend(unjudged_rest(&log, summary.simulated_s));
    summary.notes.extend(silent_end(&log, summary.simulated_s));
    if let Some(why) = outlasted(&log, summary.simulated_s) {
        summary.outcome = summary.outcome.max(Outcome::Failed);
        summary.reason = Some(match summary.reason.take() {
            Some(reason) => format!("{why}; {reason}"),
            None => why,
        });
    }
    // Nothing is known of what came after the log.
    summary.simulated_s = summary.simulated_s.min(lasted(&log).as_secs_f64());
    summary.wall_s = watch.elapsed_s();
    let (folder, header) = (RunFolder::open(out)?, prepared.header(seed));
    let is_unheard = |line: &RigLine| summary.notes.contains(&of_unheard(&line.name));
    if of_bench.lines.iter().any(is_unheard) {
        let (plan, records) = (&prepared.plan, folder.records()?);
        summary = judge_again(plan, of_bench, Some(summary), &header, records).summary;
    }
    write_documents(&folder, &summary, &header)?;
    Ok(summary)
}

/// Why a log with frames on these channels holds no base on the one that is stated, or on any.
fn without_base(heard: &BTreeSet<Channel>, stated: Option<Channel>) -> ImportError {
    match stated {
        _ if heard.is_empty() => ImportError::NoFrames,
        Some(stated) if !heard.contains(&stated) => {
            let known: Vec<&str> = heard.iter().map(Channel::as_str).collect();
            ImportError::NoChannel { channel: stated.to_string(), known: known.join(", ") }
        }
        _ => ImportError::NoBase,
    }
}

/// Creates a run folder from a log and judges it by `plan`. The default `channel` is that of the first frame of a base.
///
/// # Errors
/// When the plan moves no base, the log cannot be read or contains no base, or the folder cannot be written.
pub fn import_to_folder(
    plan: &Arc<Plan>,
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    channel: Option<Channel>,
    out: &Path,
) -> Result<Imported, ImportError> {
    if !follow::moves_base(plan) {
        return Err(ImportError::NothingMoves { plan: plan.name.as_str().to_owned() });
    }
    let watch = Stopwatch::start();
    let mut scribe = Scribe::new(plan, channel);
    // A log without a base makes no folder.
    let mut entries = entries.into_iter();
    let mut heard = BTreeSet::new();
    let first = loop {
        let entry = entries.next().ok_or_else(|| without_base(&heard, channel))??;
        if scribe.hears_base(&entry) {
            break entry;
        }
        if matches!(entry.payload, Payload::Frame(_)) {
            heard.insert(entry.channel);
        }
        scribe.take(&entry, &mut NullSink);
    };
    let folder = RunFolder::create(out)?;
    let header = header(plan, 0, &[]);
    let mut sink = folder.record_sink(&header, Level::Full)?;
    scribe.take(&first, &mut sink);
    for entry in entries {
        scribe.take(&entry?, &mut sink);
    }
    scribe.finish(&mut sink);
    sink.finish();
    let failed = sink.failed().map(|error| format!("failed to write the record: {error}"));
    drop(sink);
    let channel = first.channel;
    let (measurements, judged) = judge_all(&plan.measurements, scribe.observations());
    let (outcome, reason) = match (failed, scribe.diverged()) {
        (Some(failed), _) => (Outcome::Error, Some(failed)),
        (None, Some(diverged)) => (Outcome::Failed, Some(diverged.to_owned())),
        (None, None) => (judged, None),
    };
    let summary = Summary {
        outcome,
        reason,
        clock: IMPORTED.to_owned(),
        bus: "can".to_owned(),
        wall_s: watch.elapsed_s(),
        events: scribe.frames(),
        measurements,
        properties: unjudged::properties(plan),
        ..unfinished(&header, &plan.title, scribe.now())
    };
    write_documents(&folder, &summary, &header)?;
    let unjudged = unjudged::of_plan(plan);
    let (moves, left_out) = (scribe.moves(), scribe.left_out());
    Ok(Imported { summary, channel, moves, left_out, unjudged })
}
