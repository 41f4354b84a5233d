//! Real-time limits of this user: priority and locked memory.

use super::finding::Finding;
use rustix::process::{Resource, getrlimit};
use serde::Serialize;

/// Locked memory that a process of the harness needs, in bytes. Assumption: `hil` takes some 50 MB.
const MEMLOCK_BYTES_MIN: u64 = 64 * 1024 * 1024;

/// Limits of this process; `None` for unlimited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct LimitFacts {
    /// Highest real-time priority (`RLIMIT_RTPRIO`).
    pub real_time_priority: Option<u64>,
    /// Maximum bytes of memory locked against swapping (`RLIMIT_MEMLOCK`).
    pub locked_bytes: Option<u64>,
}

/// Returns the command that raises a limit (pam_limits(8)).
fn raise(item: &str, value: &str) -> String {
    format!(
        "echo '@dialout - {item} {value}' | sudo tee /etc/security/limits.d/hil-{item}.conf\n\
         # then log in again, as a member of dialout"
    )
}

pub(super) fn judge(facts: &LimitFacts, findings: &mut Vec<Finding>) {
    findings.push(match facts.real_time_priority {
        Some(0) => {
            let what =
                "none allowed; the device under test shares the processor with other programs";
            Finding::gap("real-time priority", what, raise("rtprio", "80"), None)
        }
        Some(highest) => Finding::good("real-time priority", format!("up to {highest}")),
        None => Finding::good("real-time priority", "without limit"),
    });
    findings.push(match facts.locked_bytes {
        Some(bytes) => {
            let what = format!("up to {} KiB", bytes / 1_024);
            if bytes >= MEMLOCK_BYTES_MIN {
                Finding::good("locked memory", what)
            } else {
                Finding::gap("locked memory", what, raise("memlock", "unlimited"), None)
            }
        }
        None => Finding::good("locked memory", "without limit"),
    });
}

pub(super) fn gather() -> LimitFacts {
    LimitFacts {
        real_time_priority: getrlimit(Resource::Rtprio).current,
        locked_bytes: getrlimit(Resource::Memlock).current,
    }
}
