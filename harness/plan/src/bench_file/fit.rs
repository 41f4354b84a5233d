//! Whether a bench file names the rig that it is used with.

use super::{BenchFile, ROLES};
use crate::rig::{NodePart, Rig, RigNode, UnderTest};
use crate::speakers::DEVICE;
use described::hint;

/// Names a table of a bench file that the rig lacks, so that a device at its port would be emulated without a word.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("the bench file has [{table}], and the rig has no such {what}")]
#[diagnostic(help("{help}"))]
pub struct Foreign {
    table: String,
    what: &'static str,
    help: String,
}

impl BenchFile {
    /// Refuses the bench if nothing that it names is in the rig, or if it names a line that the rig lacks while a line
    /// of the rig has no port. A bench may name more, for other plans.
    ///
    /// # Errors
    ///
    /// The first table that the rig lacks.
    pub fn expect_of(&self, rig: &Rig) -> Result<(), Foreign> {
        let roles: Vec<&str> = match (&rig.robot, rig.device()) {
            (Some(_), _) => ROLES.to_vec(),
            (None, Some(_)) => vec![DEVICE],
            (None, None) => Vec::new(),
        };
        let named = ROLES.into_iter().chain([DEVICE]).filter(|name| self.section(name).is_some());
        let (known, foreign): (Vec<_>, Vec<_>) = named.partition(|name| roles.contains(name));
        // The line of a plan's only device is the role `device`.
        let lines = rig.lines.iter().filter(|_| !rig.is_short);
        let lines: Vec<&str> = lines.map(|line| &*line.name).collect();
        let has_port = |line: &str| self.lines.contains_key(line);
        let other = self.lines.keys().find(|name| !lines.contains(&name.as_str()));
        let fits = !known.is_empty() || lines.iter().any(|line| has_port(line));
        let free: Vec<&str> = lines.iter().copied().filter(|line| !has_port(line)).collect();
        if let Some(name) = other.filter(|_| !fits || !free.is_empty()) {
            return Err(Foreign {
                table: format!("line.{name}"),
                what: "line",
                help: hint::proposal(name, &free),
            });
        }
        match foreign.first() {
            Some(name) if !fits => {
                let known: Vec<String> = free
                    .iter()
                    .map(|line| format!("line.{line}"))
                    .chain(roles.iter().map(|role| (*role).to_owned()))
                    .collect();
                Err(Foreign {
                    table: (*name).to_owned(),
                    what: "role",
                    help: hint::proposal(name, &known),
                })
            }
            _ => Ok(()),
        }
    }
}

impl Rig {
    /// Makes these nodes real: each is at the port of its line, whatever the rig file has in its place.
    ///
    /// # Errors
    /// The first that is not in the rig, or that the plan itself or a log plays.
    pub fn with_real(mut self, nodes: &[String]) -> Result<Self, Foreign> {
        for name in nodes {
            let is_it = |node: &RigNode| node.name == *name && self.can_have_real(node);
            match self.nodes.iter().position(is_it) {
                Some(place) => {
                    self.nodes[place].part = NodePart::UnderTest(UnderTest::Attached(true));
                }
                None => return Err(self.has_no_node(name)),
            }
        }
        Ok(self)
    }

    /// Whether a bench may have this node: it is emulated or under test. A plan's only device has a role of its own.
    const fn can_have_real(&self, node: &RigNode) -> bool {
        !self.is_short && matches!(node.part, NodePart::Described(_) | NodePart::UnderTest(_))
    }

    /// Why a bench cannot have a real node of this name.
    fn has_no_node(&self, name: &str) -> Foreign {
        let able = self.nodes.iter().filter(|node| self.can_have_real(node));
        let known: Vec<&str> = able.map(|node| &*node.name).collect();
        Foreign {
            table: format!("node.{name}"),
            what: "node that can be real",
            help: hint::proposal(name, &known),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BenchFile;
    use crate::rig::{Rig, RigLine};
    use described::Medium;

    fn rig(lines: &[&str]) -> Rig {
        let line = |name: &&str| RigLine {
            name: (*name).to_owned(),
            medium: Medium::Can,
            bit_rate: None,
            data_bit_rate: None,
        };
        Rig { lines: lines.iter().map(line).collect(), ..Rig::default() }
    }

    fn refused(bench: &str, lines: &[&str]) -> Option<String> {
        let bench: BenchFile = toml::from_str(bench).unwrap();
        let foreign = bench.expect_of(&rig(lines)).err()?;
        Some(format!("{foreign}: {}", foreign.help))
    }

    #[test]
    fn a_bench_of_another_rig_is_refused_by_name() {
        let port = "port = \"can:can0\"\n";
        let line = |name: &str| format!("[line.{name}]\n{port}");
        let misspelt = refused(&line("cna0"), &["can0"]).unwrap();
        assert_eq!(
            misspelt,
            "the bench file has [line.cna0], and the rig has no such line: did you mean `can0`?"
        );
        let role = refused(&format!("[base]\n{port}"), &["can0"]).unwrap();
        assert!(
            role.starts_with("the bench file has [base], and the rig has no such role"),
            "{role}"
        );
        let half = line("body") + &line("vehicle");
        assert!(refused(&half, &["body", "chassis"]).unwrap().contains("[line.vehicle]"));
        assert_eq!(refused(&half, &["body"]), None, "the other line is of another plan");
        assert_eq!(refused(&line("body"), &["body", "chassis"]), None, "the chassis is emulated");
        assert_eq!(refused(&format!("{}[base]\n{port}", line("body")), &["body"]), None);
        assert_eq!(refused("title = \"no ports\"", &["body"]), None);
    }
}
