//! Programs that a run in real time starts.

use super::Needs;
use super::finding::Finding;
use live::command::{find, missing_script};
use live::world::our_program;
use serde::Serialize;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct ProgramFacts {
    /// `k2a-controller`, our controller as a program.
    pub our_controller: Option<PathBuf>,
    pub under_test: Vec<ProgramFound>,
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct ProgramFound {
    pub words: Vec<String>,
    pub path: Option<PathBuf>,
    /// The interpreter of its first line, if missing.
    pub no_interpreter: Option<String>,
    /// The script that it runs, if missing.
    pub no_script: Option<String>,
}

/// Maximum length of a first line that names an interpreter, in bytes (`BINPRM_BUF_SIZE` of Linux).
const FIRST_LINE_MAX: u64 = 256;

pub(super) fn judge(facts: &ProgramFacts, needs: &Needs, findings: &mut Vec<Finding>) {
    if !needs.no_robot || needs.our_controller.is_some() {
        findings.push(match &facts.our_controller {
            Some(path) => Finding::good("k2a-controller", path.display().to_string()),
            None => Finding::gap(
                "k2a-controller",
                "our controller is not beside hil, nor where PATH leads",
                "cargo install --path harness/hil\n# or run with --controller in-process",
                needs.our_controller.clone(),
            ),
        });
    }
    for need in &needs.programs {
        let found = facts.under_test.iter().find(|found| found.words == need.words);
        let Some(program) = need.words.first() else { continue };
        let mut finding = judge_program(program, found, &need.by);
        if let Some(name) = &need.name {
            finding.subject.clone_from(name);
        }
        findings.push(finding);
    }
}

fn judge_program(program: &str, found: Option<&ProgramFound>, by: &str) -> Finding {
    let by = Some(by.to_owned());
    let Some(ProgramFound { path: Some(path), no_interpreter, no_script, .. }) = found else {
        let (what, mend) = if program.contains('/') {
            let mend = format!(
                "# build it; a path is taken from the working directory\nchmod +x {program}"
            );
            ("it is not there, or is no program", mend)
        } else {
            let mend =
                format!("# install it, or write its path: ./{program} in the working directory");
            ("it is not where PATH leads", mend)
        };
        return Finding::gap(program, what, mend, by);
    };
    if let Some(interpreter) = no_interpreter {
        let what = format!("its first line names {interpreter}, which is not here");
        let mend =
            format!("# install {interpreter}, or mend the line:\nhead -1 {}", path.display());
        return Finding::gap(program, what, mend, by);
    }
    if let Some(script) = no_script {
        let name = Path::new(script).file_name().unwrap_or_default().to_string_lossy();
        let mend = format!(
            "# a path is taken from the working directory: go where it is\nfind . -name {name}"
        );
        return Finding::gap(
            script,
            format!("{program} is to run it, and it is not there"),
            mend,
            by,
        );
    }
    Finding::good(program, path.display().to_string())
}

/// Searches for the programs as the shell would.
pub(super) fn gather(needs: &Needs) -> ProgramFacts {
    ProgramFacts {
        our_controller: find(&our_program()),
        under_test: needs.programs.iter().map(|need| look(&need.words)).collect(),
    }
}

pub(super) fn look(words: &[String]) -> ProgramFound {
    let program = Path::new(words.first().map_or("", |program| program));
    let path = find(program);
    let interpreter = path.as_deref().and_then(interpreter);
    ProgramFound {
        words: words.to_vec(),
        path,
        no_interpreter: interpreter.filter(|one| find(Path::new(one)).is_none()),
        no_script: missing_script(words).map(str::to_owned),
    }
}

/// Returns the interpreter in the first line of a script, named directly or as the argument of `env`.
fn interpreter(path: &Path) -> Option<String> {
    let mut first = Vec::new();
    File::open(path).ok()?.take(FIRST_LINE_MAX).read_to_end(&mut first).ok()?;
    let text = String::from_utf8_lossy(&first);
    let mut words = text.strip_prefix("#!")?.lines().next()?.split_whitespace();
    let named = words.next()?;
    let of_env = words.find(|word| !word.starts_with('-')).filter(|_| named.ends_with("/env"));
    Some(of_env.unwrap_or(named).to_owned())
}
