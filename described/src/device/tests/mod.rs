//! Behaviour of a described device.

mod arrays;
mod bounds;
mod machines;
mod occasions;
mod oven;
mod protected;
mod requests;
mod sensor;
mod values;

use super::Device;
use crate::{Decoded, Description, Layout};
use std::sync::Arc;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

const OVEN: &str = include_str!("../../../tests/data/oven.toml");
const DBC: &str = include_str!("../../../tests/data/oven.dbc");

fn parse(text: &str) -> Arc<Description> {
    let read = &mut |name: &str| match name {
        "oven.dbc" => Ok(DBC.to_owned()),
        "trace.csv" => Ok("t_s, temp\n0, 10\n1, 20\n3, 40\n".to_owned()),
        other => Err(format!("no file {other} in this test")),
    };
    let found = Description::parse("test.toml", text, read);
    Arc::new(found.unwrap_or_else(|error| panic!("{}: {error}", error.file())))
}

fn oven() -> Arc<Description> {
    parse(OVEN)
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::from_secs_f64(seconds)
}

/// Everything that the device sends up to and including `until`, woken on request.
fn run(device: &mut Device, until: f64) -> Vec<(Timestamp, Transmit)> {
    let mut sent = Vec::new();
    while device.next_wakeup() <= at(until) {
        let now = device.next_wakeup();
        device.wake(now);
        assert!(device.next_wakeup() > now, "it asks for what is past");
        while let Some(wired) = device.transmit() {
            sent.push((now, wired));
        }
    }
    device.wake(at(until));
    sent
}

fn command(layout: &Layout, setpoint: f64, enable: f64) -> CanFrame {
    let index = layout.find("Command").unwrap();
    match layout.encode(index, &[setpoint, enable]).unwrap() {
        Transmit::Frame(frame) => frame,
        Transmit::Bytes(_) => panic!("on CAN"),
    }
}

fn values(layout: &Layout, wired: &Transmit) -> (usize, Vec<f64>) {
    let mut decoder = layout.decoder();
    let read = |decoded: Decoded<'_>| {
        (decoded.message, decoded.values.iter().map(|v| v.unwrap_or(f64::NAN)).collect())
    };
    let mut found = None;
    match wired {
        Transmit::Frame(frame) => found = decoder.frame(frame).map(read),
        Transmit::Bytes(packet) => {
            decoder.bytes(packet.as_slice(), &mut |decoded| found = Some(read(decoded)));
        }
    }
    found.unwrap()
}

/// Sent messages as text: time in nanoseconds, message, values.
fn listed(layout: &Layout, sent: &[(Timestamp, Transmit)]) -> Vec<String> {
    sent.iter()
        .map(|(at, wired)| {
            let (message, values) = values(layout, wired);
            format!("{} {} {values:?}", at.as_secs_f64(), layout.messages()[message].name)
        })
        .collect()
}

/// A device whose signal `x` shows an expression, preceded by a state or two.
fn showing(rest: &str) -> Arc<Description> {
    parse(&format!(
        "name = \"d\"\n{rest}\n[[message]]\nname = \"M\"\nsent_by = \"device\"\ncan_id = 1\n\
         period_s = 0.1\nfields = [{{ name = \"x\", type = \"f64\" }}]\n\
         [[message]]\nname = \"H\"\nsent_by = \"host\"\ncan_id = 2\ntimeout_s = 1\n\
         initial = {{ u = 5 }}\nfields = [{{ name = \"u\", type = \"u8\" }}]\n"
    ))
}
