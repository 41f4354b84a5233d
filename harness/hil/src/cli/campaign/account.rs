//! `campaign.json`, `junit.xml` and `report.html` of a campaign folder.

use super::super::failure::Failure;
use super::{CampaignArguments, JOURNAL, Task};
use crate::choices::word;
use campaign::{Account, Campaign, End, FoundCase, Space, Struck, each_line};
use harness::stopwatch::Stopwatch;
use plan::Plan;
use record::run_folder::{JUNIT, REPORT};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use views::console::Again;
use views::junit;
use views::report::campaign::{Gathered, page};

/// Who carries out the cases, and the options with which `hil run` repeats one.
pub(super) struct Place<'a> {
    pub(super) carried_out_by: String,
    pub(super) replay: &'a str,
}

/// An account under construction.
pub(super) struct Kept {
    folder: PathBuf,
    account: Account,
    watch: Stopwatch,
}

impl CampaignArguments {
    /// Removes the verdicts of an earlier campaign, as `hil run` does those of a run.
    pub(super) fn outdate(&self) {
        let plan = Path::new(&self.plan).file_stem().unwrap_or_default().to_string_lossy();
        let folder = self.folder("campaign", &plan);
        if is_campaign(&folder) {
            let _ = std::fs::remove_file(folder.join(JUNIT));
        }
    }

    pub(super) fn account(
        &self,
        task: &Task<'_>,
        space: &Space,
        states: &BTreeMap<String, bool>,
        place: Place<'_>,
    ) -> Result<Kept, Failure> {
        let plan = &task.prepared.plan;
        let mut kinds: Vec<Struck> = Vec::new();
        for (target, kind) in space.kinds() {
            let struck = Struck::of(*kind, target);
            if !kinds.contains(&struck) {
                kinds.push(struck);
            }
        }
        let account = Account {
            plan: plan.name.as_str().to_owned(),
            title: plan.title.clone(),
            seed: self.seed,
            search: word(&self.by),
            asked: self.cases,
            faults_max: space.faults_max(),
            carried_out_by: place.carried_out_by,
            replay: place.replay.to_owned(),
            horizon_s: space.horizon().as_secs_f64(),
            kinds,
            phases: phases(plan, space),
            labels: plan.labels(),
            states: states.keys().cloned().collect(),
            ..Account::new()
        };
        let folder = self.folder("campaign", plan.name.as_str());
        account.write(&folder)?;
        Ok(Kept { folder, account, watch: Stopwatch::start() })
    }
}

/// The phases to which a fault can be tied, in the order of the plan.
fn phases(plan: &Plan, space: &Space) -> Vec<String> {
    let can_be_struck = |name: &&str| space.phases().iter().any(|(one, _)| one.as_str() == *name);
    plan.phases_in_order().into_iter().filter(can_be_struck).map(str::to_owned).collect()
}

impl Kept {
    pub(super) fn plan(&self) -> &str {
        &self.account.plan
    }

    pub(super) fn replay(&self) -> &str {
        &self.account.replay
    }

    pub(super) fn end(
        mut self,
        done: &Campaign,
        saved: &[PathBuf],
        again: Option<&Again<'_>>,
    ) -> Result<PathBuf, Failure> {
        let confirmed = |index: usize| again?.confirmed.get(index).copied().flatten();
        let found = done.found.iter().zip(saved).enumerate().map(|(index, (found, path))| {
            let violated = &found.shrunk.result.violated;
            let what = violated.iter().find(|violated| violated.property == found.property);
            let beside = path.parent() == Some(&self.folder);
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            FoundCase {
                property: found.property.clone(),
                number: found.number,
                times: found.times,
                at_s: what.map_or(0.0, |violated| violated.at_s),
                what: what.map_or_else(String::new, |violated| violated.what.clone()),
                executions: found.shrunk.executions,
                case: found.shrunk.case.clone(),
                plan: path.display().to_string(),
                file: name.filter(|_| beside),
                repeated: confirmed(index),
            }
        });
        let not_judged = again.map_or(&[][..], |again| again.unjudged).iter();
        self.account.end = Some(End {
            wall_s: self.watch.elapsed_s(),
            resumed: done.tally.resumed,
            stopped: done.stopped,
            found: found.collect(),
            not_judged: not_judged.map(|one| (one.name.to_owned(), one.why.clone())).collect(),
        });
        self.account.write(&self.folder)?;
        let unjudged = again.map_or(&[][..], |again| again.unjudged);
        let path = self.folder.join(JUNIT);
        junit::campaign(&self.account, done, saved, unjudged, &self.folder)
            .map_err(io::Error::other)
            .and_then(|xml| std::fs::write(&path, xml))
            .map_err(|source| Failure::file(&path, source))?;
        draw(&self.folder)
    }
}

pub(in crate::cli) fn is_campaign(folder: &Path) -> bool {
    folder.join(JOURNAL).is_file()
}

/// Draws the page of the campaign in this folder from its account and its journal; returns its path.
pub(in crate::cli) fn draw(folder: &Path) -> Result<PathBuf, Failure> {
    let account = Account::read(folder)?;
    let mut gathered = Gathered::of(&account);
    each_line(&folder.join(JOURNAL), &mut |line| gathered.add(&line))?;
    let path = folder.join(REPORT);
    std::fs::write(&path, page(&account, &gathered))
        .map_err(|source| Failure::file(&path, source))?;
    Ok(path)
}
