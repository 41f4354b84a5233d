//! Messages sent on changes: their times, repetitions, and DBC attributes.

use super::{at, run};
use crate::{Description, Device};
use std::sync::Arc;
use wire::device::Transmit;

const DBC: &str = r#"VERSION ""

BU_: Panel Car

BO_ 1 Button: 2 Panel
 SG_ Pressed : 0|8@1+ (1,0) [0|255] "" Car
 SG_ Level : 8|8@1+ (1,0) [0|255] "" Car

BO_ 2 Lamp: 1 Car
 SG_ On : 0|1@1+ (1,0) [0|1] "" Panel
"#;

/// Attributes of Vector's interaction layer, with these kinds for the message and its first signal.
fn attributes(message: usize, signal: usize) -> String {
    format!(
        "{DBC}BA_DEF_ BO_ \"GenMsgSendType\" ENUM \"cyclic\",\"spontaneous\",\"cyclicAndSpontaneous\",\"NoMsgSendType\";\n\
         BA_DEF_ SG_ \"GenSigSendType\" ENUM \"Cyclic\",\"OnChange\",\"OnChangeWithRepetition\";\n\
         BA_DEF_ BO_ \"GenMsgCycleTimeFast\" INT 0 1000;\n\
         BA_DEF_DEF_ \"GenMsgSendType\" \"NoMsgSendType\";\nBA_DEF_DEF_ \"GenSigSendType\" \"Cyclic\";\n\
         BA_ \"GenMsgSendType\" BO_ 1 {message};\nBA_ \"GenSigSendType\" SG_ 1 Pressed {signal};\n\
         BA_ \"GenMsgCycleTime\" BO_ 1 500;\nBA_ \"GenMsgCycleTimeFast\" BO_ 1 20;\n\
         BA_ \"GenMsgNrOfRepetition\" BO_ 1 2;\nBA_ \"GenMsgDelayTime\" BO_ 1 30;\n"
    )
}

fn parsed(dbc: &str, rest: &str) -> Result<Description, crate::FileError> {
    let text = format!("name = \"panel\"\ndbc = \"panel.dbc\"\nnode = \"Panel\"\n{rest}");
    Description::parse("panel.toml", &text, &mut |_| Ok(dbc.to_owned()))
}

fn device(dbc: &str, rest: &str) -> Device {
    let description = parsed(dbc, rest);
    Device::new(Arc::new(description.unwrap_or_else(|error| panic!("{error}"))), 1)
}

/// Times of sending, in milliseconds, and the two bytes.
fn sent(device: &mut Device, until: f64) -> Vec<(u64, [u8; 2])> {
    let of = |(at, wired): &(wire::time::Timestamp, Transmit)| match wired {
        Transmit::Frame(frame) => {
            ((at.as_secs_f64() * 1e3).round() as u64, [frame.data()[0], frame.data()[1]])
        }
        Transmit::Bytes(_) => panic!("on CAN"),
    };
    run(device, until).iter().map(of).collect()
}

const PRESSED: &str = "[signal.Pressed]\nsteps = [[0, 0], [0.1, 1], [0.3, 0], [0.4, 2]]\n";

#[test]
fn on_change_each_change_is_sent_and_on_event_those_away_from_the_start() {
    let message = |keys: &str| format!("[message.Button]\n{keys}\n{PRESSED}");
    let mut changes = device(DBC, &message("send = \"on_change\""));
    assert_eq!(sent(&mut changes, 1.0), [(100, [1, 0]), (300, [0, 0]), (400, [2, 0])]);
    let mut events = device(DBC, &message("send = \"on_event\""));
    assert_eq!(sent(&mut events, 1.0), [(100, [1, 0]), (400, [2, 0])]);
    let mut both = device(DBC, &message("send = \"cyclic_and_on_change\"\nperiod_s = 0.25"));
    let times: Vec<u64> = sent(&mut both, 0.9).iter().map(|(at, _)| *at).collect();
    assert_eq!(times, [100, 250, 300, 400, 500, 750]);
}

#[test]
fn after_a_change_it_is_sent_faster_for_a_while() {
    let fast = "[message.Button]\nsend = \"on_event\"\nfast_period_s = 0.03\nfast_times = 3\n";
    let mut device = device(DBC, &format!("{fast}{PRESSED}"));
    let times: Vec<u64> = sent(&mut device, 0.39).iter().map(|(at, _)| *at).collect();
    assert_eq!(times, [100, 130, 160, 190]);
}

#[test]
fn two_changes_have_a_delay_between_them() {
    let rest = "[message.Button]\nsend = \"on_change\"\nmin_delay_s = 0.15\n\
        [signal.Level]\nexpression = \"floor(t / 0.1)\"\n";
    let sent = sent(&mut device(DBC, rest), 0.58);
    assert_eq!(sent, [(100, [0, 1]), (250, [0, 2]), (400, [0, 4]), (550, [0, 5])]);
}

#[test]
fn a_dbc_says_when_a_message_is_sent() {
    let times = |message: usize, signal: usize| {
        let rest = "[signal.Pressed]\nsteps = [[0, 0], [0.1, 1]]\n[signal.Level]\nsteps = [[0, 0], [0.3, 1]]\n";
        let mut device = device(&attributes(message, signal), rest);
        sent(&mut device, 0.9).iter().map(|(at, _)| *at).collect::<Vec<u64>>()
    };
    // By its period only.
    assert_eq!(times(0, 0), [500]);
    assert_eq!(times(3, 0), [500]);
    // On each change, with two repetitions, not faster than the delay.
    assert_eq!(times(1, 0), [100, 130, 160, 300, 330, 360]);
    assert_eq!(times(2, 0), [100, 130, 160, 300, 330, 360, 500]);
    // Only on changes of the signal marked so.
    assert_eq!(times(3, 2), [100, 130, 160, 500]);
}

/// Found by a user: a line of text was never sent on a change.
#[test]
fn a_line_of_text_is_sent_on_a_change_of_what_is_printed() {
    let lines = |keys: &str, source: &str| {
        let text = format!(
            "name = \"panel\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"Level\"\nsent_by = \"device\"\n\
             text = \"L {{X:.1}}\\r\\n\"\n{keys}\n[signal.X]\n{source}\n"
        );
        let description = Description::parse("panel.toml", &text, &mut |_| Err(String::new()));
        let mut device = Device::new(Arc::new(description.unwrap()), 1);
        let of = |(at, wired): &(wire::time::Timestamp, Transmit)| match wired {
            Transmit::Bytes(line) => {
                let line = String::from_utf8_lossy(line.as_slice()).trim_end().to_owned();
                ((at.as_secs_f64() * 1e3).round() as u64, line)
            }
            Transmit::Frame(_) => panic!("on a serial line"),
        };
        run(&mut device, 1.0).iter().map(of).collect::<Vec<_>>()
    };
    let steps = "steps = [[0, 0], [0.1, 1], [0.2, 1.04], [0.3, 0], [0.4, -0.04], [0.6, 0.06]]";
    let expected = |of: &[(u64, &str)]| -> Vec<(u64, String)> {
        of.iter().map(|(at, line)| (*at, (*line).to_owned())).collect()
    };
    // What changes by less than is printed is not sent.
    let changes = lines("send = \"on_change\"", steps);
    let seen = [(100, "L 1.0"), (300, "L 0.0"), (400, "L -0.0"), (600, "L 0.1")];
    assert_eq!(changes, expected(&seen));
    let events = lines("send = \"on_event\"\nfast_period_s = 0.05\nfast_times = 1", steps);
    let seen = [100, 150, 400, 450, 600, 650];
    assert_eq!(events.iter().map(|(at, _)| *at).collect::<Vec<_>>(), seen);
    let both = lines("send = \"cyclic_and_on_change\"\nperiod_s = 0.45", steps);
    let seen = [100, 300, 400, 450, 600, 900];
    assert_eq!(both.iter().map(|(at, _)| *at).collect::<Vec<_>>(), seen);
}

#[test]
fn what_has_no_field_is_not_sent_on_a_change() {
    let of = |by: &str, send: &str| {
        let text = format!(
            "name = \"panel\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"Hello\"\nsent_by = \"{by}\"\n\
             text = \"HELLO\\n\"\nsend = \"{send}\"\n"
        );
        Description::parse("panel.toml", &text, &mut |_| Err(String::new()))
    };
    for send in ["on_change", "on_event", "cyclic_and_on_change"] {
        let error = of("device", send).expect_err(send);
        assert!(error.to_string().contains("`Hello` has no field: it never changes"), "{error}");
    }
    // A plan sends it, and may have it repeated.
    assert!(of("host", "on_event").is_ok());
}

#[test]
fn what_is_heard_can_be_answered_by_a_change_at_once() {
    let rest =
        "[message.Button]\nsend = \"on_change\"\n[signal.Level]\nexpression = \"Lamp.On * 7\"\n";
    let mut device = device(DBC, rest);
    assert_eq!(sent(&mut device, 0.5), []);
    let layout = device.description().layout().clone();
    let Ok(Transmit::Frame(lamp)) = layout.encode(layout.find("Lamp").unwrap(), &[1.0]) else {
        panic!("on CAN")
    };
    device.receive_frame(at(0.5033), &lamp);
    assert!(matches!(device.transmit(), Some(Transmit::Frame(frame)) if frame.data() == [0, 7]));
    assert_eq!(sent(&mut device, 1.0), []);
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (keys, expected) in [
        ("send = \"on_change\"\nperiod_s = 1", "is sent `on_change`, and has no period"),
        ("send = \"cyclic\"", "`Button` is cyclic, and has no period"),
        ("period_s = 1\nmin_delay_s = 1", "`Button` is not sent on a change"),
        ("send = \"on_event\"\nfast_times = 2", "it is not said when"),
        ("send = \"on_event\"\nfast_period_s = 2", "a fast period without an end"),
        ("send = \"on_chnage\"", "unknown name `on_chnage`"),
    ] {
        let error = parsed(DBC, &format!("[message.Button]\n{keys}\n")).expect_err(keys);
        assert!(error.message().contains(expected), "{error}");
    }
    let error = parsed(DBC, "[message.Lamp]\nsend = \"on_evnet\"").expect_err("misspelt");
    assert_eq!(error.advice(), Some("did you mean `on_event`?"));
}
