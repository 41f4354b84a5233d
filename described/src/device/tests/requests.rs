//! Answers of several messages, answers that depend on the question, and questions that arrive during an answer.

use super::{at, parse, run};
use crate::device::Device;
use wire::device::Transmit;
use wire::time::Timestamp;

const METER: &str = r#"
name = "meter"
[serial]
baud = 9600
[state."log[1..4]"]
value = "10 * i"
[signal.Index]
expression = "First + part - 1"
[signal.Value]
expression = "log[First + part - 1]"
[signal.Refused]
expression = "First"
[signal.Busy]
expression = 1
[[message]]
name = "Read"
sent_by = "host"
text = "READ {First:.0} {Count:.0}\n"
while_answering = "refuse"
[[message]]
name = "Entry"
sent_by = "device"
text = "{Index:.0}={Value:.0}\n"
answers = "Read"
when = "First >= 1 and First + Count <= 5"
delay_s = 0.01
times = "Count"
every_s = 0.005
[[message]]
name = "Error"
sent_by = "device"
text = "NO {Refused:.0}\n"
answers = "Read"
when = "not (First >= 1 and First + Count <= 5)"
delay_s = 0.001
[[message]]
name = "Occupied"
sent_by = "device"
text = "BUSY {Busy:.0}\n"
answers = "Read"
busy = true
delay_s = 0.002
"#;

/// The device's answers to `told` with their times in milliseconds, and the device.
fn said(text: &str, told: &[(f64, &str)]) -> (Vec<String>, Device) {
    let mut device = Device::new(parse(text), 1);
    let mut sent = Vec::new();
    for (seconds, line) in told {
        sent.extend(run(&mut device, *seconds));
        device.receive_bytes(at(*seconds), line.as_bytes());
        while let Some(wired) = device.transmit() {
            sent.push((at(*seconds), wired));
        }
    }
    sent.extend(run(&mut device, 10.0));
    let line = |(now, wired): &(Timestamp, Transmit)| match wired {
        Transmit::Bytes(line) => {
            format!(
                "{} {}",
                now.as_nanos() / 1_000_000,
                line.as_slice().trim_ascii().escape_ascii()
            )
        }
        Transmit::Frame(_) => panic!("on a serial line"),
    };
    (sent.iter().map(line).collect(), device)
}

#[test]
fn an_answer_of_several_messages_is_that_of_its_question() {
    let (lines, device) =
        said(METER, &[(1.0, "READ 2 3\n"), (2.0, "READ 4 1\n"), (3.0, "READ 4 2\n")]);
    assert_eq!(lines, ["1010 2=20", "1015 3=30", "1020 4=40", "2010 4=40", "3001 NO 4"]);
    assert_eq!((device.refused_busy(), device.not_finite()), (0, 0));
}

#[test]
fn a_question_while_one_is_answered_is_refused() {
    let told = [(1.0, "READ 1 2\n"), (1.012, "READ 3 1\n"), (1.0151, "READ 4 1\n")];
    let (lines, device) = said(METER, &told);
    // A refused question is not used: the second entry still belongs to the first question.
    assert_eq!(lines, ["1010 1=10", "1014 BUSY 1", "1015 2=20", "1025 4=40"]);
    assert_eq!(device.refused_busy(), 1);
}

#[test]
fn questions_wait_in_a_queue_of_a_length() {
    let text = METER.replace("\"refuse\"", "\"queue\"\nqueue = 2");
    assert_ne!(text, METER);
    let told = [(1.0, "READ 1 2\nREAD 9 1\nREAD 3 1\nREAD 4 1\n"), (2.0, "READ 1 1\n")];
    let (lines, device) = said(&text, &told);
    let expected = ["1002 BUSY 1", "1010 1=10", "1015 2=20", "1016 NO 9", "1026 3=30", "2010 1=10"];
    assert_eq!(lines, expected);
    assert_eq!(device.refused_busy(), 1);
    // Without a rule each is answered independently and shows the values received last.
    let text = METER.replace("while_answering = \"refuse\"\n", "").replace("busy = true\n", "");
    let (lines, _) = said(&text, &[(1.0, "READ 1 1\n"), (1.005, "READ 2 1\n")]);
    assert_eq!(lines, ["1002 BUSY 1", "1007 BUSY 1", "1010 2=20", "1015 2=20"]);
}

#[test]
fn without_power_nothing_is_owed() {
    let mut device = Device::new(parse(&METER.replace("\"refuse\"", "\"queue\"")), 1);
    device.receive_bytes(at(1.0), b"READ 1 4\nREAD 1 4\n");
    run(&mut device, 1.011);
    device.power(at(1.012), false);
    device.power(at(1.013), true);
    assert_eq!(run(&mut device, 3.0), []);
    device.receive_bytes(at(3.0), b"READ 1 1\n");
    assert_eq!(run(&mut device, 4.0).len(), 1);
}
