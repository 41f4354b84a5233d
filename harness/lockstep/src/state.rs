//! States of a program.

use std::fmt;
use std::process::ExitStatus;
use std::time::Duration;
use wire::time::Timestamp;

/// Current state of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State<'a> {
    /// It waits for a time, or has not begun yet.
    Running,
    /// It waits only for input: [`next_wakeup`](wire::device::Device::next_wakeup) is
    /// [`Timestamp::MAX`](wire::time::Timestamp::MAX).
    WaitsForEver,
    /// It no longer runs.
    Ended(&'a Ended),
}

/// Why a program no longer runs. In any case none of its processes is left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// It ended by itself or by a signal of another program; the exit status of the started process.
    Exited(ExitStatus),
    /// It was [stopped](crate::Lockstep::stop): it ended after SIGTERM with this status, or was killed, which is also a
    /// status.
    Stopped(ExitStatus),
    /// It was killed while it ran, because whoever started it [gave up](crate::Program::until).
    GivenUp,
    /// It did not wait within the real-time limit: it computes endlessly, or waits in a way that the shim does not see.
    NeverWaited {
        /// The limit.
        limit: Duration,
    },
    /// All of its threads wait for each other, without a deadline: none of them can ever go on.
    Deadlocked {
        /// How many threads wait.
        threads: u32,
        /// When the last of them began to wait.
        since: Timestamp,
    },
    /// It never connected to the harness: it has neither shim nor tracer. The program, or one that replaced it or was
    /// started by it, runs with privileges, or is linked statically and was started by descriptor.
    NeverJoined {
        /// Its process id.
        pid: i32,
        /// Its executable, if known.
        executable: String,
    },
    /// It has started too many processes.
    TooManyProcesses {
        /// The limit.
        limit: usize,
    },
    /// It closed the shim's descriptor to the harness. (A process that notices ends with status 121.)
    LinkClosed,
    /// It communicated endlessly at one instant: its processes pass something round in a circle.
    NeverAdvanced,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exited(status) => write!(f, "the program ended: {status}"),
            Self::Stopped(status) => write!(f, "the program was stopped: {status}"),
            Self::GivenUp => f.write_str("the program was killed on request"),
            Self::NeverWaited { limit } => write!(
                f,
                "the program did not wait within {limit:?} of real time: it computes without end, or waits where virtual \
                 time does not reach (docs/virtual-time.md)"
            ),
            Self::Deadlocked { threads, since } => {
                let since_s = (since.as_secs_f64() * 1e3).round() / 1e3;
                match threads {
                    1 => f.write_str("its only thread waits for itself")?,
                    _ => write!(f, "all {threads} threads of it wait for each other")?,
                }
                write!(f, " since {since_s} s, and nothing else can wake it")
            }
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
