//! What an export gives, and facts about a run as a whole for formats that have a place for them.

use crate::tables::survey::Survey;
use bus_log::LogError;
use record::outcome::Summary;
use record::run_folder::RunFolderError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(crate) type Boxed = Box<dyn std::error::Error + Send + Sync>;

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ExportError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    #[error("refused to replace {}: it holds files and is no package of tables", path.display())]
    #[diagnostic(help("choose another folder: hil export RUN --tables DIR"))]
    Foreign { path: PathBuf },
    #[error("failed to write {}", path.display())]
    Write { path: PathBuf, source: Boxed },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Log(#[from] LogError),
}

impl ExportError {
    pub(crate) fn write(path: &Path, source: impl Into<Boxed>) -> Self {
        Self::Write { path: path.to_owned(), source: source.into() }
    }
}

#[derive(Debug)]
pub struct Exported {
    /// Each table, topic or channel group with its number of rows; one without rows is not written.
    pub written: Vec<(String, u64)>,
    /// Contents of the record, and whether it could be read to its end.
    pub survey: Survey,
}

/// Plan, seed, versions, whether the record is complete, and the result of the run if known.
pub(crate) fn facts(survey: &Survey, summary: Option<&Summary>) -> BTreeMap<String, String> {
    let header = &survey.header;
    let mut facts = BTreeMap::from([
        ("plan".to_owned(), header.plan.clone()),
        ("seed".to_owned(), header.seed.to_string()),
        ("version".to_owned(), header.harness.clone()),
        ("exported_by".to_owned(), concat!("hil ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("records".to_owned(), survey.records.to_string()),
        ("record".to_owned(), survey.wholeness()),
    ]);
    if let Some(summary) = summary {
        facts.extend([
            ("outcome".to_owned(), summary.outcome.name().to_owned()),
            ("clock".to_owned(), summary.clock.clone()),
            ("bus".to_owned(), summary.bus.clone()),
            ("device_under_test".to_owned(), summary.device_under_test.clone()),
        ]);
    }
    facts
}
