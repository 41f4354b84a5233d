//! A device with more messages than a queue usually holds: all arrive, and those that a line cannot carry are told.

use harness::run::Prepared;
use plan::made::Made;
use record::RecordKind;
use std::collections::BTreeSet;
use tests::plans::Run;
use tests::project;

const MESSAGES: usize = 1_500;

const PLAN: &str = r#"
name = "many"
title = "All messages arrive"
device = "many"
steps = [{ wait = { duration_s = 1 } }]
[[measurement]]
name = "last"
doc = "The last of the bus"
quantity = "signal.S1499"
unit = "1"
check = { all_within = [0, 255] }
"#;

/// Runs a device that sends all its messages at once, and again after each period.
fn run(period_ms: u32) -> Run {
    let mut dbc = String::from("VERSION \"\"\nBU_: MANY TOOL\n");
    for number in 0..MESSAGES {
        dbc += &format!("BO_ {} M{number}: 8 MANY\n", number + 1);
        dbc += &format!(" SG_ S{number} : 0|8@1+ (1,0) [0|255] \"\" TOOL\n");
    }
    dbc += "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n";
    dbc += &format!("BA_DEF_DEF_ \"GenMsgCycleTime\" {period_ms};\n");
    let device = "name = \"many\"\ntitle = \"Many\"\ndbc = \"many.dbc\"\nnode = \"MANY\"\n";
    let files = [("devices/many.dbc", &*dbc), ("devices/many.toml", device), ("many.toml", PLAN)];
    let folder = project::of(files);
    let path = folder.path().join("many.toml");
    let prepared = Prepared::load(&path.to_string_lossy(), &Made::default());
    tests::plans::run(&prepared.unwrap_or_else(|error| panic!("{error:?}")), 1)
}

#[test]
fn all_messages_of_a_device_may_be_due_at_once() {
    let Run { records, simulated } = self::run(800);
    let frame = |record: &record::Record| match &record.kind {
        RecordKind::Frame(frame) => Some(format!("{:?}", frame.id())),
        _ => None,
    };
    let seen: BTreeSet<String> = records.iter().filter_map(frame).collect();
    assert_eq!((seen.len(), simulated.dropped), (MESSAGES, 0));
    assert_eq!(simulated.notes, Vec::<String>::new());
}

#[test]
fn what_a_line_cannot_carry_is_told_in_the_run() {
    // A bus of 500 kbit/s carries 4,000 of these frames a second, and 30,000 are sent.
    let Run { simulated, .. } = self::run(50);
    assert!(simulated.dropped > 10_000, "{}", simulated.dropped);
    let told = |note: &String| note.contains("messages lost on device: ");
    assert!(simulated.notes.iter().any(told), "{:?}", simulated.notes);
}
