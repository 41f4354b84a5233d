//! What a campaign on a trial found.

use super::folder::Folder;
use crate::campaign::Campaign;
use crate::console::{Style, campaign_table};
use std::fmt;
use std::path::{Path, PathBuf};

/// The smallest case that breaks a property.
#[derive(Debug, Clone, PartialEq)]
pub struct Smallest {
    /// The property; [`PASSES`](crate::campaign::PASSES) where the plan does not pass.
    pub property: String,
    /// What was seen.
    pub what: String,
    /// The seed that it breaks with.
    pub seed: u64,
    /// The plan with its faults, in TOML; of a plan that was built in code the faults alone.
    pub plan: String,
    /// Where that is saved.
    pub path: PathBuf,
}

/// What a campaign came to. It prints as the table of `hil campaign` and the smallest case of each property that broke.
#[derive(Debug)]
pub struct TrialFindings {
    campaign: Campaign,
    smallest: Vec<Smallest>,
    folder: Folder,
}

impl TrialFindings {
    pub(super) fn new(campaign: Campaign, smallest: Vec<Smallest>, folder: Folder) -> Self {
        let mut findings = Self { campaign, smallest, folder };
        if !findings.held() {
            findings.folder.keep();
        }
        findings
    }

    /// No case broke anything.
    pub const fn held(&self) -> bool {
        self.smallest.is_empty()
    }

    /// The smallest case of each property that broke.
    pub fn smallest(&self) -> &[Smallest] {
        &self.smallest
    }

    /// What was counted.
    pub const fn campaign(&self) -> &Campaign {
        &self.campaign
    }

    /// Where cases and plans are. A temporary folder is removed with this where nothing broke.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

impl fmt::Display for TrialFindings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let saved: Vec<_> = self.smallest.iter().map(|one| one.path.clone()).collect();
        write!(f, "\n{}", campaign_table(&self.campaign, &saved, None, Style::PLAIN))?;
        for Smallest { path, plan, .. } in &self.smallest {
            write!(f, "\n--- {}\n{plan}", path.display())?;
        }
        Ok(())
    }
}
