//! What a bench does by commands of its own: at the plan's word, before each run and after it.

use crate::command::find;
use plan::bench_file::{BenchFile, CommandSection};
use plan::{Action, Name, Plan, Step};
use std::collections::BTreeMap;
use std::path::Path;

/// The commands of a bench, and those that are run around each run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BenchWork {
    /// All of them, by name.
    pub(super) commands: BTreeMap<Name, CommandSection>,
    /// Before a port is opened.
    pub(super) setup: Vec<Name>,
    /// After the run, however it ended.
    pub(super) teardown: Vec<Name>,
}

/// A command that the bench cannot carry out: bad input, as it is known before the run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("failed to find the command `{name}`, which {by}: {why}")]
#[diagnostic(help("{help}"))]
pub struct NoCommand {
    pub name: String,
    pub by: String,
    pub why: String,
    pub help: String,
}

impl BenchWork {
    /// That of a bench file.
    pub fn of(bench: &BenchFile) -> Self {
        let BenchFile { commands, setup, teardown, .. } = bench.clone();
        Self { commands, setup, teardown }
    }

    /// The commands that the bench lacks, for itself and for `plans`.
    pub fn lacks<'a>(&'a self, plans: impl IntoIterator<Item = &'a Plan>) -> Vec<NoCommand> {
        let asked = self.asked(plans).into_iter();
        asked.filter_map(|(name, by)| self.lacking(name, &by)).collect()
    }

    /// Can everything be done that the bench itself and `plan` ask for, by programs that are here?
    pub(super) fn check(&self, plan: &Plan) -> Result<(), NoCommand> {
        for (name, by) in self.asked([plan]) {
            if let Some(lacking) = self.lacking(name, &by).or_else(|| self.no_program(name, &by)) {
                return Err(lacking);
            }
        }
        Ok(())
    }

    /// Every command that is asked for, and by whom first.
    fn asked<'a>(&'a self, plans: impl IntoIterator<Item = &'a Plan>) -> Vec<(&'a Name, String)> {
        let mut asked: Vec<(&Name, String)> = Vec::new();
        let mut ask = |name: &'a Name, by: String| {
            if !asked.iter().any(|(known, _)| *known == name) {
                asked.push((name, by));
            }
        };
        for (key, names) in [("setup", &self.setup), ("teardown", &self.teardown)] {
            names.iter().for_each(|name| ask(name, format!("`{key}` of the bench names")));
        }
        for plan in plans {
            for step in Step::walk(&plan.steps) {
                if let Action::BenchCommand(command) = &step.action {
                    ask(&command.name, format!("plan {} does", plan.name));
                }
            }
        }
        asked
    }

    fn lacking(&self, name: &Name, by: &str) -> Option<NoCommand> {
        if self.commands.contains_key(name) {
            return None;
        }
        let names: Vec<&str> = self.commands.keys().map(Name::as_str).collect();
        let (why, has) = match &names[..] {
            [] => ("the bench has no commands", String::new()),
            names => ("the bench has no such command", format!("it has {}; ", names.join(", "))),
        };
        Some(NoCommand {
            name: name.to_string(),
            by: by.to_owned(),
            why: why.to_owned(),
            help: format!(
                "{has}add to the bench file, which --bench names: [command.{name}] run = [\"program\", \"argument\"]"
            ),
        })
    }

    /// Where its program is not here.
    fn no_program(&self, name: &Name, by: &str) -> Option<NoCommand> {
        let program = self.commands.get(name)?.run.first()?;
        if find(Path::new(program)).is_some() {
            return None;
        }
        let (why, help) = if program.contains('/') {
            let help =
                "a path is taken from the working directory; is it executable by you (`ls -l`)?";
            (format!("{program} is not there, or is no program"), help)
        } else {
            (format!("{program} is not where PATH leads"), "install it, or write its path")
        };
        Some(NoCommand { name: name.to_string(), by: by.to_owned(), why, help: help.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::{BenchFile, BenchWork, Plan};

    fn work(bench: &str) -> BenchWork {
        BenchWork::of(&toml::from_str::<BenchFile>(bench).unwrap())
    }

    fn plan(steps: &str) -> Plan {
        let text = format!(
            "name = \"flashed\"\ntitle = \"Flashed\"\ndevices = \"paper\"\nsteps = [{steps}]\n\
             [[measurement]]\nname = \"took\"\ndoc = \"It\"\nquantity = \"step.duration\"\nunit = \"s\"\n\
             check = {{ all_within = [0, 60] }}\n"
        );
        Plan::parse("flashed.toml", &text).unwrap()
    }

    #[test]
    fn what_is_missing_is_named_with_who_wants_it() {
        let flash = "{ repeat = { times = 2, steps = [{ do = \"flash\" }] } }";
        let good = "[command.flash]\nrun = [\"sh\", \"-c\", \"true\"]\n";
        assert_eq!(work(good).check(&plan(flash)), Ok(()));
        assert_eq!(work("").check(&plan("{ wait = { duration_s = 1 } }")), Ok(()));
        let cases = [
            ("", flash),
            ("[command.power-on]\nrun = [\"sh\"]", flash),
            ("[command.flash]\nrun = [\"no-such-program\"]", flash),
            ("[command.flash]\nrun = [\"./no/such/program\"]", flash),
            ("[command.flash]\nrun = [\"/etc/passwd\"]", flash),
            ("setup = [\"power-on\"]", "{ wait = { duration_s = 1 } }"),
            (
                "teardown = [\"off\"]\n[command.off]\nrun = [\"gone\"]",
                "{ wait = { duration_s = 1 } }",
            ),
        ];
        let refused = cases.map(|(bench, steps)| {
            let refused = work(bench).check(&plan(steps)).unwrap_err();
            format!("{refused}\n  help: {}", refused.help)
        });
        insta::assert_snapshot!(refused.join("\n"));
    }
}
