//! What passes between the processes of a program and the outside.

use crate::link::{Change, Clocks, SentFrame, Unsent};

/// Handles what the processes do to the outside while they run.
pub(crate) trait Outside {
    fn frame(&mut self, sent: &SentFrame);
    /// A process did something with a serial port, given by its index.
    fn serial(&mut self, number: usize, change: Change);
    /// A process asks what has not yet left such a port.
    fn unsent(&mut self, number: usize) -> Unsent;
    /// A process waits: its output is complete.
    fn paused(&mut self);
}

/// Inputs for all processes at an instant.
#[derive(Debug, Default)]
pub(crate) struct Given {
    pub clocks: Clocks,
    pub frames: Vec<SentFrame>,
    pub bytes_came: bool,
    /// Signal for the eldest process only; zero for none.
    pub signal: u32,
}
