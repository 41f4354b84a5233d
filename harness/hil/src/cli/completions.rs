//! `hil completions`: completion scripts for shells, and what they ask `hil` for while somebody types.

use super::failure::Failure;
use super::listed::listed;
use super::{Cli, say};
use crate::choices::word;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};
use clap_complete::env::{CompleteEnv, Shells};
use plan::library::Kind;
use record::outcome::Outcome;
use std::ffi::OsStr;
use std::path::Path;

/// The scripts set it when they ask.
const ASKED: &str = "HIL_COMPLETE";

const EXAMPLES: &str = "\
Examples:
  hil completions bash > ~/.local/share/bash-completion/completions/hil
  hil completions zsh > ~/.zfunc/_hil
  hil completions fish > ~/.config/fish/completions/hil.fish";

/// Prints completions for a shell: commands, options, and the names of plans.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompletionsArguments {
    /// Which shell.
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

impl CompletionsArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        say(&script(self.shell))?;
        Ok(Outcome::Passed)
    }
}

fn script(shell: Shell) -> String {
    let mut text = Vec::new();
    if let Some(shell) = Shells::builtins().completer(&word(&shell)) {
        // A vector takes all that is written.
        let _ = shell.write_registration(ASKED, "hil", "hil", "hil", &mut text);
    }
    String::from_utf8_lossy(&text).into_owned()
}

/// Answers a script that asks, and ends the process then.
pub(super) fn answer() {
    CompleteEnv::with_factory(Cli::command).var(ASKED).complete();
}

pub(super) fn plan() -> ArgValueCompleter {
    ArgValueCompleter::new(plans)
}

fn plans(begun: &OsStr) -> Vec<CompletionCandidate> {
    let shipped = listed(Path::new(""), Kind::Plan).filter(|plan| plan.from == "shipped");
    let meant = shipped.filter(|plan| plan.name.starts_with(&*begun.to_string_lossy()));
    let mut found: Vec<_> = meant
        .map(|plan| CompletionCandidate::new(&plan.name).help(Some(plan.text("title").into())))
        .collect();
    let is_toml = |path: &Path| path.is_file() && path.extension().is_some_and(|end| end == "toml");
    found.extend(PathCompleter::any().filter(is_toml).complete(begun));
    found
}

#[cfg(test)]
mod tests {
    use super::{ASKED, plans, script};
    use clap::ValueEnum;
    use clap_complete::Shell;
    use std::ffi::OsStr;

    #[test]
    fn every_shell_asks_hil() {
        for shell in Shell::value_variants() {
            let script = script(*shell);
            assert!(script.contains(ASKED) && script.contains("hil"), "{shell}: {script}");
        }
    }

    #[test]
    fn plans_that_ship_and_paths_are_known() {
        let names = |begun: &str| -> Vec<String> {
            let found = plans(OsStr::new(begun));
            found.iter().map(|one| one.get_value().to_string_lossy().into_owned()).collect()
        };
        assert_eq!(names("static-b"), ["static-bias"]);
        assert!(
            names("../../examples/battery-pack/ch")
                .contains(&"../../examples/battery-pack/charge.toml".to_owned())
        );
    }
}
