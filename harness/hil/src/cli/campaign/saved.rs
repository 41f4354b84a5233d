//! The plans of the smallest cases, and the options with which they run again.

use super::{CampaignArguments, Task};
use crate::choices::word;
use crate::cli::failure::Failure;
use crate::cli::setup::Clock;
use campaign::{Account, Campaign, Regression, remove_saved};
use std::path::{Path, PathBuf};

/// A plan that an earlier part of the campaign saved.
#[derive(Debug)]
pub(super) struct Earlier {
    property: String,
    path: PathBuf,
}

/// The plans that the campaign in this folder has saved so far, before its account is written anew.
pub(super) fn earlier(folder: &Path) -> Vec<Earlier> {
    let end = Account::read(folder).ok().and_then(|account| account.end);
    let found = end.into_iter().flat_map(|end| end.found);
    found
        .map(|found| {
            // A path is that of the folder in which the campaign was started, which may have been another one.
            let beside = found.file.as_deref().filter(|name| Path::new(name).file_name().is_some());
            let name = beside.and_then(|name| Path::new(name).file_name());
            let path = name.map_or_else(|| PathBuf::from(&found.plan), |name| folder.join(name));
            Earlier { property: found.property, path }
        })
        .collect()
}

impl CampaignArguments {
    /// Saves the smallest cases, in place of those that an earlier part of the campaign saved.
    pub(super) fn save(
        &self,
        task: &Task<'_>,
        folder: &Path,
        done: &Campaign,
        earlier: Vec<Earlier>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let Task { source, prepared, .. } = *task;
        let again = self.again();
        let mut saved = Vec::new();
        for found in &done.found {
            let what = found.shrunk.result.violated.iter().find(|v| v.property == found.property);
            let regression = Regression {
                plan: prepared.plan.name.as_str(),
                text: source,
                project: prepared.project.as_deref(),
                property: &found.property,
                what: what.map_or("", |violated| violated.what.as_str()),
                case: &found.shrunk.case,
                small: found.shrunk.small(),
                again: Some(&again),
            };
            saved.push(regression.write(self.regressions.as_deref().unwrap_or(folder))?);
        }
        for one in earlier {
            let is_found = done.found.iter().any(|found| found.property == one.property);
            if is_found && !saved.contains(&one.path) {
                remove_saved(&one.path)?;
            }
        }
        Ok(saved)
    }

    /// Options with which `hil run` runs a case where the campaign ran it.
    pub(super) fn again(&self) -> String {
        let mut words = Vec::new();
        if self.setup.clock == Clock::Real {
            words.push("--clock real".to_owned());
            words.extend(self.setup.bus.map(|bus| format!("--bus {}", word(&bus))));
            words.extend(
                self.setup.bench.as_deref().map(|file| format!("--bench {}", quoted(file))),
            );
        }
        words.push(self.setup.replay());
        if self.setup.realtime {
            words.push("--realtime".to_owned());
        }
        words.retain(|word| !word.is_empty());
        words.join(" ")
    }
}

/// A word of a shell's command line.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./~+:,@%".contains(c);
    if word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::{CampaignArguments, quoted};
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        campaign: CampaignArguments,
    }

    /// Found by a user: the saved plan of a campaign on a bench said how to run it in virtual time.
    #[test]
    fn a_case_runs_again_with_the_clock_and_the_bench_of_the_campaign() {
        let again = |options: &str| {
            let words = ["campaign", "p"].into_iter().chain(options.split_whitespace());
            Line::parse_from(words).campaign.again()
        };
        assert_eq!(again(""), "");
        assert_eq!(again("--threads 2 --controller process"), "--controller process");
        let bench = "--clock real --bench benches/window.toml";
        assert_eq!(again(&format!("{bench} --cases 3 --repeat 4")), bench);
        let vcan = "--clock real --bus vcan --realtime";
        assert_eq!(again(vcan), vcan);
    }

    #[test]
    fn a_path_is_one_word() {
        assert_eq!(quoted("benches/window.toml"), "benches/window.toml");
        assert_eq!(quoted("my bench.toml"), "'my bench.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
