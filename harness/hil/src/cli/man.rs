//! `hil man`: manual pages, one per command.

use super::failure::Failure;
use super::{Cli, EXIT_STATUSES, say};
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use record::outcome::Outcome;
use std::fs;
use std::io;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  hil man | man -l -                      the page of hil
  hil man --out ~/.local/share/man/man1   all pages: hil.1, hil-run.1 and so on";

/// Prints the manual page, or writes those of all commands.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ManArguments {
    /// Write the pages of all commands to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

struct Page {
    file: String,
    text: Vec<u8>,
}

impl ManArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let pages = pages().map_err(Failure::output)?;
        let Some(folder) = &self.out else {
            if let Some(first) = pages.first() {
                say(&String::from_utf8_lossy(&first.text))?;
            }
            return Ok(Outcome::Passed);
        };
        fs::create_dir_all(folder).map_err(|source| Failure::file(folder, source))?;
        for page in pages {
            let path = folder.join(page.file);
            fs::write(&path, page.text).map_err(|source| Failure::file(&path, source))?;
        }
        Ok(Outcome::Passed)
    }
}

/// Returns every page, that of `hil` first.
fn pages() -> io::Result<Vec<Page>> {
    let mut hil = Cli::command().disable_help_subcommand(true);
    hil.build();
    let mut pages = Vec::new();
    add(&hil, "hil", &mut pages)?;
    Ok(pages)
}

fn add(command: &Command, name: &str, pages: &mut Vec<Page>) -> io::Result<()> {
    let file = format!("{name}.1");
    pages.push(Page { file, text: page(command.clone())? });
    for within in command.get_subcommands().filter(|it| !it.is_hide_set()) {
        add(within, &format!("{name}-{}", within.get_name()), pages)?;
    }
    Ok(())
}

fn page(command: Command) -> io::Result<Vec<u8>> {
    let extra = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let extra = extra.replace(EXIT_STATUSES, "");
    let (has_commands, has_extra) = (command.has_subcommands(), !extra.trim().is_empty());
    let man = Man::new(command.version(env!("CARGO_PKG_VERSION")).after_help(extra));
    let mut text = Vec::new();
    man.render_title(&mut text)?;
    man.render_name_section(&mut text)?;
    man.render_synopsis_section(&mut text)?;
    man.render_description_section(&mut text)?;
    man.render_options_section(&mut text)?;
    if has_commands {
        man.render_subcommands_section(&mut text)?;
    }
    if has_extra {
        man.render_extra_section(&mut text)?;
    }
    exit_statuses().to_writer(&mut text)?;
    Ok(text)
}

/// The section on exit statuses, in every manual page of a command.
fn exit_statuses() -> Roff {
    let mut roff = Roff::default();
    roff.control("SH", ["EXIT STATUS"]);
    for line in EXIT_STATUSES.lines().skip(1) {
        match line.trim_start().split_once("  ") {
            Some((status, meaning)) => {
                roff.control("TP", []);
                roff.text([roman(status)]);
                roff.text([roman(meaning.trim())]);
            }
            None => {
                roff.control("PP", []);
                roff.text([roman(line.trim())]);
            }
        }
    }
    roff
}

#[cfg(test)]
mod tests {
    use super::pages;
    use crate::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn every_command_has_a_page_with_the_exit_statuses() {
        let pages = pages().unwrap();
        let named = |file: &str| pages.iter().find(|page| page.file == file);
        assert!(named("hil.1").is_some() && named("hil-emulate-gyro.1").is_some());
        for command in Cli::command().get_subcommands() {
            let file = format!("hil-{}.1", command.get_name());
            let page = named(&file).unwrap_or_else(|| panic!("no {file}"));
            let text = String::from_utf8_lossy(&page.text);
            assert!(text.contains("EXIT STATUS") && text.contains("bad input"), "{text}");
            assert!(text.contains("Of several runs the worst counts"), "{text}");
        }
    }
}
