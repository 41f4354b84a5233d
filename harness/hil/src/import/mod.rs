//! The log of a bench's CAN bus as a run folder, to be judged by a plan.
//!
//! Frames are told by their identifiers: `wire/dbc/k2a.dbc` says which are the base's and which its host's.
//! What the base did is cut into moves from rest to rest ([`moves`]), and these are followed through the
//! plan ([`follow`]). Then the frames say what a run would have observed of the base:
//!
//! | quantity | from a log | since |
//! |---|---|---|
//! | `straight.stop_error` | formed | a run takes it from the displacement in MOTION, too |
//! | `pose_write.retries` | formed, where the host's frames are in the log | a retry is a WRITE_POSE of the same pose |
//! | any other | `unset` | [`why_not`] |
//!
//! A quantity that rests on the gyro, the table, the absolute measurement or the controller's own word is not
//! on the CAN bus, and nothing else is taken for it: the base's odometry is no heading of the gyro, its pose
//! no absolute one. A measurement of such a quantity is `unset` and fails the plan; a plan for logs declares
//! the others. How fast each move was, how long it took and where the base believes that it stopped stand in
//! the record as notes.
//!
//! A log that does another move than the plan, or ends before it, fails with a reason. Moves behind the
//! plan's last are noted.

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

use bus_log::{Channel, Entry, LogError};
use harness::operator::Answers;
use harness::run::{IMPORTED, header, write_documents};
use harness::run::{Options, Prepared, logged, run_to_folder};
use judge::checks::judge_all;
use plan::Plan;
use record::VERSION;
use record::outcome::{Outcome, Summary};
use record::run_folder::RunFolder;
use record::sink::{Level, NullSink, RecordSink};
use scribe::Scribe;
use std::path::Path;
use std::sync::Arc;

/// A log that has become a run.
#[derive(Debug)]
pub struct Imported {
    /// What it came to.
    pub summary: Summary,
    /// The channel that the base is on.
    pub channel: Channel,
    /// Moves of the base that the plan has, too.
    pub moves: u64,
    /// What of the log is not in the record.
    pub left_out: LeftOut,
    /// Measurements of the plan that no log of a CAN bus can make, and why not.
    pub unjudged: Vec<(String, &'static str)>,
}

/// Makes a run folder of a log of a rig and judges it by its plan: every node says what it says in the log, and the plan
/// listens. What the plan itself would do to the rig is taken to be in the log.
///
/// # Errors
/// When the log cannot be read, does not hold the lines of the rig, or the folder cannot be written.
pub fn import_rig_to_folder(
    prepared: &Prepared,
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    channel: Option<Channel>,
    out: &Path,
) -> Result<Summary, ImportError> {
    let log = logged(entries)?;
    let named = channel.as_ref().map(Channel::as_str);
    let rig = prepared.rig.clone().replayed_by(&log, named);
    let rig = rig.map_err(|(line, known)| ImportError::NoLine { line, known: known.join(", ") })?;
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
    summary.wall_s = summary.simulated_s;
    write_documents(&RunFolder::open(out)?, &summary, &prepared.header(seed))?;
    Ok(summary)
}

/// Makes a run folder of a log and judges it by `plan`. Without a `channel` it is the one on which the
/// first frame of a base is.
///
/// # Errors
/// When the plan moves no base, the log cannot be read or holds no base, or the folder cannot be written.
pub fn import_to_folder(
    plan: &Arc<Plan>,
    entries: impl IntoIterator<Item = Result<Entry, LogError>>,
    channel: Option<Channel>,
    out: &Path,
) -> Result<Imported, ImportError> {
    if !follow::moves_base(plan) {
        return Err(ImportError::NothingMoves { plan: plan.name.as_str().to_owned() });
    }
    let mut scribe = Scribe::new(plan, channel);
    // A log without a base makes no folder.
    let mut entries = entries.into_iter();
    let first = loop {
        let entry = entries.next().ok_or(ImportError::NoBase)??;
        if scribe.hears_base(&entry) {
            break entry;
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
    let lasted_s = scribe.now().as_secs_f64();
    let summary = Summary {
        outcome,
        reason,
        plan: plan.name.as_str().to_owned(),
        title: plan.title.clone(),
        version: VERSION.to_owned(),
        seed: 0,
        clock: IMPORTED.to_owned(),
        bus: "can".to_owned(),
        device_under_test: "unknown".to_owned(),
        simulated_s: lasted_s,
        wall_s: lasted_s,
        events: scribe.frames(),
        measurements,
        artifacts: Vec::new(),
        timing: None,
        ports: Vec::new(),
        commands: Vec::new(),
        faults: Vec::new(),
        properties: unjudged::properties(plan),
    };
    write_documents(&folder, &summary, &header)?;
    let unjudged = unjudged::of_plan(plan);
    let (moves, left_out) = (scribe.moves(), scribe.left_out());
    Ok(Imported { summary, channel, moves, left_out, unjudged })
}
