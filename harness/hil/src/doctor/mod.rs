//! What a machine and a bench have, what they lack, and the command that fixes it.
//!
//! [`Facts::gather`] gathers facts, [`Needs`] reads needs from benches and plans, and [`examine`] compares the two.
//! Each subject has a file with its facts, its judgement, which is free of IO and sees only facts and needs, and a thin
//! gatherer. [`show`] formats the result for a terminal.
//!
//! The doctor repairs nothing: a person decides whether to run a command.

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
#[cfg(test)]
mod tests;

pub use finding::{Finding, Status};
pub use interface::{CanInterface, CanState};
pub use needs::{Needs, PortNeed, ProgramNeed};

use record::outcome::Outcome;
use serde::Serialize;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    pub kernel: String,
    /// Whether this is a container. Kernel modules are then up to the host.
    pub container: bool,
    /// CAN support of the kernel, and the interfaces.
    pub can: can::CanFacts,
    /// Serial ports, and this user's access to them.
    pub serial: serial::SerialFacts,
    pub pty: pty::PtyFacts,
    /// The clock, and how late this machine wakes a process.
    pub clock: clock::ClockFacts,
    /// Real-time limits of this user.
    pub limits: limits::LimitFacts,
    pub programs: programs::ProgramFacts,
}

impl Facts {
    /// Examines this machine; takes a second, mostly to measure the clock. Facts that cannot be determined count as
    /// absent.
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

/// Returns findings about the facts in view of the needs, in a fixed order.
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

/// Returns [`Outcome::Error`] if something needed is lacking.
pub fn outcome(findings: &[Finding]) -> Outcome {
    let lacks = findings.iter().any(|finding| finding.status == Status::Missing);
    if lacks { Outcome::Error } else { Outcome::Passed }
}
