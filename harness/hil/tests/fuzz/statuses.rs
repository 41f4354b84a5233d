//! The exit statuses that the help of a command names.

use std::collections::BTreeMap;
use std::process::Command;

/// Exit statuses by command.
#[derive(Debug, Default)]
pub struct Statuses(BTreeMap<String, Vec<i32>>);

impl Statuses {
    /// Returns the statuses of these commands; a command that names none has those of `hil`.
    pub fn of<'a>(commands: impl Iterator<Item = &'a str>) -> Self {
        let general = named(&help(&[]));
        assert!(general.contains(&0) && general.contains(&5), "{general:?}");
        let of = |command: &str| Some(named(&help(&[command]))).filter(|named| !named.is_empty());
        let all = commands
            .map(|command| (command.to_owned(), of(command).unwrap_or_else(|| general.clone())));
        Self(all.collect())
    }

    pub fn of_command(&self, command: &str) -> &[i32] {
        &self.0[command]
    }
}

fn help(command: &[&str]) -> String {
    let mut hil = Command::new(crate::program());
    let output = hil.args(command).arg("--help").output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// Returns the numbers that begin lines after the heading.
fn named(help: &str) -> Vec<i32> {
    let lines = help.lines().skip_while(|line| *line != "Exit status:").skip(1);
    lines.filter_map(|line| line.trim().split("  ").next()?.parse().ok()).collect()
}
