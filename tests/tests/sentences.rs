//! Lines of text with a checksum, struck by faults: a compass that speaks NMEA 0183.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use tests::project;

const COMPASS: &str = r#"
name = "compass"
title = "A compass"
[serial]
baud = 4800
[signal.Heading]
expression = "45 + t"
[[message]]
name = "Sentence"
sent_by = "device"
text = "$HEHDT,{Heading:.1},T*{checksum}\r\n"
checksum = "xor8"
checksum_between = ["$", "*"]
fields = [{ name = "Heading", unit = "deg", minimum = 0, maximum = 360 }]
period_s = 0.1
"#;

const PLAN: &str = r#"
name = "plan"
title = "Twenty seconds"
device = "compass"
steps = [{ wait = { duration_s = 20 } }]
[[measurement]]
name = "heading"
doc = "As it turns"
quantity = "signal.Heading"
unit = "deg"
check = { all_within = [45, 65] }
"#;

/// The number of headings heard, the largest of them, and the notes of the run. Each takes 40 ms on the line, so that the last
/// one is still on its way.
fn heard(fault: &str) -> (u64, f64, String) {
    let folder = project::of([
        ("devices/compass.toml", COMPASS.to_owned()),
        ("plan.toml", format!("{PLAN}{fault}")),
    ]);
    let trial = project::load(&folder, "plan.toml");
    let run = trial.unwrap_or_else(|error| panic!("{}", project::why(&error))).run().unwrap();
    let heading = run.measurement("heading").unwrap();
    (heading.observations, heading.value.unwrap(), run.summary().notes.join("\n"))
}

fn fault(target: &str, what: &str) -> String {
    format!("[[fault]]\ntarget = \"{target}\"\nwhat = {{ {what} }}\nwhen = {{ at_s = 10.05 }}\n")
}

#[test]
fn a_wrong_checksum_makes_a_sentence_unread() {
    let (all, _, notes) = heard("");
    assert_eq!((all, notes.as_str()), (199, ""));
    let wrong = fault("device.Sentence", "wrong_checksum = { wrong_percent = 100 }");
    let (half, _, notes) = heard(&wrong);
    assert_eq!(half, 100);
    assert!(notes.contains("device.Sentence had a wrong checksum, and did not count"), "{notes}");
}

/// The receiver sees a sound sentence with another heading.
#[test]
fn a_signal_that_is_changed_has_a_new_checksum() {
    let changed = fault("device.Heading", "signal_value = { value = 350 }");
    let (all, largest, notes) = heard(&changed);
    assert_eq!((all, largest, notes.as_str()), (199, 350.0, ""));
}

/// Of sentences with a changed character none is read.
#[test]
fn what_is_changed_on_its_way_is_found() {
    let (all, largest, _) = heard(&fault("device", "flip = { flip_percent = 2 }"));
    assert!((110..190).contains(&all), "{all}");
    assert!(largest < 65.1, "{largest}");
}
