//! Runs a plan and writes a run folder.

use super::{Ended, Prepared, simulate_across};
use crate::calibrations;
#[cfg(feature = "report")]
use crate::junit;
use crate::made::Made;
use crate::models;
use crate::outcome::{Outcome, PropertySummary, Summary};
use crate::program::DEVICE_LOG;
use crate::record::VERSION;
use crate::record::figures;
use crate::record::header::Header;
use crate::record::sink::Level;
#[cfg(feature = "report")]
use crate::report;
#[cfg(feature = "report")]
use crate::run_folder::JUNIT;
use crate::run_folder::{RunFolder, RunFolderError};
use crate::watch::{Feed, Watched};
use plan::rig::UnderTest;
use rig::Pulse;
use rig::crossing::{MaybeCrossing, bus_of};
use rig::operator::Answers;
use std::path::Path;

/// Options of a run with a run folder.
#[derive(Debug, Clone)]
pub struct Options<'a> {
    /// The seed.
    pub seed: u64,
    /// Path of the run folder.
    pub out: &'a Path,
    /// How much is recorded.
    pub level: Level,
    /// Answers to questions of the plan.
    pub answers: Answers,
}

/// A completed run.
#[derive(Debug, Clone)]
pub struct Completed {
    /// The summary, even if a file could not be written.
    pub summary: Summary,
    /// Calibrations and models that the plan made.
    pub made: Made,
    /// Number of items that the lines dropped for lack of room.
    pub dropped: u64,
}

/// Runs a prepared plan in virtual time, judges it and writes its run folder. `wall_s` returns seconds since some fixed
/// instant.
///
/// A file that cannot be written, for example on a full disk, makes the outcome [`Outcome::Error`]; the reason names
/// the file and the cause.
///
/// # Errors
///
/// When the run folder cannot be made, holds foreign files or is in use; then nothing ran.
pub fn run_to_folder(
    prepared: &Prepared,
    options: &Options<'_>,
    pulse: Pulse<'_>,
    wall_s: &dyn Fn() -> f64,
) -> Result<Completed, RunFolderError> {
    run_to_folder_watched(None, prepared, options, None, pulse, wall_s)
}

/// Like [`run_to_folder`], with all traffic sent through `crossing`, whose bus the summary names, and shown to `feed`
/// during the run. The record is the same with and without either.
///
/// # Errors
///
/// When the run folder cannot be made, holds foreign files or is in use; then nothing ran.
pub fn run_to_folder_watched(
    crossing: MaybeCrossing,
    prepared: &Prepared,
    options: &Options<'_>,
    feed: Option<&Feed>,
    pulse: Pulse<'_>,
    wall_s: &dyn Fn() -> f64,
) -> Result<Completed, RunFolderError> {
    let began_s = wall_s();
    let folder = RunFolder::create(options.out)?;
    let header = prepared.header(options.seed);
    let mut sink = Watched::new(folder.record_sink(&header, options.level)?, feed);
    let bus = bus_of(&crossing);
    let programs = prepared.programs.logging(folder.file(DEVICE_LOG));
    let logging = Prepared { programs, ..prepared.clone() };
    let run = simulate_across(crossing, &logging, options.seed, &options.answers, &mut sink, pulse);
    drop(sink);
    let mut summary = summarise(prepared, options.seed, &run);
    bus.clone_into(&mut summary.bus);
    summary.wall_s = wall_s() - began_s;
    let has_program =
        prepared.rig.under_test().any(|(_, how)| matches!(how, UnderTest::Command(_)));
    summary.notes.extend(slower(&summary).filter(|_| has_program));
    if folder.file(DEVICE_LOG).is_file() {
        summary.artifacts.push(DEVICE_LOG.to_owned());
    }
    Ok(keep(&folder, &header, summary, run))
}

/// What a program computes takes no bench time. If that is longer than the bench ran, its deadlines say little.
fn slower(summary: &Summary) -> Option<String> {
    (summary.outcome == Outcome::Passed && summary.wall_s > summary.simulated_s).then(|| {
        format!(
            "the run took {} for {} of bench time: what a program computes takes no virtual time, so that it keeps a \
             deadline however long it computes; with --clock real it counts",
            figures::duration(summary.wall_s),
            figures::duration(summary.simulated_s),
        )
    })
}

/// Writes the files of a completed run. A file that cannot be written makes the outcome an error.
pub(crate) fn keep(
    folder: &RunFolder,
    header: &Header,
    mut summary: Summary,
    run: Ended,
) -> Completed {
    if let Err(error) = write_made(folder, &run.made, &mut summary) {
        broke(&mut summary, &error);
    }
    if let Err(error) = write_documents(folder, &summary, header) {
        broke(&mut summary, &error);
        // A summary may fit on the disk where a report did not. If not, the caller still has it.
        let _ = folder.write_summary(&summary);
    }
    Completed { summary, made: run.made, dropped: run.dropped }
}

fn write_made(
    folder: &RunFolder,
    made: &Made,
    summary: &mut Summary,
) -> Result<(), RunFolderError> {
    let origin = format!("made by plan {}, seed {}", summary.plan, summary.seed);
    let mut files = Vec::new();
    for (name, calibration) in &made.calibrations {
        files.push((format!("{name}.toml"), calibrations::to_toml(calibration, &origin)));
    }
    for (name, model) in &made.models {
        files.push((format!("{name}.model.toml"), models::to_toml(model, &origin)));
    }
    for (name, finding) in &made.findings {
        files.push((format!("{name}.finding.json"), models::to_json(finding)));
    }
    for (file, text) in files {
        folder.write_artifact(&file, text.as_bytes())?;
        summary.artifacts.push(file);
    }
    Ok(())
}

/// Writes summary, JUnit file and report of a run with a complete record: as many of them as possible.
///
/// # Errors
///
/// The first error: a file cannot be written, or the record cannot be read.
pub fn write_documents(
    folder: &RunFolder,
    summary: &Summary,
    header: &Header,
) -> Result<(), RunFolderError> {
    let summarised = folder.write_summary(summary);
    summarised.and(write_views(folder, summary, header))
}

#[cfg(feature = "report")]
fn write_views(
    folder: &RunFolder,
    summary: &Summary,
    header: &Header,
) -> Result<(), RunFolderError> {
    let listed = match junit::document(summary, Some(folder.path())) {
        Ok(xml) => folder.write_junit(&xml),
        Err(error) => Err(RunFolderError::Write {
            path: folder.file(JUNIT),
            source: std::io::Error::other(error),
        }),
    };
    let drawn = folder
        .records()
        .and_then(|records| folder.write_report(&report::render(summary, header, records)));
    listed.and(drawn)
}

/// Without the feature `report` only record and summary are written; `hil report` draws the page later.
#[cfg(not(feature = "report"))]
fn write_views(_: &RunFolder, _: &Summary, _: &Header) -> Result<(), RunFolderError> {
    Ok(())
}

/// Makes the outcome an error, unless it is worse. Known reasons come first.
fn broke(summary: &mut Summary, error: &RunFolderError) {
    // Without a record there is nothing to draw; that needs no message.
    let is_consequence = matches!(error, RunFolderError::Record { .. });
    if is_consequence && summary.outcome >= Outcome::Error {
        return;
    }
    let cause = std::error::Error::source(error);
    let text = cause.map_or_else(|| error.to_string(), |cause| format!("{error}: {cause}"));
    worsen(summary, Outcome::Error, text);
}

/// Makes the outcome no better than `outcome`, with the reason after those already known.
pub(super) fn worsen(summary: &mut Summary, outcome: Outcome, why: String) {
    summary.outcome = summary.outcome.max(outcome);
    summary.reason = match summary.reason.take() {
        Some(reason) => Some(format!("{reason}. {why}")),
        None => Some(why),
    };
}

/// Judges a run as one in virtual time; the live world changes the summary.
pub fn summarise(prepared: &Prepared, seed: u64, run: &Ended) -> Summary {
    let (measurements, judged) = run.judge(&prepared.plan.measurements);
    let outcome = match run.ending.outcome {
        Outcome::Passed => judged,
        ended => ended,
    };
    let mut summary = Summary {
        outcome,
        reason: run.ending.reason.clone(),
        plan: prepared.plan.name.as_str().to_owned(),
        title: prepared.plan.title.clone(),
        version: VERSION.to_owned(),
        seed,
        clock: "virtual".to_owned(),
        bus: "memory".to_owned(),
        device_under_test: prepared.device_under_test(),
        simulated_s: run.end.as_secs_f64(),
        wall_s: 0.0,
        events: run.events,
        measurements,
        artifacts: Vec::new(),
        bench: None,
        timing: None,
        ports: Vec::new(),
        commands: run.commands.clone(),
        faults: run.faults.clone(),
        properties: properties(prepared, run),
        notes: prepared
            .rig
            .notes
            .iter()
            .chain(&run.notes)
            .cloned()
            .chain(without_effect(run))
            .collect(),
    };
    if let Some(why) = breach(&summary.properties) {
        worsen(&mut summary, Outcome::Failed, why);
    }
    summary
}

/// A sentence about each fault of the plan that changed nothing: the verdicts are those of a run without it.
fn without_effect(run: &Ended) -> impl Iterator<Item = String> + '_ {
    run.faults.iter().filter_map(|fault| match (fault.begun, fault.acted) {
        (false, _) => Some(format!("fault {} never began: {}", fault.index, fault.name)),
        (true, 0) => Some(format!("fault {} changed nothing: {}", fault.index, fault.name)),
        (true, _) => None,
    })
}

/// Summaries of the plan's properties, in the order of declaration.
pub(super) fn properties(prepared: &Prepared, run: &Ended) -> Vec<PropertySummary> {
    let judged = run.properties.iter().map(PropertySummary::from);
    let mut all: Vec<_> = judged.chain(run.unjudged.iter().map(Into::into)).collect();
    let declared = &prepared.plan.properties;
    let place = |one: &PropertySummary| declared.iter().position(|known| known.name() == one.name);
    all.sort_by_key(place);
    all
}

/// A sentence about the property that broke first; states that never came about are behind the others.
pub(super) fn breach(properties: &[PropertySummary]) -> Option<String> {
    let broken = properties.iter().filter(|property| property.is_broken());
    let at_s = |property: &&PropertySummary| property.broken_s.unwrap_or(f64::INFINITY);
    broken.min_by(|one, other| at_s(one).total_cmp(&at_s(other))).map(PropertySummary::breach)
}
