//! Checks that the commands of the README and of the reference exist. Those of the guides are run elsewhere.

use super::Cli;
use clap::Parser as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Lower bound: fewer commands mean that the search no longer finds them.
const COMMANDS_MIN: usize = 60;

/// Words of a shell line, without a trailing comment, pipe or redirection.
fn words(line: &str) -> Vec<String> {
    let line = [" #", "   ", " | ", " <", " \\"]
        .iter()
        .fold(line, |line, end| line.split_once(end).map_or(line, |(before, _)| before));
    // Text between quotes is one word.
    let parts = line.split('"').enumerate();
    let parts = parts.flat_map(|(index, part)| match index % 2 {
        0 => part.split_whitespace().map(str::to_owned).collect(),
        _ => vec![part.to_owned()],
    });
    // Placeholders for the reader.
    parts.map(|word| if word == "N" { "7".to_owned() } else { word }).collect()
}

/// Lines in code blocks that begin with `hil`, or have it after a `cd`.
fn commands(text: &str) -> impl Iterator<Item = (usize, Vec<String>)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        if line.starts_with("```") {
            fenced = !fenced;
        }
        let line = line.split_once("&& ").map_or(line, |(_, line)| line);
        (fenced && line.starts_with("hil ")).then(|| (index + 1, words(line)))
    })
}

#[test]
fn the_commands_of_the_manual_are_understood() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages: Vec<PathBuf> = vec![root.join("README.md")];
    let docs = fs::read_dir(root.join("docs")).unwrap();
    pages.extend(docs.map(|entry| entry.unwrap().path()));
    let mut understood = 0;
    for page in pages.iter().filter(|page| page.extension().is_some_and(|kind| kind == "md")) {
        for (line, words) in commands(&fs::read_to_string(page).unwrap()) {
            let parsed = Cli::try_parse_from(&words);
            assert!(
                parsed.is_ok(),
                "{}:{line}: {words:?}: {}",
                page.display(),
                parsed.unwrap_err()
            );
            understood += 1;
        }
    }
    assert!(understood >= COMMANDS_MIN, "{understood} commands");
}

#[test]
fn a_command_that_is_none_is_not_understood() {
    let (_, words) = commands("```\ncd oven && hil run --sed 3   # no\n```\n").next().unwrap();
    assert_eq!(words, ["hil", "run", "--sed", "3"]);
    assert!(Cli::try_parse_from(words).is_err());
}
