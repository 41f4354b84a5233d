//! Rust code of a test plays nodes under test: what it must not do, and what a campaign leaves alone.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::rigs::{cells, load, project};
use crate::strange_frames::RIG;
use harness::record::sink::Level;
use harness::{Trial, TrialError};
use record::outcome::Outcome;
use tempfile::TempDir;
use wire::can::{CanFrame, StandardId};
use wire::device::{Device, PortId, Transmit};
use wire::packet::Packet;
use wire::time::Timestamp;

/// Sends this a tenth of a second after its start, so many times.
#[derive(Debug, Clone, Copy)]
struct Sends {
    what: Transmit,
    at: PortId,
    times: u64,
}

const AT: Timestamp = Timestamp::from_nanos(100_000_000);

impl Device for Sends {
    fn receive(&mut self, _: Timestamp, _: PortId, _: &Transmit) {}

    fn wake(&mut self, _: Timestamp) {}

    fn next_wakeup(&self) -> Timestamp {
        if self.times > 0 { AT } else { Timestamp::MAX }
    }

    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        if now < AT {
            return None;
        }
        self.times = self.times.checked_sub(1)?;
        Some((self.at, self.what))
    }
}

fn frame() -> Transmit {
    Transmit::Frame(CanFrame::new(StandardId::new(512).unwrap(), &[0; 8]).unwrap())
}

fn trial() -> (TempDir, Trial) {
    let folder = project(RIG, &cells());
    let trial = load(&folder).unwrap();
    (folder, trial)
}

fn sends(what: Transmit, at: u8, times: u64) -> Sends {
    Sends { what, at: PortId(at), times }
}

fn reason(sends: Sends) -> String {
    let run = trial().1.with_node("manager", move || sends).run().unwrap();
    assert_eq!(run.summary().outcome, Outcome::Failed, "{run}");
    run.summary().reason.clone().unwrap_or_default()
}

/// Found by a user: the code never ran, and the run passed.
#[test]
fn code_for_a_node_that_is_not_under_test_is_refused() {
    for (name, help) in [("manger", "did you mean `manager`"), ("cells", "it is emulated")] {
        let (_folder, trial) = trial();
        let trial = trial.with_node(name, || sends(frame(), 0, 1));
        let error = trial.run().unwrap_err();
        assert!(matches!(&error, TrialError::NoSuchNode { node, .. } if node == name), "{error:?}");
        assert!(format!("{error:?}").contains(help), "{error:?}");
    }
}

/// Found by a user: the first hung for ever, the others were lost without a word.
#[test]
fn code_that_does_what_no_device_can_has_failed() {
    let bytes = Transmit::Bytes(Packet::from_slice(b"1").unwrap());
    for (sends, expected) in [
        (sends(frame(), 0, u64::MAX), "sends without an end"),
        (sends(frame(), 3, 1), "sends at its port 3, which is on no line"),
        (sends(bytes, 0, 1), "sends bytes on the bus can0"),
    ] {
        let reason = reason(sends);
        assert!(reason.contains("manager") && reason.contains(expected), "{reason}");
    }
}

/// Found by a user: sound code broke its own properties, because its messages were changed behind it.
#[test]
fn a_campaign_leaves_alone_what_is_under_test() {
    let (folder, trial) = trial();
    let out = folder.path().join("campaign");
    let campaign = trial.with_node("manager", || sends(frame(), 0, 1)).in_folder(&out).campaign();
    campaign.must_pass().cases(60).run().unwrap();
    let cases = std::fs::read_to_string(out.join("cases.jsonl")).unwrap();
    assert!(cases.contains("\"cells.") && !cases.contains("\"manager."), "{cases}");
}

#[test]
fn a_record_of_another_plan_is_not_run_again() {
    let (folder, trial) = trial();
    let out = folder.path().join("run");
    let trial = trial.with_node("manager", || sends(frame(), 0, 1));
    let recorded = trial.clone().with_record(Level::Full).in_folder(&out).run().unwrap();
    assert!(recorded.summary().simulated_s > 0.0);
    trial.rerun(&out).unwrap();
    let other = project(RIG, &cells().replacen("name = \"", "name = \"another-", 1));
    let other = load(&other).unwrap().with_node("manager", || sends(frame(), 0, 1));
    let error = other.rerun(&out).unwrap_err();
    assert!(matches!(error, TrialError::OtherPlan { .. }), "{error:?}");
}
