//! What a bench and plans need of a machine.

use super::finding::Finding;
use super::plans;
use plan::bench_file::{AttachPlace, BenchFile, ControllerSection, Medium, PortText, Role};
use wire::time::Span;

/// A port that must be there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortNeed {
    /// Who needs it, such as `the gyro of bench usb`.
    pub by: String,
    /// The port.
    pub port: PortText,
}

/// What must be there, and for whom.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Needs {
    /// Ports.
    pub ports: Vec<PortNeed>,
    /// Who needs a pty pair.
    pub ptys: Vec<String>,
    /// Who needs our own controller as a program.
    pub our_controller: Option<String>,
    /// A program that is the device under test, and who needs it.
    pub program: Option<(String, String)>,
    /// How late the harness may be, and who says so.
    pub late_max: Option<(Span, String)>,
    /// What is already known of benches and plans themselves.
    pub findings: Vec<Finding>,
}

impl Needs {
    /// What the bench and the plans of these names or paths need. Plans alone run in virtual time, which
    /// needs nothing but their files.
    pub fn read(bench: Option<&str>, plans: &[String]) -> Self {
        let mut needs = Self::default();
        let prepared = plans::prepare(plans, &mut needs.findings);
        let Some(name) = bench else { return needs };
        match BenchFile::load(name) {
            Err(error) => needs.findings.push(plans::unusable(&format!("bench {name}"), &error)),
            Ok(file) => {
                let roles = plans::judge(name, &file, &prepared, &mut needs.findings);
                needs.add(name, &file, &roles);
            }
        }
        needs
    }

    /// Adds what `roles` of a bench need.
    pub fn add(&mut self, name: &str, bench: &BenchFile, roles: &[&str]) {
        for role in roles {
            let by = format!("the {role} of bench {name}");
            match bench.role(role) {
                Role::Emulated(None) => self.ptys.push(by),
                Role::Real(port) | Role::Emulated(Some(port)) => {
                    if port.medium().is_made_here() {
                        self.ptys.push(by);
                    } else {
                        self.ports.push(PortNeed { by, port });
                    }
                }
            }
        }
        let by = format!("the controller of bench {name}");
        match &bench.controller {
            None => self.our_controller = Some(by),
            Some(ControllerSection::Command(words)) => {
                self.program = words.first().map(|program| (program.clone(), by));
            }
            Some(ControllerSection::Attach(AttachPlace::Line(port))) => {
                if port.medium().is_made_here() {
                    self.ptys.push(by);
                } else {
                    self.ports.push(PortNeed { by, port: port.clone() });
                }
            }
            // Who listens on a socket may come later.
            Some(ControllerSection::InProcess | ControllerSection::Attach(_)) => {}
        }
        self.late_max = bench.timing.late_max.map(|late| (late, format!("bench {name}")));
    }

    /// Ports of these media.
    pub(super) fn ports_on(&self, media: &[Medium]) -> impl Iterator<Item = &PortNeed> {
        self.ports.iter().filter(|need| media.contains(&need.port.medium()))
    }

    /// Who needs CAN in the kernel.
    pub(super) fn can(&self) -> Option<String> {
        super::finding::joined(self.ports_on(&[Medium::Can]).map(|need| need.by.as_str()))
    }
}
