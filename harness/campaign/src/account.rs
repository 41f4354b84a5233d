//! What a campaign was to do and what came of it: `campaign.json` of its folder, beside the journal of its cases.
//!
//! It is written when a campaign begins and again when it ends: one that was killed is known as such by it.

use super::case::{Case, Repeated};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the file in the folder of a campaign.
pub const ACCOUNT: &str = "campaign.json";

/// Version of the file that is written, and the only one that is read.
const SCHEMA: u32 = 1;

/// The longest file that is read.
const BYTES_MAX: u64 = 64 * 1024 * 1024;

/// What a campaign was to do, and its end.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Account {
    /// Format of the file.
    pub schema: u32,
    /// Version of the harness.
    pub version: String,
    /// Name of the plan that was struck.
    pub plan: String,
    /// Its title.
    pub title: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// What chose the next case.
    pub search: String,
    /// Cases that were asked for.
    pub asked: u64,
    /// Faults of one case, at most.
    pub faults_max: usize,
    /// Who carried the cases out.
    pub carried_out_by: String,
    /// What is added to `hil run PLAN --seed N` to carry a case out there.
    pub replay: String,
    /// How long a run without faults takes, s of bench time.
    pub horizon_s: f64,
    /// What could strike.
    pub kinds: Vec<Struck>,
    /// Phases of the plan that a fault could be tied to.
    pub phases: Vec<String>,
    /// States that should come about.
    pub states: Vec<String>,
    /// What it came to; absent while it goes on, and where it was killed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<End>,
}

/// A kind of fault, and what it strikes.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Struck {
    /// The kind.
    pub kind: String,
    /// What it strikes.
    pub target: String,
}

/// What a campaign came to, beside what its journal says.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct End {
    /// How long it took, s; since it was resumed, if it was.
    pub wall_s: f64,
    /// Cases that were done before it was resumed.
    pub resumed: u64,
    /// It was stopped before its end.
    pub stopped: bool,
    /// The smallest case of each property that broke.
    pub found: Vec<FoundCase>,
    /// Properties that could not be judged, and why.
    pub not_judged: BTreeMap<String, String>,
}

/// The smallest case that breaks a property.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FoundCase {
    /// The property.
    pub property: String,
    /// Number of the first case that broke it.
    pub number: u64,
    /// Cases that broke it.
    pub times: u64,
    /// Bench time when it broke, s.
    pub at_s: f64,
    /// What was seen then.
    pub what: String,
    /// Runs that it took to make it small.
    pub executions: u64,
    /// The smallest case.
    pub case: Case,
    /// Its plan, as a path from where the campaign was started.
    pub plan: String,
    /// The same in the folder of the campaign; absent where it went elsewhere.
    pub file: Option<String>,
    /// Where runs differ: what repeating it came to.
    pub repeated: Option<Repeated>,
}

/// Why an account cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AccountError {
    /// It cannot be read or written.
    #[error("failed to keep {}", path.display())]
    #[diagnostic(help(
        "`hil campaign` with the same arguments goes on where it stopped, and writes it anew"
    ))]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is none, or another program wrote it.
    #[error("failed to understand {} as the account of a campaign", path.display())]
    #[diagnostic(help(
        "`hil campaign` with the same arguments goes on where it stopped, and writes it anew"
    ))]
    Foreign {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// Another version wrote it.
    #[error("{} is of format {found}, and {SCHEMA} is the one that is known here", path.display())]
    #[diagnostic(help("draw it with the version of hil that made it, {version}"))]
    Version {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u32,
        /// The harness that wrote it.
        version: String,
    },
}

impl Account {
    /// Of a campaign that begins, of this version.
    pub fn new() -> Self {
        Self { schema: SCHEMA, version: record::VERSION.to_owned(), ..Self::default() }
    }

    /// Writes it into the folder of the campaign.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), AccountError> {
        let path = folder.join(ACCOUNT);
        let written = serde_json::to_vec_pretty(self).map_err(io::Error::from);
        written
            .and_then(|text| std::fs::write(&path, text))
            .map_err(|source| AccountError::Io { path, source })
    }

    /// Reads it from there.
    ///
    /// # Errors
    ///
    /// When there is none, or none of this version.
    pub fn read(folder: &Path) -> Result<Self, AccountError> {
        use io::Read as _;
        let path = folder.join(ACCOUNT);
        let mut text = Vec::new();
        let read =
            std::fs::File::open(&path).and_then(|file| file.take(BYTES_MAX).read_to_end(&mut text));
        if let Err(source) = read {
            return Err(AccountError::Io { path, source });
        }
        let head: Head = match serde_json::from_slice(&text) {
            Ok(head) => head,
            Err(source) => return Err(AccountError::Foreign { path, source }),
        };
        if head.schema != SCHEMA {
            return Err(AccountError::Version { path, found: head.schema, version: head.version });
        }
        serde_json::from_slice(&text).map_err(|source| AccountError::Foreign { path, source })
    }
}

/// What every version says.
#[derive(Deserialize)]
struct Head {
    schema: u32,
    version: String,
}

#[cfg(test)]
mod tests {
    use super::{ACCOUNT, Account, AccountError};

    #[test]
    fn what_is_written_is_read_and_other_versions_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(Account::read(folder.path()), Err(AccountError::Io { .. })));
        let account = Account { plan: "laps".to_owned(), seed: u64::MAX, ..Account::new() };
        account.write(folder.path()).unwrap();
        assert_eq!(Account::read(folder.path()).unwrap(), account);
        let path = folder.path().join(ACCOUNT);
        std::fs::write(&path, r#"{"schema": 9, "version": "3.1.0"}"#).unwrap();
        let error = Account::read(folder.path()).unwrap_err();
        assert!(error.to_string().contains("format 9, and 1 is the one"), "{error}");
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert!(help.contains("3.1.0"), "{help}");
        std::fs::write(&path, "[]").unwrap();
        assert!(matches!(Account::read(folder.path()), Err(AccountError::Foreign { .. })));
    }
}
