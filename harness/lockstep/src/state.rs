//! What may become of a program.

use std::fmt;
use std::process::ExitStatus;
use std::time::Duration;

/// How a program stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State<'a> {
    /// It waits for the next moment, or has not begun yet.
    Running,
    /// It waits for something to be sent, and for no moment: [`next_wakeup`](wire::device::Device::next_wakeup) is
    /// [`Timestamp::MAX`](wire::time::Timestamp::MAX).
    WaitsForEver,
    /// It runs no longer.
    Ended(&'a Ended),
}

/// Why a program runs no longer. Whatever the reason, none of its processes is left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// By itself, or by a signal of somebody else; the status of the process that was started.
    Exited(ExitStatus),
    /// It was [stopped](crate::Lockstep::stop): it ended after SIGTERM with this status, or was killed, which is a status
    /// too.
    Stopped(ExitStatus),
    /// It did not wait for anything in so much real time: it computes without end, or waits in a way that the shim
    /// does not see.
    NeverWaited {
        /// How long was waited for it to wait.
        limit: Duration,
    },
    /// It never spoke to the harness: neither shim nor tracer is there. The program, or one that it replaced itself by or
    /// started, runs with privileges, or is linked statically and was started by its descriptor.
    NeverJoined {
        /// The number that the process had.
        pid: i32,
        /// Its executable, where that can be told.
        executable: String,
    },
    /// It has started more processes than it may have at once.
    TooManyProcesses {
        /// How many it may have.
        limit: usize,
    },
    /// It closed the descriptor by which the shim speaks to the harness. (A process that notices ends with status 121.)
    LinkClosed,
    /// It talked to the harness without end at a single moment: processes of it hand something round in a circle.
    NeverAdvanced,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exited(status) => write!(f, "the program ended: {status}"),
            Self::Stopped(status) => write!(f, "the program was stopped: {status}"),
            Self::NeverWaited { limit } => write!(
                f,
                "the program did not wait within {limit:?} of real time: it computes without end, or waits where virtual \
                 time does not reach (docs/virtual-time.md)"
            ),
            Self::NeverJoined { pid, executable } => write!(
                f,
                "process {pid} ({executable}) is not in virtual time: does it run with privileges, or is it linked \
                 statically and was started by its descriptor (fexecve)?"
            ),
            Self::TooManyProcesses { limit } => {
                write!(f, "the program started more than {limit} processes")
            }
            Self::LinkClosed => f.write_str(
                "the program closed the descriptor by which the shim speaks to the harness",
            ),
            Self::NeverAdvanced => {
                f.write_str("processes of the program keep one another busy without time going on")
            }
        }
    }
}
