//! Whether a program in virtual time has set its serial ports as the lines are set.
//!
//! Bytes cross such a line whatever the rate is, so that only the settings reveal what a real line would refuse. Stop
//! bits are not compared: a UART that waits for one more or less makes no error.

use crate::world::ports::RATE_GRACE;
use lockstep::Lockstep;
use ports::serial::written;
use wire::device::PortId;
use wire::serial::SerialSettings;
use wire::time::Timestamp;

#[derive(Debug, Default)]
pub(super) struct Uarts {
    ports: Vec<Uart>,
    is_told: bool,
}

#[derive(Debug)]
struct Uart {
    port: PortId,
    line: String,
    right: SerialSettings,
    wrong_since: Option<Timestamp>,
}

impl Uarts {
    /// Adds the program's port on a line with these settings.
    pub(super) fn add(&mut self, port: PortId, line: &str, right: SerialSettings) {
        self.ports.push(Uart { port, line: line.to_owned(), right, wrong_since: None });
    }

    /// Looks at what the program has set by `now`.
    pub(super) fn look(&mut self, now: Timestamp, program: &Lockstep) {
        for Uart { port, right, wrong_since, .. } in &mut self.ports {
            *wrong_since = match program.framing(*port) {
                Some(set) if !understands(set, *right) => wrong_since.or(Some(now)),
                _ => None,
            };
        }
    }

    /// When a port will have been wrong for too long.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        let due = self.ports.iter().filter_map(|uart| Some(uart.wrong_since? + RATE_GRACE)).min();
        due.filter(|_| !self.is_told).unwrap_or(Timestamp::MAX)
    }

    /// What is wrong, once it has been wrong for too long. Returned once.
    pub(super) fn wrong(
        &mut self,
        now: Timestamp,
        node: &str,
        program: &Lockstep,
    ) -> Option<String> {
        if now < self.next_wakeup() {
            return None;
        }
        let is_due = |uart: &&Uart| uart.wrong_since.is_some_and(|at| now - at >= RATE_GRACE);
        let Uart { port, line, right, .. } = self.ports.iter().find(is_due)?;
        let (set, right) = (written(program.framing(*port)?), written(*right));
        self.is_told = true;
        Some(format!(
            "`{node}` has set its port on the line \"{line}\" to {set}, and the line is set to {right}: a real line would \
             carry nothing but errors"
        ))
    }
}

fn understands(set: SerialSettings, right: SerialSettings) -> bool {
    set == SerialSettings { stop_bits: set.stop_bits, ..right }
}
