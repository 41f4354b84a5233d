//! Proves from its record alone that a run left its bench at rest.

use super::Run;
use controller::mission::Report;
use record::{Device, Record, RecordKind};
use wire::base::payload::Payload;
use wire::base::serial_link::{COMPUTER_ID, Line};
use wire::base::{Message, Request, can_link};
use wire::time::{Span, Timestamp};
use wire::units::Pose;

/// Time that the engine waits for rest.
const REST_WAIT: Span = Span::from_secs(5);

fn is_stop(record: &Record) -> bool {
    match &record.kind {
        RecordKind::Frame(frame) => can_link::parse_request(frame) == Some(Request::Stop),
        RecordKind::Bytes(bytes) => {
            let stop = Line::Write {
                address: Message::Stop.register(),
                computer: COMPUTER_ID,
                data: Payload::from_slice(&[0]).expect("one byte fits"),
            };
            bytes == stop.encode().as_slice() || bytes == b"S\r"
        }
        _ => false,
    }
}

impl Run {
    /// Checks that everything that can move was commanded to stop, and stands at the end of the run.
    ///
    /// # Panics
    ///
    /// When the record does not prove it.
    pub fn assert_at_rest(&self) {
        // The controller stops a base, the plan itself a table.
        let by =
            if self.sent_by(Device::Base).is_empty() { Device::Plan } else { Device::Controller };
        let last = self.records.iter().rev().find(|record| record.device == by && is_stop(record));
        let last = last.expect("every run ends with a stop");
        assert!(self.simulated.end - last.at <= REST_WAIT, "the stop belongs to the end");
        let state = self.records.iter().rev().find_map(|record| match record.kind {
            RecordKind::Report(Report::State(state)) => Some(state),
            _ => None,
        });
        assert!(state.is_some_and(|state| !state.moving), "{state:?}");
        // Each state comes with the truth; the last two states were requested at the end.
        let truths: Vec<(Timestamp, Pose)> = self
            .records
            .iter()
            .filter_map(|record| match record.kind {
                RecordKind::Truth { pose, .. } => Some((record.at, pose)),
                _ => None,
            })
            .collect();
        if let [.., (before_at, before), (at, after)] = truths[..]
            && state.is_some_and(|state| state.samples > 0)
        {
            let passed = (at - before_at).as_secs_f64();
            let moved = (after.x - before.x).m().hypot((after.y - before.y).m());
            let turned = (after.heading - before.heading).abs().deg();
            // If it came to rest between the two, it braked at 0.5 m/s^2, 22.5 deg/s^2 or 15 deg/s^2.
            assert!(moved <= 0.5 * passed * passed / 2.0 + 1e-9, "{moved} m in {passed} s");
            assert!(turned <= 22.5 * passed * passed / 2.0 + 1e-6, "{turned} deg in {passed} s");
        }
    }
}
