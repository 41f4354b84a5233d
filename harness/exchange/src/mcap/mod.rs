//! A run as one MCAP file, which Foxglove opens: `hil export RUN --mcap FILE.mcap`.
//!
//! | topics | schema | contents |
//! |---|---|---|
//! | `/base/pose`, `/base/true_pose`, `/absolute/pose`, `/absolute/lap_return` | `foxglove.PoseInFrame` | believed, true, measured |
//! | `/base/path`, `/base/true_path` | `foxglove.PosesInFrame` | one message per step in which the base moved, at its end: a lap, a side |
//! | `/tf` | `foxglove.FrameTransform` | `bench` to `base`, `base_true` and `lap_start` |
//! | `/log` | `foxglove.Log` | text for a person |
//! | `/controller/state`, `/controller/health`, `/base/truth`, `/can/frames`, `/serial/packets`, `/plan/measurements` | `hil.State`, ... | rows of the tables ([`crate::tables`]) |
//! | `/plan/steps`, `/plan/faults`, `/plan/notes`, `/plan/verdicts`, `/controller/missions` | `hil.Event` | rows of the events |
//! | `/observations/...` | `hil.observation....` | one topic per quantity |
//! | `/messages/...` | `hil.message....` | one topic per message of the base's or the device's layout; `/messages/LINE/MESSAGE` if it is sent on several lines |
//!
//! Messages are JSON with JSON Schemas. Foxglove documents both JSON and Protobuf for its own schemas and for others;
//! JSON needs no generated code and no second definition of each row, can be read without a schema, and loses most of
//! its redundancy under zstd (figures in `docs/exports.md`). Schemas hold no references, and no unions except the one
//! that Foxglove publishes: an unknown value is left out instead of null.
//!
//! Log time is bench time: nanoseconds since the start of the run, so that Foxglove shows a run from 1970-01-01. A
//! record holds no date, so two runs with one seed give the same file, byte for byte.
//!
//! Attachments are the summary, without the time that the run took on this machine, and the results of the plan; the
//! metadata `hil` hold plan, seed, outcome, versions, and whether the record is complete.

mod channels;
pub mod foxglove;
mod measured;
mod messages;
pub(crate) mod names;
pub mod schema;
mod trail;

use crate::exported::{ExportError, Exported, facts};
use crate::tables::survey::Survey;
use crate::tables::{Ears, pour};
use ::mcap::{McapError, McapResult};
use channels::Channels;
use messages::Messages;
use record::outcome::Summary;
use record::run_folder::{RunFolder, SUMMARY};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Largest file that is attached. Results of plans have a few kilobytes.
const ATTACHMENT_BYTES_MAX: u64 = 16 * 1024 * 1024;

const EPOCH: &str = "log time is bench time: nanoseconds since the run began";

/// Writes a surveyed run as an MCAP file. A truncated record gives the messages before the cut; the survey and the
/// file's metadata report the cut.
///
/// # Errors
/// When the run cannot be opened, or the file cannot be written.
pub fn export(
    folder: &RunFolder,
    survey: Survey,
    path: &Path,
    ears: Ears,
) -> Result<Exported, ExportError> {
    let summary = folder.summary_if_any()?;
    // The disk's own error, without what the library says around it.
    let failed = |source| match source {
        McapError::Io(source) => ExportError::write(path, source),
        other => ExportError::write(path, other),
    };
    let file = File::create(path).map_err(|source| failed(source.into()))?;
    let channels = Channels::new(BufWriter::new(file)).map_err(failed)?;
    let mut messages = Messages::new(channels);
    let survey = pour((folder, summary.as_ref()), (survey, ears), &mut messages, failed)?;
    let mut channels = messages.into_channels();
    attach(&mut channels, folder, summary.as_ref()).map_err(failed)?;
    let mut facts = facts(&survey, summary.as_ref());
    facts.insert("epoch".to_owned(), EPOCH.to_owned());
    channels.metadata("hil", facts).map_err(failed)?;
    let (mut out, written) = channels.finish().map_err(failed)?;
    out.flush().map_err(|source| failed(source.into()))?;
    Ok(Exported { written, survey })
}

fn attach(
    channels: &mut Channels<BufWriter<File>>,
    folder: &RunFolder,
    summary: Option<&Summary>,
) -> McapResult<()> {
    let Some(summary) = summary else { return Ok(()) };
    let mut value = serde_json::to_value(summary).unwrap_or(Value::Null);
    if let Some(fields) = value.as_object_mut() {
        fields.remove("wall_s");
    }
    channels.attach(SUMMARY, "application/json", format!("{value:#}\n").as_bytes())?;
    for name in &summary.artifacts {
        // Names come from a file: none may lead out of the folder.
        let plain = Path::new(name).file_name().is_some_and(|file| file == name.as_str());
        let path = folder.file(name);
        // Nor may a link: its target is not a file of the run.
        let small = fs::symlink_metadata(&path)
            .is_ok_and(|about| about.is_file() && about.len() <= ATTACHMENT_BYTES_MAX);
        if plain && small {
            channels.attach(name, media_type(name), &fs::read(&path)?)?;
        }
    }
    Ok(())
}

fn media_type(name: &str) -> &'static str {
    match Path::new(name).extension().and_then(|extension| extension.to_str()) {
        Some("json") => "application/json",
        Some("toml") => "application/toml",
        Some("csv") => "text/csv",
        Some("html") => "text/html",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    }
}
