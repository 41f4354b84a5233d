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
    /// The controller has ended: what it did, to stand behind its name.
    Ended(String),
    /// A node's name, and what it did.
    NodeEnded(String, String),
    /// The bench has lost its way to the controller, and why.
    Lost(String),
}
