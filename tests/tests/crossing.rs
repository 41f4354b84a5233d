//! A line that loses traffic ends a run in virtual time as a broken bench, and the error names the line.

use harness::operator::Answers;
use harness::run::{Prepared, simulate_across};
use plan::made::Made;
use record::outcome::Outcome;
use record::sink::NullSink;
use rig::crossing::{Crossing, CrossingFailure, How, Toward};
use wire::device::Transmit;
use wire::time::Timestamp;

/// A crossing in which one line carries nothing.
struct Stuck {
    line: usize,
    failure: Option<CrossingFailure>,
}

impl Crossing for Stuck {
    fn carry(&mut self, _: Timestamp, line: usize, _: usize, _: &mut Transmit) -> bool {
        if line != self.line {
            return true;
        }
        let how =
            How::Late { heard: "nothing".to_owned(), sent: "7 bytes".to_owned(), limit_s: 0.05 };
        let failure = CrossingFailure::new("bytes", "line", Toward::Device, "/dev/pts/1", how);
        self.failure = Some(failure);
        false
    }

    fn failure(&mut self) -> Option<CrossingFailure> {
        self.failure.take()
    }

    fn bus(&self) -> &'static str {
        "stuck"
    }
}

#[test]
fn a_stuck_line_ends_the_run_in_error() {
    let prepared = Prepared::load("live-table-run", &Made::default()).unwrap();
    for line in 0..prepared.crossed_lines().len() {
        let stuck: Box<dyn Crossing> = Box::new(Stuck { line, failure: None });
        let run = simulate_across(
            Some(stuck),
            &prepared,
            1,
            &Answers::default(),
            &mut NullSink,
            &mut |_| true,
        );
        assert_eq!(run.ending.outcome, Outcome::Error);
        let reason = run.ending.reason.unwrap();
        assert!(
            reason.contains("the line across /dev/pts/1: nothing of 7 bytes came out"),
            "{reason}"
        );
    }
}
