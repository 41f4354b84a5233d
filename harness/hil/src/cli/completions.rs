//! `hil completions`: completion scripts for shells.

use super::failure::Failure;
use super::{Cli, say};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use record::outcome::Outcome;

const EXAMPLES: &str = "\
Examples:
  hil completions bash > ~/.local/share/bash-completion/completions/hil
  hil completions zsh > ~/.zfunc/_hil
  hil completions fish > ~/.config/fish/completions/hil.fish";

/// Prints completions for a shell.
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
    generate(shell, &mut Cli::command(), "hil", &mut text);
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::script;
    use crate::cli::Cli;
    use clap::{CommandFactory, ValueEnum};
    use clap_complete::Shell;

    #[test]
    fn every_shell_knows_every_command() {
        for shell in Shell::value_variants() {
            let script = script(*shell);
            for command in Cli::command().get_subcommands() {
                assert!(script.contains(command.get_name()), "{shell}: {}", command.get_name());
            }
            assert!(script.contains("seeds"), "{shell}: no options");
        }
    }
}
