//! Findings of a campaign on a trial.

use super::folder::Folder;
use crate::campaign::Campaign;
use crate::console::{Style, campaign_table};
use std::fmt;
use std::path::{Path, PathBuf};

/// The smallest case that breaks a property.
#[derive(Debug, Clone, PartialEq)]
pub struct Smallest {
    /// The property; [`PASSES`](crate::campaign::PASSES) if the plan does not pass.
    pub property: String,
    /// The violation.
    pub what: String,
    /// Seed of the failing case.
    pub seed: u64,
    /// The plan with its faults, in TOML; for a plan built in code only the faults.
    pub plan: String,
    /// File in which it is saved.
    pub path: PathBuf,
}

/// Result of a campaign. It prints as the table of `hil campaign`, followed by the smallest case of each broken
/// property.
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

    /// Whether no case broke anything, and some run reached each state that the plan demands.
    pub const fn held(&self) -> bool {
        self.smallest.is_empty() && self.campaign.missed.is_empty()
    }

    /// The smallest case of each property that broke.
    pub fn smallest(&self) -> &[Smallest] {
        &self.smallest
    }

    /// The statistics of the campaign.
    pub const fn campaign(&self) -> &Campaign {
        &self.campaign
    }

    /// Folder of cases and plans. A temporary folder is removed with this value if nothing broke.
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
