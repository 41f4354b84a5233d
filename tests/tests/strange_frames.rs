//! A node that sends frames which are no messages of it: the run says so, and those with the identifier of another node's
//! message count as such.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::rigs::{cells, load, project};
use embedded_can::Frame as _;
use harness::TrialRun;
use wire::can::{CanFrame, ExtendedId, Id, StandardId};
use wire::device::{Device, PortId, Transmit};
use wire::time::{Span, Timestamp};

pub const RIG: &str = r#"
[[line]]
name = "can0"
can = { bit_rate = 500_000, dbc = "../devices/pack.dbc" }
[[node]]
name = "cells"
at = "can0"
emulate = "cells"
[[node]]
name = "manager"
at = "can0"
dbc_node = "Manager"
under_test = { in_process = true }
"#;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Content {
    Sound,
    /// The cells' checksum is wrong.
    Damaged,
    Remote,
}

/// Sends one frame of each identifier every half a second.
#[derive(Debug)]
struct Strange {
    identifiers: Vec<Id>,
    content: Content,
    next: Timestamp,
    outgoing: Vec<CanFrame>,
}

impl Device for Strange {
    fn receive(&mut self, _: Timestamp, _: PortId, _: &Transmit) {}

    fn wake(&mut self, now: Timestamp) {
        if now < self.next {
            return;
        }
        self.next = now + Span::from_millis(500);
        let mut data = [0; 8];
        data[7] = crc::Crc::<u8>::new(&crc::CRC_8_SAE_J1850).checksum(&data[..7]);
        let frame = |id: &Id| match self.content {
            Content::Sound => CanFrame::new(*id, &data),
            Content::Damaged => CanFrame::new(*id, &[0x55; 8]),
            Content::Remote => CanFrame::new_remote(*id, 8),
        };
        self.outgoing = self.identifiers.iter().map(|id| frame(id).unwrap()).collect();
    }

    fn next_wakeup(&self) -> Timestamp {
        self.next
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.outgoing.pop().map(|frame| (PortId(0), Transmit::Frame(frame)))
    }
}

fn notes(identifiers: &[Id]) -> Vec<String> {
    run(identifiers).summary().notes.clone()
}

fn run(identifiers: &[Id]) -> TrialRun {
    run_of(&cells(), identifiers, Content::Sound)
}

fn run_of(plan: &str, identifiers: &[Id], content: Content) -> TrialRun {
    let trial = load(&project(RIG, plan)).unwrap();
    let identifiers = identifiers.to_vec();
    let strange = move || Strange {
        identifiers: identifiers.clone(),
        content,
        next: Timestamp::from_nanos(1),
        outgoing: Vec::new(),
    };
    trial.with_node("manager", strange).run().unwrap()
}

fn standard(raw: u16) -> Id {
    Id::Standard(StandardId::new(raw).unwrap())
}

#[test]
fn frames_that_are_no_messages_of_their_sender_are_noted() {
    let own = "manager sent 4 frames of ManagerCommand with more bytes than it has";
    assert_eq!(notes(&[standard(512)]), [own]);
    let extended = Id::Extended(ExtendedId::new(512).unwrap());
    assert_eq!(
        notes(&[standard(256), standard(0x7ff), extended]),
        [
            "manager sent 4 frames with the identifier 0x100 of cells",
            "manager sent frames that are no message of can0: 0x00000200 (4), 0x7ff (4)",
        ]
    );
}

/// Found by a user: every node on the bus got a voltage of zero, and the run passed. Its log did not.
#[test]
fn a_forged_message_is_judged_as_its_owners() {
    assert!(run(&[standard(512), standard(0x7ff)]).passed());
    let forged = run(&[standard(256)]);
    assert!(!forged.passed() && forged.value("it") == Some(0.0), "{forged}");
}

/// Found by a user: they were noted nowhere.
#[test]
fn remote_requests_are_noted() {
    let run = run_of(&cells(), &[standard(256), standard(512), standard(0x7ff)], Content::Remote);
    assert_eq!(
        run.summary().notes,
        [
            "manager sent frames that are no message of can0: 0x7ff (4)",
            "4 remote requests on can0 for 0x100 of cells, which does not answer them",
            "4 remote requests on can0 for 0x200 of manager",
        ]
    );
    assert!(run.passed(), "{run}");
}

fn at_most(most: u32) -> String {
    format!(
        "{}[[measurement]]\nname = \"strange\"\ndoc = \"What is no message\"\nquantity = \"unexpected.can0\"\n\
         unit = \"1\"\ncheck = {{ all_within = {{ at_most = {most} }} }}\n",
        cells()
    )
}

#[test]
fn a_plan_judges_how_much_came_that_is_no_message() {
    let strange = [standard(0x7ff), standard(0x7fe)];
    let none: [Id; 0] = [];
    for (identifiers, content, most, passes) in [
        (&none[..], Content::Sound, 0, true),
        (&[standard(512)], Content::Sound, 0, true),
        (&strange, Content::Sound, 8, true),
        (&strange, Content::Sound, 7, false),
        (&[standard(256)], Content::Remote, 4, true),
        (&[standard(256)], Content::Remote, 3, false),
        // Found by a user: a frame of another node's message counted twice where its checksum was wrong, too.
        (&[standard(256)], Content::Damaged, 4, true),
        (&[standard(256)], Content::Damaged, 3, false),
    ] {
        let run = run_of(&at_most(most), identifiers, content);
        assert_eq!(run.passed(), passes, "{run}");
    }
    let other = at_most(0).replace("unexpected.can0", "unexpected.can1");
    let Err(error) = load(&project(RIG, &other)) else { panic!("taken") };
    let why = tests::project::why(&error);
    assert!(why.contains("no line `can1` with known messages"), "{why}");
}

#[test]
fn only_some_identifiers_are_listed() {
    let many: Vec<Id> = (0x600..0x620).map(standard).collect();
    let notes = notes(&many);
    let [note] = notes.as_slice() else { panic!("{notes:?}") };
    assert!(note.ends_with(", and 64 with others") && note.matches("0x").count() == 16, "{note}");
}
