//! A server under test on a bus whose DBC has the identifiers of its diagnostics too, as many a DBC does.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use harness::TrialRun;
use tests::project;
use wire::can::{CanFrame, StandardId};
use wire::device::{Device, PortId, Transmit};
use wire::time::Timestamp;

const DBC: &str = "VERSION \"\"\nBU_: ecu tester gw\n\
    BO_ 2016 DiagRequest: 8 tester\n SG_ RequestBytes : 0|8@1+ (1,0) [0|255] \"\" ecu\n\
    BO_ 2024 DiagResponse: 8 ecu\n SG_ ResponseBytes : 0|8@1+ (1,0) [0|255] \"\" tester\n\
    BO_ 512 Ignition: 8 tester\n SG_ On : 0|1@1+ (1,0) [0|1] \"\" ecu\n";

const RIG: &str = "[[line]]\nname = \"can0\"\ncan = { dbc = \"bus.dbc\" }\n\
    [[node]]\nname = \"ecu\"\nat = \"can0\"\nunder_test = { in_process = true }\n\
    isotp = { request_id = 0x7E0, response_id = 0x7E8 }\n\
    [[node]]\nname = \"tester\"\nat = \"can0\"\ntester = true\n";

/// Confirms that a tester is present, in a frame without padding.
#[derive(Debug, Default)]
struct Server(Option<CanFrame>);

impl Device for Server {
    fn receive(&mut self, _: Timestamp, _: PortId, heard: &Transmit) {
        if let Transmit::Frame(frame) = heard
            && frame.data().starts_with(&[2, 0x3E, 0])
        {
            self.0 = CanFrame::new(StandardId::new(0x7E8).unwrap(), &[2, 0x7E, 0]);
        }
    }

    fn transmit(&mut self, _: Timestamp) -> Option<(PortId, Transmit)> {
        self.0.take().map(|frame| (PortId(0), Transmit::Frame(frame)))
    }

    fn wake(&mut self, _: Timestamp) {}

    fn next_wakeup(&self) -> Timestamp {
        Timestamp::MAX
    }
}

fn run(rest: &str) -> TrialRun {
    let plan = format!(
        "name = \"asks\"\ntitle = \"\"\nrig = \"ecu\"\n\
         steps = [{{ uds = {{ node = \"ecu\", request = [0x3E, 0] }} }}]\n{rest}"
    );
    let folder =
        project::of([("rigs/ecu.toml", RIG), ("rigs/bus.dbc", DBC), ("plan.toml", plan.as_str())]);
    let trial = project::load(&folder, "plan.toml").unwrap();
    trial.with_node("ecu", Server::default).run().unwrap()
}

/// Found in a DBC of the field: `DiagRequest` had the same identifier, and the rig was refused.
#[test]
fn the_frames_of_the_channel_are_those_of_diagnostics() {
    let unexpected = "[[measurement]]\nname = \"m\"\ndoc = \"m\"\nquantity = \"unexpected.can0\"\nunit = \"1\"\n\
                      check = { all_within = [0, 0] }\n";
    let run = run(unexpected);
    assert!(run.passed(), "{run}");
    assert_eq!(run.summary().notes, Vec::<String>::new(), "{run}");
}

#[test]
fn requests_to_it_have_a_name() {
    for target in ["tester.UdsRequest", "ecu.UdsResponse"] {
        let fault = format!(
            "[[fault]]\ntarget = \"{target}\"\nwhat = {{ drop = {{ loss_percent = 100 }} }}\n"
        );
        let run = run(&fault);
        assert!(!run.passed() && run.to_string().contains("no response came"), "{target}: {run}");
    }
}

#[test]
fn what_else_the_dbc_has_is_said_as_before() {
    let plan = run("finally = [{ message = \"Ignition\", set = { On = 0 } }]\n");
    assert!(plan.passed(), "{plan}");
}
