//! Sent and received messages with counters and checksums.

use super::{at, run};
use crate::Device;
use crate::layout::Encoder;
use crate::layout::cells;
use std::sync::Arc;
use wire::device::Transmit;

const STATUS: &str = "[message.CellStatus]\nperiod_s = 0.1\n\
    e2e = { profile = \"1C\", data_id = 0x123, counter = \"Alive\", checksum = \"Crc\" }\n";
const REQUEST: &str = "[message.Request]\ncounter = { signal = \"Count\" }\n\
    checksum = { signal = \"Sum\", crc = \"crc8-autosar\" }\n";

fn device(rest: &str) -> Device {
    let description = cells(rest).unwrap_or_else(|error| panic!("{error}"));
    Device::new(Arc::new(description), 1)
}

fn data(sent: &[(wire::time::Timestamp, Transmit)]) -> Vec<Vec<u8>> {
    let data = |wired: &Transmit| match wired {
        Transmit::Frame(frame) => frame.data().to_vec(),
        Transmit::Bytes(packet) => packet.as_slice().to_vec(),
    };
    sent.iter().map(|(_, wired)| data(wired)).collect()
}

#[test]
fn what_a_device_sends_is_counted_and_sealed() {
    let mut device = device(STATUS);
    let sent = data(&run(&mut device, 1.65));
    assert_eq!(sent.len(), 16);
    // The published examples of profile 1.
    assert_eq!(sent[0], [0x2a, 0x10, 0, 0, 0, 0, 0, 0]);
    assert_eq!(sent[1], [0x77, 0x11, 0, 0, 0, 0, 0, 0]);
    // Its counter skips 15.
    assert_eq!(sent[14][1], 0x1e);
    assert_eq!(sent[15], sent[0]);
    device.power(at(2.0), false);
    device.power(at(3.0), true);
    assert_eq!(data(&run(&mut device, 3.15)), [sent[0].clone()]);
}

#[test]
fn an_expression_of_the_counter_stands_and_the_checksum_covers_it() {
    let mut device = device(&format!("{STATUS}[signal.Alive]\nexpression = \"3\"\n"));
    let sent = data(&run(&mut device, 0.25));
    assert_eq!(sent[0][1], 0x13);
    assert_eq!(sent[0], sent[1]);
    let mut decoder = device.description().layout().decoder();
    let frames = run(&mut device, 0.55);
    let verdicts = frames.iter().map(|(_, wired)| match wired {
        Transmit::Frame(frame) => decoder.frame(frame).unwrap().verdict.unwrap(),
        Transmit::Bytes(_) => panic!("on CAN"),
    });
    use crate::Verdict::{Ok, Repeated};
    assert_eq!(verdicts.collect::<Vec<_>>(), [Ok, Repeated, Repeated]);
}

#[test]
fn a_device_does_not_use_what_is_not_right_and_counts_it() {
    let mut device = device(&format!("{STATUS}{REQUEST}"));
    let layout = device.description().layout().clone();
    let request = layout.find("Request").unwrap();
    let mut encoder = Encoder::new(layout);
    let mut hear = |device: &mut Device, limit: f64, own: Option<usize>| {
        let values = [limit, 0.0, 0.0];
        let wired = encoder.encode(request, &values, |signal| own == Some(signal)).unwrap();
        let wired = wired.whole().unwrap();
        let Transmit::Frame(frame) = wired else { panic!("on CAN") };
        device.receive_frame(at(0.01), &frame);
        device.receive_frame(at(0.01), &frame);
        device.value("Limit").unwrap()
    };
    assert!((hear(&mut device, 10.0, None) - 10.0).abs() < 1e-9);
    // Sending the same frame again counted as a repetition.
    assert_eq!(device.refused_messages(), 1);
    // A checksum of 0 is wrong.
    assert!((hear(&mut device, 20.0, Some(2)) - 10.0).abs() < 1e-9);
    assert_eq!(device.refused_messages(), 3);
    assert!((hear(&mut device, 30.0, None) - 30.0).abs() < 1e-9);
    assert_eq!(device.refused_messages(), 4);
}

#[test]
fn a_packet_with_a_wrong_checksum_is_counted_too() {
    let description = super::parse(
        "name = \"meter\"\n[serial]\nbaud = 9600\n[[message]]\nname = \"Set\"\nsent_by = \"host\"\n\
         start = [0xAA]\nchecksum = \"sum8\"\nfields = [{ name = \"Gain\", type = \"u8\" }]\n",
    );
    let mut device = Device::new(description, 1);
    device.receive_bytes(at(0.1), &[0xaa, 7, 7]);
    device.receive_bytes(at(0.2), &[0xaa, 9, 7]);
    assert_eq!((device.value("Gain"), device.refused_messages()), (Some(7.0), 1));
}
