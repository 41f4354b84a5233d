//! What the device under test says, and whether that is more than anybody can keep.

use super::LiveWorld;
use super::device_under_test::{Heard, Running};
use super::journal::note;
use record::Device;
use record::outcome::PortSide;
use record::sink::RecordSink;
use wire::time::{Span, Timestamp};

/// Window for the count of reports.
const WINDOW: Span = Span::from_secs(1);
/// Most reports within the window. Assumption: a controller reports its state at 1 kHz at most, and reports that
/// gathered in the pipes while this machine was busy come at once.
const REPORTS_MAX: u64 = 20_000;

/// Counts the reports of the device under test: each is recorded, and the disk is finite.
#[derive(Debug, Default)]
pub(super) struct Talk {
    reports: u64,
    /// Lines that are not reports.
    unread: u64,
    window: Option<(Timestamp, u64)>,
}

impl Talk {
    /// Counts a report; returns whether it is one too many.
    pub(super) fn floods(&mut self, now: Timestamp) -> bool {
        self.reports += 1;
        let (began, count) = self.window.get_or_insert((now, 0));
        if now - *began >= WINDOW {
            (*began, *count) = (now, 0);
        }
        *count += 1;
        *count > REPORTS_MAX
    }

    /// Counts a line that is not a report.
    pub(super) const fn misspoke(&mut self) {
        self.unread += 1;
    }

    /// What it has sent instead of a state.
    pub(super) fn instead_of_a_state(&self) -> String {
        match (self.reports, self.unread) {
            (0, 0) => "said nothing".to_owned(),
            (0, 1) => "said one line that is no report".to_owned(),
            (0, unread) => format!("said {unread} lines that are no reports"),
            _ => "reported no state".to_owned(),
        }
    }

    pub(super) fn why() -> String {
        format!(
            "the device under test sent more than {REPORTS_MAX} reports within {} s",
            WINDOW.as_secs_f64()
        )
    }
}

impl LiveWorld {
    pub(super) fn hear_device(
        &mut self,
        now: Timestamp,
        sink: &mut dyn RecordSink,
        device: &Running,
        heard: Heard,
    ) {
        match heard {
            Heard::Report(_) if self.talk.floods(now) => {
                self.director.engine.failed(now, &Talk::why());
            }
            Heard::Report(report) => {
                if let (Some(eyes), Some(robot)) = (&mut self.eyes, self.rig.robot()) {
                    eyes.report(now, &robot.bench, &report);
                }
                self.director.record_report(now, &mut self.rig, sink, &report);
                self.director.engine.report(now, &report);
            }
            Heard::Nothing => {}
            Heard::BadLine(what) => {
                self.talk.misspoke();
                if let Some(what) = self.journal.note(what) {
                    note(sink, now, Device::Controller, what);
                }
            }
            Heard::Misreport(what) => self.director.engine.failed(now, &what),
            Heard::Note(what) => note(sink, now, Device::Controller, what),
            Heard::Port(role, event) => {
                let name = device.in_process().and_then(|here| here.port(role));
                let name = name.map_or("", |port| port.name());
                let whose = (role.into(), PortSide::Controller);
                if let Some(what) = self.journal.take(now, whose, name, &event) {
                    note(sink, now, Device::Controller, what);
                }
            }
            Heard::Ended(how) => self.director.engine.lost_controller(now, &how),
            Heard::NodeEnded(node, how) => self.director.engine.lost_node(now, &node, &how),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{REPORTS_MAX, Talk, WINDOW};
    use wire::time::Timestamp;

    #[test]
    fn what_was_said_instead_of_a_state_is_told() {
        let mut talk = Talk::default();
        assert_eq!(talk.instead_of_a_state(), "said nothing");
        talk.misspoke();
        assert_eq!(talk.instead_of_a_state(), "said one line that is no report");
        talk.misspoke();
        assert_eq!(talk.instead_of_a_state(), "said 2 lines that are no reports");
        talk.floods(Timestamp::ZERO);
        assert_eq!(talk.instead_of_a_state(), "reported no state");
    }

    #[test]
    fn only_more_than_anybody_needs_is_a_flood() {
        let mut talk = Talk::default();
        let mut now = Timestamp::ZERO;
        for _ in 0..3 {
            assert!((0..REPORTS_MAX).all(|_| !talk.floods(now)));
            now += WINDOW;
        }
        assert!(!(0..REPORTS_MAX).any(|_| talk.floods(now)));
        assert!(talk.floods(now));
    }
}
