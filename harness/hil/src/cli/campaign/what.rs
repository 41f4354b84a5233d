//! The kinds and targets of faults that were asked for, and all else that determines the cases of a campaign and the runs
//! of an envelope, as their journals state it: what was carried out with another plan or another program under test does
//! not count.

use super::{CampaignArguments, Task};
use crate::choices::word;
use crate::cli::envelopes::kind;
use crate::cli::failure::Failure;
use crate::cli::setup::{Controller, words};
use campaign::{CaseId, Targets};
use harness::run::Prepared;
use live::command::find;
use plan::bench_file::{BenchFile, ControllerSection};
use plan::rig::UnderTest;
use std::fs;
use std::path::{Path, PathBuf};

impl CampaignArguments {
    /// Checks the names of kinds and targets, before anything is run.
    pub(super) fn known(&self, prepared: &Prepared) -> Result<(), Failure> {
        let mut names = self.faults.iter().chain(&self.without);
        names.try_for_each(|name| kind(name).map(|_| ()))?;
        if let Some(both) = self.without.iter().find(|name| self.faults.contains(name)) {
            return Err(Failure::arguments(
                format!("{both} is asked for by --faults and left out by --without"),
                "leave it out of one of them",
            ));
        }
        if self.envelopes.is_asked() {
            return Ok(());
        }
        self.struck(prepared).map(|_| ())
    }

    /// What the faults of a search strike.
    pub(super) fn struck(&self, prepared: &Prepared) -> Result<Targets, Failure> {
        let rig = &prepared.rig;
        let under_test = rig.under_test_names().into_iter().map(str::to_owned).collect();
        Targets::named(&self.targets, &rig.struck(), under_test).map_err(|unknown| {
            Failure::arguments(format!("--target: {}", unknown.message), unknown.help)
        })
    }

    /// The target of an envelope.
    pub(super) fn only_target(&self) -> Result<Option<&str>, Failure> {
        match self.targets.as_slice() {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            _ => Err(Failure::arguments(
                "an envelope is of one target, and --target names several",
                "measure one after the other: the folder keeps them all",
            )),
        }
    }

    /// Describes what determines the cases of the campaign; `bench` names where they are carried out.
    pub(super) fn what(&self, task: &Task<'_>, bench: &str) -> String {
        let targets = match self.targets.as_slice() {
            [] => String::new(),
            targets => format!(" of {}", targets.join("/")),
        };
        let without = match self.without.as_slice() {
            [] => String::new(),
            kinds => format!(" without {}", kinds.join("/")),
        };
        format!(
            "{}, by {}, seed {}, up to {} of {}{without}{targets}{bench}",
            self.under_test(task),
            word(&self.by),
            self.seed,
            self.faults_max,
            if self.faults.is_empty() { "all faults".to_owned() } else { self.faults.join("/") },
        )
    }

    /// Describes what determines the runs of envelopes: the cases contain their own seeds and faults.
    pub(super) fn envelopes_of(&self, task: &Task<'_>) -> String {
        format!("envelopes of {}", self.under_test(task))
    }

    /// Describes the plan with all files that it names, and the device under test.
    fn under_test(&self, task: &Task<'_>) -> String {
        let plan = &task.prepared.plan.name;
        let files = &task.prepared.files;
        let texts = files.0.iter().map(|file| format!("{}\n{}\n", file.name, file.text));
        let texts: String = std::iter::once(task.source.to_owned()).chain(texts).collect();
        let id = campaign::Case::default().id(&texts);
        let with = match self.setup.replay() {
            ours if ours.is_empty() => ours,
            other => format!(", {other}"),
        };
        let programs = match self.programs(task) {
            none if none.is_empty() => String::new(),
            some => format!(", program under test {}", short(CaseId::of(&some))),
        };
        format!("{plan}, plan and its files {}{programs}{with}", short(id))
    }

    /// The contents of the programs under test.
    fn programs(&self, task: &Task<'_>) -> Vec<Vec<u8>> {
        let of_rig = task.prepared.rig.under_test().filter_map(|(_, how)| match how {
            UnderTest::Command(words) => Some(words.clone()),
            UnderTest::InProcess(_) | UnderTest::Attached(_) => None,
        });
        let of_line = match &self.setup.controller {
            Some(Controller::Command(line)) => Some(words(line)),
            None | Some(Controller::InProcess | Controller::Process) => None,
        };
        let of_bench = self.setup.bench.as_deref().and_then(|name| BenchFile::load(name).ok());
        let of_bench = of_bench.and_then(|bench| match bench.controller? {
            ControllerSection::Command(words) => Some(words),
            ControllerSection::InProcess | ControllerSection::Attach(_) => None,
        });
        let commands: Vec<Vec<String>> = of_rig.chain(of_line).chain(of_bench).collect();
        commands
            .iter()
            .flat_map(|words| files(words))
            .filter_map(|path| fs::read(path).ok())
            .collect()
    }
}

/// As much of it as tells two texts apart.
fn short(id: CaseId) -> String {
    id.to_string().chars().take(16).collect()
}

/// The program that a command starts, and the first file among its arguments: the script of an interpreter, or what another
/// program is given. Further ones may be what it writes.
fn files(words: &[String]) -> Vec<PathBuf> {
    let Some((program, arguments)) = words.split_first() else { return Vec::new() };
    let script = arguments.iter().map(PathBuf::from).find(|path| path.is_file());
    find(Path::new(program)).into_iter().chain(script).collect()
}
