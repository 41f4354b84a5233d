//! The page on devices of one's own: what it writes of counters and checksums is taken, and the messages are sent so.

use described::{Description, Encoder, SendKind};
use wire::device::Transmit;

const PAGE: &str = include_str!("../../docs/own-device.md");
const DBC: &str = r#"VERSION ""

BU_: Cells Manager

BO_ 256 CellStatus: 8 Cells
 SG_ Crc : 0|8@1+ (1,0) [0|255] "" Manager
 SG_ Alive : 8|4@1+ (1,0) [0|14] "" Manager

BO_ 512 Request: 4 Manager
 SG_ Alive : 0|8@1+ (1,0) [0|255] "" Cells
 SG_ Crc : 24|8@1+ (1,0) [0|255] "" Cells
"#;

#[test]
fn the_example_of_what_is_sent_on_a_change_is_taken() {
    let section = PAGE.split_once("## Sent on a change").expect("the section").1;
    let block = section.split("```").nth(1).and_then(|block| block.strip_prefix("toml"));
    let text = format!("name = \"a\"\ndbc = \"a.dbc\"\nnode = \"Cells\"\n{}", block.expect("TOML"));
    let dbc = DBC.replace("CellStatus", "Button");
    let description = Description::parse("a.toml", &text, &mut |_| Ok(dbc.clone()));
    let layout = description.unwrap_or_else(|error| panic!("{error}")).layout().clone();
    let rule = &layout.messages()[layout.find("Button").expect("it is in the DBC")].send;
    assert_eq!(rule.kind, SendKind::CyclicAndOnChange);
    assert_eq!(rule.fast.map(|(_, times)| times), Some(3));
}

#[test]
fn the_example_of_counters_and_checksums_is_taken() {
    let section = PAGE.split_once("## Counters and checksums").expect("the section").1;
    let block = section.split("```").nth(1).and_then(|block| block.strip_prefix("toml"));
    let text = format!("name = \"a\"\ndbc = \"a.dbc\"\nnode = \"Cells\"\n{}", block.expect("TOML"));
    let description = Description::parse("a.toml", &text, &mut |_| Ok(DBC.to_owned()));
    let layout = description.unwrap_or_else(|error| panic!("{error}")).layout().clone();
    let mut encoder = Encoder::new(layout.clone());
    let mut sent = |name: &str| {
        let message = layout.find(name).expect("it is in the DBC");
        match encoder.encode(message, &[0.0, 0.0], |_| false).expect("in range") {
            Transmit::Frame(frame) => frame.data().to_vec(),
            Transmit::Bytes(_) => panic!("on CAN"),
        }
    };
    // AUTOSAR's example of profile 1 with a nibble of the data id.
    assert_eq!(sent("CellStatus"), [0x2a, 0x10, 0, 0, 0, 0, 0, 0]);
    let counters: Vec<u8> = (0..16).map(|_| sent("Request")[0]).collect();
    assert_eq!(counters[13..], [13, 14, 0]);
}
