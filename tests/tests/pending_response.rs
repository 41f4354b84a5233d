//! A server under test that says "response pending" for ever.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use record::outcome::Outcome;
use tests::project;
use wire::can::{CanFrame, StandardId};
use wire::device::{Device, PortId, Transmit};
use wire::time::{Span, Timestamp};

const RIG: &str = "[[line]]\nname = \"can0\"\ncan = {}\n\
    [[node]]\nname = \"ecu\"\nat = \"can0\"\nunder_test = { in_process = true }\n\
    isotp = { request_id = 0x7E0, response_id = 0x7E8 }\n\
    [[node]]\nname = \"tester\"\nat = \"can0\"\ntester = true\n";

const PLAN: &str = "name = \"asks\"\ntitle = \"\"\nrig = \"ecu\"\n\
    steps = [{ uds = { node = \"ecu\", request = [0x22, 2, 0] } }]\n\
    [[measurement]]\nname = \"asks\"\ndoc = \"\"\nquantity = \"step.duration\"\nunit = \"s\"\n\
    check = { all_within = [0, 1] }\n";

/// Once it was asked, it says so each second.
#[derive(Debug, Default)]
struct Pending {
    next: Option<Timestamp>,
    outgoing: Option<CanFrame>,
}

impl Device for Pending {
    fn receive(&mut self, now: Timestamp, _: PortId, _: &Transmit) {
        self.next = Some(now + Span::from_millis(20));
    }

    fn wake(&mut self, now: Timestamp) {
        if self.next.is_some_and(|next| next <= now) {
            self.next = Some(now + Span::from_secs(1));
            let id = StandardId::new(0x7E8).unwrap();
            self.outgoing = CanFrame::new(id, &[3, 0x7F, 0x22, 0x78, 0, 0, 0, 0]);
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        self.next.unwrap_or(Timestamp::MAX)
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.outgoing.take().map(|frame| (PortId(0), Transmit::Frame(frame)))
    }
}

/// Found by a user: a timeout, as if the bench had been too slow.
#[test]
fn it_has_failed() {
    let folder = project::of([("rigs/ecu.toml", RIG), ("plan.toml", PLAN)]);
    let trial = project::load(&folder, "plan.toml").unwrap();
    let run = trial.with_node("ecu", Pending::default).run().unwrap();
    let summary = run.summary();
    assert_eq!(summary.outcome, Outcome::Failed, "{run}");
    let reason = summary.reason.as_deref().unwrap_or_default();
    assert!(reason.ends_with("took longer than its limit: no final response came"), "{reason}");
}
