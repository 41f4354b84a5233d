//! The time before the first message of a node, where a measurement says since when it counts.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::rigs::{load, project};
use crate::strange_frames::RIG;
use harness::TrialRun;
use tests::project::why;
use wire::can::{CanFrame, Id, StandardId};
use wire::device::{Device, PortId, Transmit};
use wire::time::{Span, Timestamp};

/// Sends its message every 0.1 s, from a time on.
#[derive(Debug)]
struct Late {
    next: Timestamp,
    is_due: bool,
}

impl Device for Late {
    fn receive(&mut self, _: Timestamp, _: PortId, _: &Transmit) {}

    fn wake(&mut self, now: Timestamp) {
        if now >= self.next {
            (self.next, self.is_due) = (now + Span::from_millis(100), true);
        }
    }

    fn next_wakeup(&self) -> Timestamp {
        self.next
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        let id = Id::Standard(StandardId::new(512).unwrap());
        let frame = CanFrame::new(id, &[0; 8]).unwrap();
        std::mem::take(&mut self.is_due).then_some((PortId(0), Transmit::Frame(frame)))
    }
}

fn plan(check: &str) -> String {
    format!(
        "name = \"plan\"\ntitle = \"\"\nrig = \"pack\"\n\
         steps = [{{ wait = {{ duration_s = 1 }} }}, {{ wait = {{ duration_s = 2 }}, label = \"on\" }}]\n\
         [[measurement]]\nname = \"it\"\ndoc = \"\"\nquantity = \"period.manager.ManagerCommand\"\n{check}\n"
    )
}

/// The run with a node that begins at this time.
fn run(check: &str, begins_ms: i64) -> TrialRun {
    let trial = load(&project(RIG, &plan(check))).unwrap_or_else(|error| panic!("{}", why(&error)));
    let late = move || Late { next: Timestamp::ZERO + Span::from_millis(begins_ms), is_due: false };
    trial.with_node("manager", late).run().unwrap()
}

const MOST: &str = "unit = \"s\"\ncheck = { all_within = { at_most = 0.5 } }";
const SHARE: &str = "unit = \"1\"\ncheck = { share_within = { share = 0.9, band = [0.09, 0.11] } }";

#[test]
fn the_first_wait_counts_since_what_the_measurement_says() {
    for (check, since, begins_ms, passes) in [
        // Plans that say nothing of it are judged as before.
        (MOST, "", 1_300, true),
        (MOST, "start", 400, true),
        (MOST, "start", 1_300, false),
        (MOST, "on", 1_300, true),
        (MOST, "on", 1_700, false),
        // It began before the step.
        (MOST, "on", 900, true),
        (SHARE, "", 1_300, true),
        (SHARE, "start", 1_300, false),
        (SHARE, "start", 100, true),
    ] {
        let said = if since.is_empty() { "".to_owned() } else { format!("since = \"{since}\"\n") };
        let run = run(&format!("{said}{check}"), begins_ms);
        assert_eq!(run.passed(), passes, "{since} {begins_ms}: {run}");
    }
    // The frame takes 252 us on the bus.
    assert_eq!(run(&format!("since = \"start\"\n{MOST}"), 1_300).value("it"), Some(1.300252));
}

#[test]
fn a_node_that_never_begins_breaks_the_limit() {
    let never = run(&format!("since = \"on\"\n{MOST}"), 60_000);
    assert!(!never.passed() && never.value("it") == Some(2.0), "{never}");
    let unset = run(MOST, 60_000);
    assert!(!unset.passed() && unset.value("it").is_none(), "{unset}");
}

#[test]
fn what_it_cannot_count_since_is_refused() {
    let refused = |check: &str, quantity: &str| {
        let plan = plan(check).replace("period.manager.ManagerCommand", quantity);
        let Err(error) = load(&project(RIG, &plan)) else { panic!("taken") };
        why(&error)
    };
    let step = refused(&format!("since = \"off\"\n{MOST}"), "period.manager.ManagerCommand");
    assert!(step.contains("no step or label `off` in this plan"), "{step}");
    let signal = refused(&format!("since = \"start\"\n{MOST}"), "step.duration");
    assert!(signal.contains("`step.duration` has no time before its first message"), "{signal}");
}
