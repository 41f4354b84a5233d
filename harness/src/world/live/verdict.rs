//! What is said of a run in real time when it is over: whose fault its end is, how well time was kept, and what
//! crossed the ports.

use super::LiveWorld;
use super::device_under_test::Running;
use super::ports::{BASE, GYRO, Ports};
use crate::engine::Ending;
use crate::outcome::{Outcome, PortSide, PortSummary, Timing};
use wire::time::Timestamp;

impl LiveWorld {
    /// The ending, with what the ports and the machine have to do with it.
    pub(super) fn judge(&self, ending: Ending, end: Timestamp, ports: &Ports) -> Ending {
        let ending = self.journal.explain(ending, end);
        let late = self.lateness.verdict();
        let miswired = ports.miswired(self.stage.bench.gyro_stream().format);
        let why = match ending.outcome {
            Outcome::Passed => late,
            Outcome::Failed | Outcome::Timeout => {
                let flooded = self.foreign.verdict(end, ports.name(BASE));
                let broken = self.lateness.verdict_on_broken_step();
                // A flood makes a machine late, not the other way round.
                flooded.or(late).or(broken).or(miswired)
            }
            Outcome::Error | Outcome::Aborted => None,
        };
        match why {
            Some(why) => {
                let then = ending.reason.map_or_else(String::new, |reason| format!("; {reason}"));
                Ending { outcome: Outcome::Error, reason: Some(format!("{why}{then}")) }
            }
            None if self.foreign.frames() > 0 && ending.outcome != Outcome::Passed => {
                let then = ending.reason.unwrap_or_else(|| "no reason was given".to_owned());
                let (foreign, port) = (self.foreign.frames(), ports.name(BASE));
                let reason =
                    format!("{then}; {foreign} frames of other nodes crossed {port} meanwhile");
                Ending { reason: Some(reason), ..ending }
            }
            None => ending,
        }
    }

    pub(super) fn timing(&self, device: &Running, scheduling: String) -> Timing {
        Timing {
            late: self.lateness.histogram().spread(),
            bus_to_command: device.in_process().map(|here| here.bus_to_command().spread()),
            late_ms_max: self.lateness.late_max().as_secs_f64() * 1e3,
            misses: self.lateness.misses(),
            misses_judged: self.lateness.misses_judged(),
            scheduling,
        }
    }

    pub(super) fn port_summaries(&self, ports: &Ports, device: &Running) -> Vec<PortSummary> {
        let mut summaries = ports.summaries(&self.journal);
        for role in [GYRO, BASE] {
            if let Some(port) = device.in_process().and_then(|here| here.port(role)) {
                summaries.push(self.journal.summary((role, PortSide::Controller), port));
            }
        }
        summaries
    }
}
