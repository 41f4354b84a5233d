//! What a bench and plans need from a machine.

use super::finding::Finding;
use super::plans;
use harness::run::Prepared;
use live::lease::{self, Lease, Leased};
use live::unix_time::unix_s;
use plan::bench_file::{AttachPlace, BenchFile, ControllerSection, Medium, PortText, ROLES, Role};
use plan::rig::{RigLine, UnderTest};
use wire::can::BitRates;
use wire::time::Span;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortNeed {
    /// What needs it, such as `the gyro of bench usb`.
    pub by: String,
    pub port: PortText,
    /// Bit rates of its bus, if a rig file states them.
    pub rates: Option<BitRates>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramNeed {
    /// What needs it, such as `manager of plan charge`.
    pub by: String,
    pub words: Vec<String>,
    /// Its name in a bench file; `None` if it is known by its first word.
    pub name: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Needs {
    pub ports: Vec<PortNeed>,
    pub ptys: Vec<String>,
    /// The bench whose `setup` may create what is missing.
    pub set_up_by: Option<String>,
    pub our_controller: Option<String>,
    /// Plans are named, and none has a robot or a table for our controller.
    pub no_robot: bool,
    pub programs: Vec<ProgramNeed>,
    /// How late the harness may be, and which file states that.
    pub late_max: Option<(Span, String)>,
    pub findings: Vec<Finding>,
}

impl Needs {
    /// Returns the needs of the bench and the plans of these names or paths. Plans alone need only their files and the
    /// programs that they test.
    pub fn read(bench: Option<&str>, plans: &[String]) -> Self {
        let mut needs = Self::default();
        let bench = bench.map(|name| (name, BenchFile::load(name)));
        let real = match &bench {
            Some((_, Ok(file))) => file.real_nodes(),
            _ => Vec::new(),
        };
        let prepared = plans::prepare(plans, &real, &mut needs.findings);
        for Prepared { plan, rig, .. } in &prepared {
            for (node, how) in rig.under_test() {
                if let UnderTest::Command(words) = how {
                    needs.program(format!("{} of plan {}", node.name, plan.name), words);
                }
            }
        }
        let robots = prepared.iter().filter(|one| one.rig.robot.is_some()).count();
        needs.no_robot = !prepared.is_empty() && robots == 0;
        let Some((name, file)) = bench else { return needs };
        match file {
            Err(error) => needs.findings.push(plans::unusable(&format!("bench {name}"), &error)),
            Ok(file) => {
                let roles = plans::judge(name, &file, &prepared, &mut needs.findings);
                needs.add(name, &file, &roles);
                needs.add_lines(name, &file, &prepared);
                needs.findings.extend(in_use(name, &file));
                for (command, section) in &file.commands {
                    needs.programs.push(ProgramNeed {
                        by: format!("command {command} of bench {name}"),
                        words: section.run.clone(),
                        name: Some(command.to_string()),
                    });
                }
                needs.set_up_by = (!file.setup.is_empty()).then(|| name.to_owned());
            }
        }
        needs
    }

    /// Adds the needs of `roles` of a bench.
    pub fn add(&mut self, name: &str, bench: &BenchFile, roles: &[&str]) {
        for role in roles {
            let by = format!("the {role} of bench {name}");
            match bench.role(role) {
                Role::Emulated(None) => self.ptys.push(by),
                Role::Real(port) | Role::Emulated(Some(port)) => self.port(by, &port, None),
            }
        }
        let by = format!("the controller of bench {name}");
        match &bench.controller {
            // Without these roles the controller gets no missions.
            _ if !roles.iter().any(|role| ROLES.contains(role)) => {}
            None => self.our_controller = Some(by),
            Some(ControllerSection::Command(words)) => self.program(by, words),
            Some(ControllerSection::Attach(AttachPlace::Line(port))) => self.port(by, port, None),
            // The program that listens on a socket may start later.
            Some(ControllerSection::InProcess | ControllerSection::Attach(_)) => {}
        }
        self.late_max = bench.timing.late_max.map(|late| (late, format!("bench {name}")));
    }

    /// Adds what lines of the plans' rigs need from a bench; without plans, all lines that it names.
    fn add_lines(&mut self, name: &str, bench: &BenchFile, prepared: &[Prepared]) {
        for (line, section) in &bench.lines {
            let of_rigs = prepared.iter().flat_map(|one| &one.rig.lines);
            let known = of_rigs.into_iter().find(|known| known.name == *line);
            if known.is_some() || prepared.is_empty() {
                let by = format!("the line {line} of bench {name}");
                let says = |line: &&RigLine| line.bit_rate.or(line.data_bit_rate).is_some();
                let rates = known.filter(says).map(RigLine::rates);
                self.port(by, &section.port, rates);
            }
        }
        for one in prepared {
            let lines = plans::lines(one).map(|(line, _)| line);
            let unnamed = lines.filter(|line| !bench.lines.contains_key(*line));
            self.ptys
                .extend(unnamed.map(|line| format!("the line {line} of plan {}", one.plan.name)));
        }
    }

    /// Adds a port that must exist, or a pty to be created.
    fn port(&mut self, by: String, port: &PortText, rates: Option<BitRates>) {
        if port.medium().is_made_here() {
            self.ptys.push(by);
        } else {
            self.ports.push(PortNeed { by, port: port.clone(), rates });
        }
    }

    fn program(&mut self, by: String, words: &[String]) {
        let is_it = |known: &&mut ProgramNeed| known.name.is_none() && known.words == words;
        match self.programs.iter_mut().find(is_it) {
            Some(known) => known.by += &format!(", {by}"),
            None => self.programs.push(ProgramNeed { by, words: words.to_vec(), name: None }),
        }
    }

    pub(super) fn ports_on(&self, media: &[Medium]) -> impl Iterator<Item = &PortNeed> {
        self.ports.iter().filter(|need| media.contains(&need.port.medium()))
    }

    pub(super) fn can(&self) -> Option<String> {
        super::finding::joined(self.ports_on(&[Medium::Can]).map(|need| need.by.as_str()))
    }
}

/// Reports a bench that another user holds.
fn in_use(name: &str, bench: &BenchFile) -> Option<Finding> {
    let taken = Lease::look(&lease::folder(), &Leased::of(name, bench))?;
    let mend = format!("# wait for it:\nhil run PLAN --clock real --bench {name} --wait 600");
    let by = format!("bench {name}");
    Some(Finding::gap(&by, taken.told(unix_s().unwrap_or_default()), mend, Some(by.clone())))
}

#[cfg(test)]
mod tests {
    use super::Needs;
    use crate::doctor::tests::laptop;
    use crate::doctor::{Status, examine, programs};

    #[test]
    fn what_a_bench_sets_up_need_not_be_there_yet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        let bench = "setup = [\"on\"]\n[device]\nport = \"/dev/none\"\n[command.on]\nrun = [\"sh\", \"-c\", \"true\"]\n\
                     [command.off]\nrun = [\"sh\", \"-c\", \"false\"]\n";
        std::fs::write(&path, bench).unwrap();
        let needs = Needs::read(path.to_str(), &[]);
        let mut facts = laptop();
        facts.programs = programs::gather(&needs);
        let findings = examine(&facts, &needs);
        let found = |subject: &str| findings.iter().find(|one| one.subject == subject).unwrap();
        assert_eq!(found("/dev/none").status, Status::Optional);
        assert!(found("/dev/none").what.contains("may create it"), "{findings:?}");
        assert_eq!((found("on").status, found("off").status), (Status::Good, Status::Good));
        for (port, subject, what) in [
            ("can:can1", "can1", "may create it"),
            ("can:vcan0", "interface vcan0", "the `setup` of"),
        ] {
            std::fs::write(&path, bench.replace("/dev/none", port)).unwrap();
            let needs = Needs::read(path.to_str(), &[]);
            facts.can.interfaces[0].up = false;
            let findings = examine(&facts, &needs);
            let found = findings.iter().find(|one| one.subject == subject).unwrap();
            assert_eq!(found.status, Status::Optional, "{found:?}");
            assert!(found.what.contains(what), "{found:?}");
        }
        std::fs::write(&path, bench.replace("setup = [\"on\"]\n", "")).unwrap();
        let needs = Needs::read(path.to_str(), &[]);
        let missing = examine(&facts, &needs);
        assert!(
            missing.iter().any(|one| one.subject == "/dev/none" && one.status == Status::Missing)
        );
    }
}
