//! Cost of a described device: per decoded or encoded frame, and per second of run time.
//!
//! A full bus of 1 Mbit/s carries about 9,000 frames of eight bytes a second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use described::{Description, Device, Layout, Message};
use std::hint::black_box;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

const SERIAL: &str = r#"
name = "meter"
[serial]
baud = 115200
[[message]]
name = "Status"
sent_by = "device"
start = [0xAA, 0x55]
checksum = "crc16-modbus"
fields = [
  { name = "Temperature", type = "i16", scale = 0.01 },
  { name = "Pressure", type = "u24", order = "big" },
  { name = "Ratio", type = "f32" },
]
"#;

fn codecs(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("described codec");
    group.throughput(Throughput::Elements(1));
    let base = Layout::from_dbc("k2a.dbc", include_str!("../../wire/dbc/k2a.dbc"), "BASE")
        .expect("the shipped file is a layout");
    let motion = base.find("MOTION").expect("it is in the file");
    let values = [12.5, 30.0, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 200.0];
    group.bench_function("encode a frame of nine signals", |bencher| {
        bencher.iter(|| base.encode(motion, black_box(&values)));
    });
    let Ok(Transmit::Frame(frame)) = base.encode(motion, &values) else { panic!("on CAN") };
    let mut decoder = base.decoder();
    group.bench_function("decode a frame of nine signals", |bencher| {
        bencher.iter(|| {
            black_box(decoder.frame(black_box(&frame)));
        });
    });
    let middles = |message: &Message| -> Vec<f64> {
        message.signals.iter().map(|one| f64::midpoint(one.minimum, one.maximum)).collect()
    };
    let each = base.messages().iter().map(middles).enumerate();
    let frames = each.filter_map(|(index, values)| match base.encode(index, &values) {
        Ok(Transmit::Frame(frame)) => Some(frame),
        _ => None,
    });
    let six: Vec<_> = frames.collect();
    group.throughput(Throughput::Elements(six.len() as u64));
    group.bench_function("decode each message of the file", |bencher| {
        bencher.iter(|| {
            for frame in &six {
                black_box(decoder.frame(black_box(frame)));
            }
        });
    });
    group.throughput(Throughput::Elements(1));
    let meter = Description::parse("meter.toml", SERIAL, &mut |_| Err(String::new()))
        .expect("the file is a description");
    let Ok(Transmit::Bytes(packet)) = meter.layout().encode(0, &[20.0, 1000.0, 0.5]) else {
        panic!("on a serial line")
    };
    let mut decoder = meter.layout().decoder();
    group.bench_function("decode a packet with a CRC", |bencher| {
        bencher.iter(|| {
            decoder.bytes(black_box(packet.as_slice()), &mut |decoded| {
                black_box(decoded);
            });
        });
    });
    group.finish();
}

fn device(criterion: &mut Criterion) {
    let read = &mut |_: &str| Ok(include_str!("../tests/data/oven.dbc").to_owned());
    let oven = Description::parse("oven.toml", include_str!("../tests/data/oven.toml"), read)
        .expect("the file is a description");
    let mut device = Device::new(Arc::new(oven), 1);
    let mut now = Timestamp::ZERO;
    // A hundred integration steps and ten messages.
    criterion.bench_function("a second of the oven", |bencher| {
        bencher.iter(|| {
            now += Span::from_secs(1);
            while device.next_wakeup() <= now {
                device.wake(device.next_wakeup());
                while let Some(wired) = device.transmit() {
                    black_box(wired);
                }
            }
        });
    });
}

criterion_group!(benches, codecs, device);
criterion_main!(benches);
