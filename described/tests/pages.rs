//! The documentation pages on described devices: their examples are valid and send the messages shown.

use described::{Description, Device, Outbox, SendKind};
use std::sync::Arc;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

const PAGE: &str = include_str!("../../docs/own-device.md");
const MACHINES: &str = include_str!("../../docs/described-devices.md");
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
    let mut outbox = Outbox::new(layout.clone(), layout.messages()[0].sender, 1);
    let mut sent = |name: &str| {
        let message = layout.find(name).expect("it is in the DBC");
        outbox.send(Timestamp::ZERO, message, &[0.0, 0.0], |_| false).expect("in range");
        match outbox.transmit().expect("one frame") {
            Transmit::Frame(frame) => frame.data().to_vec(),
            Transmit::Bytes(_) => panic!("on CAN"),
        }
    };
    // AUTOSAR's example of profile 1 with a nibble of the data id.
    assert_eq!(sent("CellStatus"), [0x2a, 0x10, 0, 0, 0, 0, 0, 0]);
    let counters: Vec<u8> = (0..16).map(|_| sent("Request")[0]).collect();
    assert_eq!(counters[13..], [13, 14, 0]);
}

#[test]
fn the_example_of_nmea_0183_is_taken() {
    let blocks = PAGE.split("```toml\n").filter_map(|rest| rest.split_once("```"));
    let sentence = blocks.map(|(block, _)| block).find(|block| block.contains("HEHDT"));
    let text = format!("name = \"compass\"\n[serial]\nbaud = 4800\n{}", sentence.expect("TOML"));
    let description = Description::parse("a.toml", &text, &mut |_| Err(String::new()));
    let layout = description.unwrap_or_else(|error| panic!("{error}")).layout().clone();
    let Ok(Transmit::Bytes(line)) = layout.encode(0, &[274.1]) else { panic!("a line") };
    assert_eq!(line.as_slice(), b"$HEHDT,274.1,T*2F\r\n");
}

/// All messages of the device up to `until_ms`: time in ms, identifier, and bytes.
fn said(device: &mut Device, until_ms: i64) -> Vec<(i64, u32, Vec<u8>)> {
    let mut said = Vec::new();
    loop {
        while let Some(Transmit::Frame(frame)) = device.transmit() {
            let wire::can::Id::Standard(id) = frame.id() else { panic!("11 bits") };
            said.push((until_ms, u32::from(id.as_raw()), frame.data().to_vec()));
        }
        let next = device.next_wakeup();
        if next > Timestamp::from_nanos(until_ms * 1_000_000) {
            return said;
        }
        device.wake(next);
    }
}

#[test]
fn the_pack_of_the_page_does_what_the_page_says() {
    let block = MACHINES.split("```").nth(1).and_then(|block| block.strip_prefix("toml"));
    let found = Description::parse("pack.toml", block.expect("TOML"), &mut |_| Err(String::new()));
    let pack = found.unwrap_or_else(|error| panic!("{error}: {:?}", error.range()));
    let layout = pack.layout().clone();
    let frame = |name: &str, values: &[f64]| -> CanFrame {
        match layout.encode(layout.find(name).expect("it is in the file"), values) {
            Ok(Transmit::Frame(frame)) => frame,
            other => panic!("{other:?}"),
        }
    };
    let mut device = Device::new(Arc::new(pack), 1);
    let at = |ms: i64| Timestamp::from_nanos(ms * 1_000_000);
    device.receive_frame(at(5), &frame("Request", &[1.0, 0.0]));
    said(&mut device, 504);
    assert_eq!(device.value("mode"), Some(1.0));
    let told = said(&mut device, 505);
    assert!(told.iter().any(|(_, id, data)| *id == 0x100 && data[0] == 2), "{told:?}");
    for first in [3.0, 1.0, 4.0, 2.0] {
        device.receive_frame(at(600), &frame("Read", &[first, 2.0]));
    }
    let log: Vec<(u32, u8)> = said(&mut device, 700)
        .into_iter()
        .filter(|(_, id, _)| *id > 0x101)
        .map(|(_, id, data)| (id, data[0]))
        .collect();
    // Of four questions two wait and one is refused; the third asks for more entries than there are.
    assert_eq!(log, [(0x103, 1), (0x102, 3), (0x102, 4), (0x102, 1), (0x102, 2)]);
    device.receive_frame(at(700), &frame("Request", &[1.0, 3000.0]));
    said(&mut device, 3_000);
    assert_eq!((device.value("mode"), device.value("trips")), (Some(3.0), Some(1.0)));
    device.receive_frame(at(3_000), &frame("Reset", &[]));
    assert_eq!(device.value("mode"), Some(0.0));
}
