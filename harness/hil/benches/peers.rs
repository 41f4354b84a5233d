//! Frames, decoded messages and round trips, for comparison with other tools.
//!
//! `benchmarks/peers` runs this and the same tasks in python-can, cantools and plain C, and makes a table of all.
//!
//! ```text
//! peers figures FOLDER       frames and messages per second; leaves the messages in FOLDER
//! peers echo pty             makes a pty, prints its far side, sends back what comes
//! peers echo can INTERFACE   the same on a CAN interface
//! ```

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on fails")]

#[path = "../../benches/processor/mod.rs"]
mod processor;

use bus_log::{Channel, Entry, Format, LogWriter, Payload};
use described::Layout;
use ports::{ByteEvent, BytePort, FrameEvent, FramePort, PortSpec};
use processor::{median, processor_s};
use rig::line::EndId;
use rig::link::CanBus;
use std::hint::black_box;
use std::path::Path;
use wire::base::can_link::{parse_reply, parse_request, reply_frame, request_frame};
use wire::base::{Motion, PoseWriteResult, Reply, Request};
use wire::can::BitRates;
use wire::can::{CanFrame, StandardId};
use wire::serial::SerialSettings;
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};

/// Frames that cross the memory bus in one run.
const BUS_FRAMES: u64 = 10_000_000;
/// Frames of each of the six messages, each with different values.
const OF_EACH: u32 = 1_000;
/// Decoding passes in one run.
const PASSES: u64 = 2_000;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["figures", folder] => figures(Path::new(folder)),
        ["echo", "pty"] => run(echo_bytes()),
        ["echo", "can", interface] => run(echo_frames((*interface).to_owned())),
        // `cargo test --benches` and `cargo bench` only check that it starts.
        _ => println!("see benchmarks/peers"),
    }
}

fn figures(folder: &Path) {
    println!("hil memory-bus {:.0}", median(memory_bus));
    let frames = messages();
    let mut log = LogWriter::create(&folder.join("messages.log"), Format::Candump).unwrap();
    for (index, frame) in frames.iter().enumerate() {
        let at = Timestamp::ZERO + Span::from_micros(index as i64);
        let payload = Payload::Frame(*frame);
        let entry = Entry { at, channel: Channel::numbered(0), direction: None, payload };
        let _ = log.write(&entry).unwrap();
    }
    log.finish().unwrap();
    println!("hil messages {:.0}", median(|| decoded(&frames)));
    println!("hil any-dbc {:.0}", median(|| decoded_by_dbc(&frames)));
}

/// Two nodes alternate; each frame arrives before the next is sent.
fn memory_bus() -> f64 {
    let frame = |id| CanFrame::new(StandardId::new(id).unwrap(), &[0x55; 8]).unwrap();
    let frames = [frame(0x101), frame(0x181)];
    let mut bus = CanBus::default();
    let mut now = Timestamp::ZERO;
    let began = processor_s();
    for number in 0..BUS_FRAMES {
        let node = (number % 2) as usize;
        bus.send(now, EndId::of(node), black_box(frames[node]));
        now = bus.next_arrival();
        let (from, frame) = black_box(bus.arrived(now)).unwrap();
        assert_eq!((from, frame.id()), (EndId::of(node), frames[node].id()));
    }
    BUS_FRAMES as f64 / (processor_s() - began)
}

/// A bus listener: decodes each frame, request or reply, to SI units.
fn decoded(frames: &[CanFrame]) -> f64 {
    let began = processor_s();
    for _ in 0..PASSES {
        for frame in frames {
            match parse_request(black_box(frame)) {
                Some(request) => _ = black_box(request),
                None => _ = black_box(parse_reply(frame).unwrap()),
            }
        }
    }
    (PASSES * frames.len() as u64) as f64 / (processor_s() - began)
}

/// The same with the layout read from the DBC file, as for any DBC.
fn decoded_by_dbc(frames: &[CanFrame]) -> f64 {
    let text = include_str!("../../../wire/dbc/k2a.dbc");
    let mut decoder = Layout::from_dbc("k2a.dbc", text, "BASE").unwrap().decoder();
    let began = processor_s();
    for _ in 0..PASSES {
        for frame in frames {
            _ = black_box(decoder.frame(black_box(frame)).unwrap());
        }
    }
    (PASSES * frames.len() as u64) as f64 / (processor_s() - began)
}

/// The six messages of `wire/dbc/k2a.dbc` in turn, over most of their ranges.
fn messages() -> Vec<CanFrame> {
    (0..OF_EACH).flat_map(|index| six(index, f64::from(index) / f64::from(OF_EACH))).collect()
}

fn six(index: u32, part: f64) -> [CanFrame; 6] {
    let count = index as u8;
    let heading = Angle::from_deg(359.0 * part - 179.0);
    let pose = Pose { x: Length::from_m(400.0 * part), y: Length::from_m(-400.0 * part), heading };
    let results = [
        PoseWriteResult::None,
        PoseWriteResult::Accepted,
        PoseWriteResult::RefusedInMotion,
        PoseWriteResult::RefusedValue,
    ];
    let motion = Motion {
        displacement: Length::from_m(10_000.0 * part),
        heading,
        moving: count & 1 != 0,
        command_timed_out: count & 2 != 0,
        emergency_stop: count & 4 != 0,
        fault: count & 8 != 0,
        pose_write: results[usize::from(count % 4)],
        pose_write_counter: count % 4,
        sequence: count,
    };
    let velocity = Request::SetVelocity {
        drive: Speed::from_m_per_s(6.0 * part - 3.0),
        steer: AngularRate::from_deg_per_s(600.0 * part - 300.0),
    };
    let limits = Request::SetAcceleration {
        drive: Acceleration::from_m_per_s2(0.1 + 6.0 * part),
        steer: AngularAcceleration::from_deg_per_s2(1.0 + 600.0 * part),
    };
    let asked = |request| request_frame(&request).unwrap();
    [
        asked(velocity),
        asked(limits),
        asked(Request::WritePose { pose, counter: count % 4 }),
        asked(Request::Stop),
        reply_frame(&Reply::Motion(motion)),
        reply_frame(&Reply::Pose(pose)),
    ]
}

fn run(echo: impl Future<Output = ()>) {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(echo);
}

async fn echo_bytes() {
    let spec = PortSpec::Pty { link: None };
    let mut port = BytePort::open(&spec, SerialSettings::new_8n1(9_600)).unwrap();
    println!("{}", port.far_path().unwrap());
    loop {
        if let ByteEvent::Bytes(packet) = port.receive().await.unwrap() {
            port.send(packet.as_slice());
        }
    }
}

async fn echo_frames(interface: String) {
    let mut port = FramePort::open(&PortSpec::Can { interface }, BitRates::USUAL).await.unwrap();
    println!("{}", port.far_path().unwrap());
    loop {
        if let FrameEvent::Frame(frame) = port.receive().await.unwrap() {
            port.send(Timestamp::ZERO, &frame);
        }
    }
}
