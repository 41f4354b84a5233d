//! Programs that a live run starts.

use super::Needs;
use super::finding::Finding;
use harness::world::live::our_program;
use rustix::fs::{Access, access};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Programs, and where they are.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct ProgramFacts {
    /// `k2a-controller`, our controller as a program.
    pub our_controller: Option<PathBuf>,
    /// The program of the bench, as it is written, and where it is.
    pub device_under_test: Option<(String, Option<PathBuf>)>,
}

pub(super) fn judge(facts: &ProgramFacts, needs: &Needs, findings: &mut Vec<Finding>) {
    findings.push(match &facts.our_controller {
        Some(path) => Finding::good("k2a-controller", path.display().to_string()),
        None => Finding::gap(
            "k2a-controller",
            "our controller is not beside hil, nor where PATH leads",
            "cargo build --release -p controller\n# or run with --controller in-process",
            needs.our_controller.clone(),
        ),
    });
    let Some((program, by)) = &needs.program else { return };
    let place = facts.device_under_test.as_ref().and_then(|(_, place)| place.as_ref());
    findings.push(match place {
        Some(path) => Finding::good(program, path.display().to_string()),
        None => Finding::gap(
            program,
            "the device under test is not there, or is no program",
            format!("# build it; a path is taken from the working directory\nchmod +x {program}"),
            Some(by.clone()),
        ),
    });
}

/// Looks for them as the shell would.
pub(super) fn gather(needs: &Needs) -> ProgramFacts {
    let named = |(program, _): &(String, String)| (program.clone(), find(Path::new(program)));
    ProgramFacts {
        our_controller: find(&our_program()),
        device_under_test: needs.program.as_ref().map(named),
    }
}

fn find(program: &Path) -> Option<PathBuf> {
    let can_run = |path: &PathBuf| path.is_file() && access(path, Access::EXEC_OK).is_ok();
    if program.components().count() > 1 {
        return Some(program.to_owned()).filter(can_run);
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(program)).find(can_run)
}
