//! What a machine and a bench have, what they lack, and the command that mends it.
//!
//! Facts are gathered ([`Facts::gather`]), needs are read from benches and plans ([`Needs`]), and
//! [`examine`] puts the two together. Each subject has a file with its facts, its judgement, which is
//! free of IO and sees nothing but facts and needs, and a thin gatherer. [`show`] puts it on a terminal.
//!
//! Nothing is mended here: what a command would do is for a person to decide.

pub mod can;
pub mod clock;
mod finding;
mod interface;
pub mod limits;
pub mod needs;
mod plans;
pub mod programs;
pub mod pty;
pub mod serial;
pub mod show;
mod table;
#[cfg(test)]
mod tests;

pub use finding::{Finding, Status};
pub use interface::{CanInterface, CanState};
pub use needs::{Needs, PortNeed, ProgramNeed};

use record::outcome::Outcome;
use serde::Serialize;

/// What is so on this machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Release of the kernel.
    pub kernel: String,
    /// Are we in a container? Kernel modules are then the host's affair.
    pub container: bool,
    /// CAN in the kernel, and its interfaces.
    pub can: can::CanFacts,
    /// Serial ports, and what this user may do with them.
    pub serial: serial::SerialFacts,
    /// Pseudo-terminals.
    pub pty: pty::PtyFacts,
    /// The clock, and how late this machine wakes a process.
    pub clock: clock::ClockFacts,
    /// What this user may have of real time.
    pub limits: limits::LimitFacts,
    /// Programs that are started.
    pub programs: programs::ProgramFacts,
}

impl Facts {
    /// Looks at this machine; takes a second, most of it measuring the clock. What cannot be found out
    /// is taken for absent.
    pub fn gather(needs: &Needs) -> Self {
        Self {
            kernel: rustix::system::uname().release().to_string_lossy().into_owned(),
            container: ["/.dockerenv", "/run/.containerenv"]
                .iter()
                .any(|mark| std::path::Path::new(mark).exists()),
            can: can::gather(),
            serial: serial::gather(needs),
            pty: pty::gather(),
            clock: clock::gather(),
            limits: limits::gather(),
            programs: programs::gather(needs),
        }
    }
}

/// What there is to be said about the facts in view of the needs, in a fixed order.
pub fn examine(facts: &Facts, needs: &Needs) -> Vec<Finding> {
    let mut findings = Vec::new();
    can::judge(facts, needs, &mut findings);
    serial::judge(facts, needs, &mut findings);
    pty::judge(&facts.pty, needs, &mut findings);
    clock::judge(&facts.clock, needs, &mut findings);
    limits::judge(&facts.limits, &mut findings);
    programs::judge(&facts.programs, needs, &mut findings);
    findings.extend(needs.findings.iter().cloned());
    findings
}

/// [`Outcome::Error`] where something lacks that is needed.
pub fn outcome(findings: &[Finding]) -> Outcome {
    let lacks = findings.iter().any(|finding| finding.status == Status::Lacking);
    if lacks { Outcome::Error } else { Outcome::Passed }
}
