//! Pseudo-terminals, which connect emulated devices.

use super::Needs;
use super::finding::{Finding, joined};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde::Serialize;

/// Facts about pseudo-terminals.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PtyFacts {
    /// Why no pair can be opened; `None` if it can.
    pub no_pair: Option<String>,
    /// Number in use, and maximum (`kernel.pty`).
    pub used: Option<(u64, u64)>,
}

pub(super) fn judge(facts: &PtyFacts, needs: &Needs, findings: &mut Vec<Finding>) {
    let by = joined(needs.ptys.iter().map(String::as_str));
    let room = facts.used.map(|(used, max)| format!("{used} of {max} in use"));
    findings.push(match &facts.no_pair {
        None => Finding::good("ptys", room.unwrap_or_else(|| "can be had".to_owned())),
        Some(why) => {
            let (what, mend) = match facts.used {
                Some((used, max)) if used >= max => (
                    format!("all {max} are in use"),
                    format!("sudo sysctl -w kernel.pty.max={}", 2 * max.max(1)),
                ),
                _ => (
                    format!("none can be had: {why}"),
                    "sudo mkdir -p /dev/pts && sudo mount -t devpts -o ptmxmode=666 devpts /dev/pts"
                        .to_owned(),
                ),
            };
            Finding::gap("ptys", what, mend, by)
        }
    });
}

/// Opens a pair, both sides.
pub(super) fn gather() -> PtyFacts {
    let pair = || -> Result<(), Errno> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let path = ptsname(&master, Vec::new())?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        rustix::fs::open(path, flags, Mode::empty()).map(drop)
    };
    let number = |file: &str| -> Option<u64> {
        std::fs::read_to_string(format!("/proc/sys/kernel/pty/{file}")).ok()?.trim().parse().ok()
    };
    let no_pair = pair().err().map(|error| std::io::Error::from(error).to_string());
    PtyFacts { no_pair, used: number("nr").zip(number("max")) }
}
