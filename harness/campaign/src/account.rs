//! The settings and the result of a campaign: `campaign.json` in its folder, beside the journal of its cases.
//!
//! It is written when a campaign begins and again when it ends, so it shows whether a campaign was killed.

use super::case::{Case, Repeated};
use plan::faults::{FaultKind, Reach, Target};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the file in the folder of a campaign.
pub const ACCOUNT: &str = "campaign.json";

/// Version of the file format, the only one that can be read.
const SCHEMA: u32 = 1;

/// The longest file that can be read.
const BYTES_MAX: u64 = 64 * 1024 * 1024;

/// The settings of a campaign, and its end.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Account {
    /// Format of the file.
    pub schema: u32,
    /// Version of the harness.
    pub version: String,
    /// Name of the plan under test.
    pub plan: String,
    /// Title of the plan.
    pub title: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Name of the search that chose the cases.
    pub search: String,
    /// Number of cases requested.
    pub asked: u64,
    /// The most faults in one case.
    pub faults_max: usize,
    /// The machine or bench that carried the cases out.
    pub carried_out_by: String,
    /// Arguments to add to `hil run PLAN --seed N` to carry a case out there.
    pub replay: String,
    /// Duration of a run without faults, s of bench time.
    pub horizon_s: f64,
    /// The possible faults.
    pub kinds: Vec<Struck>,
    /// Phases of the plan that a fault could be tied to.
    pub phases: Vec<String>,
    /// For keys of steps among the phases: the labels of these steps, in their order.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, Vec<String>>,
    /// States that the campaign should reach.
    pub states: Vec<String>,
    /// The result; absent while the campaign runs, and if it was killed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<End>,
}

/// A kind of fault and its target.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Struck {
    /// The kind.
    pub kind: String,
    /// The target.
    pub target: String,
}

impl Struck {
    /// What a fault strikes; of messages and signals the node, which may have a thousand of them.
    pub fn of(kind: FaultKind, target: &Target) -> Self {
        let of_message = matches!(kind.info().reach, Reach::Message(_));
        let target = if of_message { target.node() } else { target.name() };
        Self { kind: kind.name().to_owned(), target: target.to_owned() }
    }
}

/// The result of a campaign, beyond its journal.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct End {
    /// Duration, s, since the last resumption.
    pub wall_s: f64,
    /// Number of cases done before it was resumed.
    pub resumed: u64,
    /// Whether it was stopped before its end.
    pub stopped: bool,
    /// The smallest case for each broken property.
    pub found: Vec<FoundCase>,
    /// Properties that could not be judged, with the reason.
    pub not_judged: BTreeMap<String, String>,
}

/// The smallest case that breaks a property.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FoundCase {
    /// The property.
    pub property: String,
    /// Number of the first case that broke it.
    pub number: u64,
    /// Number of cases that broke it.
    pub times: u64,
    /// Bench time of the violation, s.
    pub at_s: f64,
    /// The observation at that time.
    pub what: String,
    /// Number of runs that shrinking took.
    pub executions: u64,
    /// The smallest case.
    pub case: Case,
    /// Path of its plan, relative to the folder in which the campaign was started.
    pub plan: String,
    /// The same file in the folder of the campaign; absent if it was written elsewhere.
    pub file: Option<String>,
    /// Result of the repetitions, if runs differ.
    pub repeated: Option<Repeated>,
}

/// Why an account cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AccountError {
    /// The file cannot be read or written.
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
    /// The file is not an account, or is from another program.
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
    /// The file is from another version.
    #[error("{} is of format {found}, and {SCHEMA} is the one that is known here", path.display())]
    #[diagnostic(help("draw it with the version of hil that made it, {version}"))]
    Version {
        /// The file.
        path: PathBuf,
        /// Format of the file.
        found: u32,
        /// Version of the harness that wrote it.
        version: String,
    },
}

impl Account {
    /// The account of a new campaign, with this version.
    pub fn new() -> Self {
        Self { schema: SCHEMA, version: record::VERSION.to_owned(), ..Self::default() }
    }

    /// Writes the account into the folder of the campaign.
    ///
    /// # Errors
    ///
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), AccountError> {
        let path = folder.join(ACCOUNT);
        let written = serde_json::to_vec_pretty(self).map_err(io::Error::from);
        written
            .and_then(|text| std::fs::write(&path, text))
            .map_err(|source| AccountError::Io { path, source })
    }

    /// Reads the account from the folder.
    ///
    /// # Errors
    ///
    /// When there is no account, or it has another version.
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

/// The part that all versions have in common.
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
