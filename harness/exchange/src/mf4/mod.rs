//! A run as one MDF 4 file with measured channels, for asammdf and measurement tools: `hil export RUN --mf4 FILE.mf4`.
//!
//! | group | channels beside `time_s` |
//! |---|---|
//! | `states`, `truth`, `health`, `events`, `measurements` | columns of these tables ([`crate::tables`]) |
//! | `observations/QUANTITY` | `value`, `uncertainty`, and one per tag |
//! | `messages/SENDER.MESSAGE` | one per signal; names of its values if the layout has them; `messages/SENDER.LINE.MESSAGE` if the message is sent on several lines |
//!
//! The master channel of each group is `time_s`, bench time in seconds since the start of the run. A record holds no
//! date, so the measurement begins at 1970-01-01, and two runs with one seed give the same file, byte for byte. Raw
//! frames are not measured values: `hil export RUN --bus FILE.mf4` has them.

mod groups;

use crate::exported::{ExportError, Exported, facts};
use crate::tables::survey::Survey;
use crate::tables::{Ears, pour};
use bus_log::LogError;
use bus_log::mdf4::channels::Writer;
use groups::Groups;
use record::run_folder::RunFolder;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Writes a surveyed run as an MDF 4 file. A truncated record gives the records before the cut; the survey and the
/// comment of the file report the cut.
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
    let file = File::create(path)
        .map_err(|source| LogError::Unwritable { path: path.to_owned(), source })?;
    let writer = Writer::new(path, BufWriter::new(file))?;
    let mut groups = Groups::new(writer);
    let survey = pour((folder, summary.as_ref()), (survey, ears), &mut groups, ExportError::from)?;
    let facts = facts(&survey, summary.as_ref());
    let facts: Vec<_> = facts.iter().map(|(name, fact)| (name.as_str(), fact.clone())).collect();
    Ok(Exported { written: groups.into_writer().finish(&facts)?, survey })
}
