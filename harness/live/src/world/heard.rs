//! What the world hears of a device under test.

use super::role_port::PortEvent;
use controller::mission::Report;

pub(super) enum Heard {
    Report(Report),
    /// Bytes or frames were received; a report may follow.
    Nothing,
    Note(String),
    /// A line that is not a report; there may be any number of them.
    BadLine(String),
    /// A line that should have been a report on which the run depends.
    Misreport(String),
    /// An event of a port of the in-process controller.
    Port(&'static str, PortEvent),
    Ended(String),
    NodeEnded(String, String),
}
