//! Cost of encoding and decoding: per sample of a gyro, per exchange with the base, per line of the table, per frame
//! of an SLCAN adapter, and of computing a frame's length on the bus.
//!
//! A 16-hour stream at 100 Hz holds 5.76 million samples; a full bus of 1 Mbit/s carries about 9,000 frames of eight
//! bytes a second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use wire::base::serial_link::{Device, DeviceEvent, Host, HostEvent};
use wire::base::{Motion, Reply, Request, can_link};
use wire::can::{CanFrame, ExtendedId, FdFlags};
use wire::gyro::{
    GyroDecoder, GyroEncoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream,
    OutputMode, Sequence,
};
use wire::slcan;
use wire::table;
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate, Length, Speed, Temperature};

const SAMPLES: usize = 1_000;

/// A rate that sweeps through +-30 deg/s, numbered, at 25 degC.
fn samples() -> Vec<GyroSample> {
    let sample = |index: usize| {
        let deg_per_s = 30.0 * (index as f64 * 0.01).sin();
        GyroSample {
            output: GyroOutput::Rate(AngularRate::from_deg_per_s(deg_per_s)),
            valid: true,
            status: GyroStatus::default(),
            temperature: Some(Temperature::from_celsius(25.0)),
            sequence: Some(Sequence { value: index as u8, modulus: 256 }),
        }
    };
    (0..SAMPLES).map(sample).collect()
}

fn gyro(criterion: &mut Criterion, name: &str, format: GyroFormat) {
    let stream = GyroStream { format, mode: OutputMode::Rate, reversed: false };
    let encoder = GyroEncoder::new(stream);
    let samples = samples();
    let bytes: Vec<u8> =
        samples.iter().flat_map(|sample| encoder.encode(sample).as_slice().to_vec()).collect();

    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(SAMPLES as u64));
    group.bench_function("encode", |bencher| {
        bencher.iter(|| {
            for sample in &samples {
                black_box(encoder.encode(black_box(sample)));
            }
        });
    });
    // A decoder for the whole run: the frames of one pass continue where the last pass ended.
    let mut decoder = GyroDecoder::new(stream);
    group.bench_function("decode", |bencher| {
        bencher.iter(|| decoder.feed(black_box(&bytes), |sample| _ = black_box(sample)));
    });
    let mut decoder = GyroDecoder::new(stream);
    group.bench_function("encode and decode, frame by frame", |bencher| {
        bencher.iter(|| {
            for sample in &samples {
                let packet = encoder.encode(black_box(sample));
                decoder.feed(packet.as_slice(), |sample| _ = black_box(sample));
            }
        });
    });
    group.finish();
}

fn navigator(criterion: &mut Criterion) {
    gyro(criterion, "gyro/navigator", GyroFormat::Navigator);
}

fn ecore2000(criterion: &mut Criterion) {
    gyro(criterion, "gyro/ecore2000", GyroFormat::Ecore2000);
}

fn dsp3000_ascii(criterion: &mut Criterion) {
    gyro(criterion, "gyro/dsp3000-ascii", GyroFormat::Dsp3000Ascii);
}

fn dsp3000_binary(criterion: &mut Criterion) {
    gyro(criterion, "gyro/dsp3000-binary", GyroFormat::Dsp3000Binary);
}

fn velocity() -> Request {
    Request::SetVelocity {
        drive: Speed::from_m_per_s(0.4),
        steer: AngularRate::from_deg_per_s(-12.5),
    }
}

fn motion() -> Reply {
    Reply::Motion(Motion {
        displacement: Length::from_m(12.3456),
        heading: Angle::from_deg(-89.7),
        moving: true,
        sequence: 42,
        ..Motion::default()
    })
}

/// One frame each way.
fn can(criterion: &mut Criterion) {
    let (request, reply) = (velocity(), motion());
    let request_frame = can_link::request_frame(&request).expect("a velocity has a frame");
    let reply_frame = can_link::reply_frame(&reply);

    let mut group = criterion.benchmark_group("base/can");
    group.throughput(Throughput::Elements(1));
    group.bench_function("encode request", |bencher| {
        bencher.iter(|| can_link::request_frame(black_box(&request)));
    });
    group.bench_function("parse request", |bencher| {
        bencher.iter(|| can_link::parse_request(black_box(&request_frame)));
    });
    group.bench_function("encode reply", |bencher| {
        bencher.iter(|| can_link::reply_frame(black_box(&reply)));
    });
    group.bench_function("parse reply", |bencher| {
        bencher.iter(|| can_link::parse_reply(black_box(&reply_frame)));
    });
    group.finish();
}

/// One exchange, both ends.
fn serial(criterion: &mut Criterion) {
    let reply = motion();
    let (mut host, mut device) = (Host::default(), Device::default());

    let mut group = criterion.benchmark_group("base/serial");
    group.throughput(Throughput::Elements(1));
    group.bench_function("read exchange", |bencher| {
        bencher.iter(|| {
            let line = host.start(black_box(&Request::ReadMotion)).expect("the host is idle");
            let mut answer = None;
            device.feed(line.as_slice(), |event| {
                if let DeviceEvent::Read(read) = event {
                    answer = read.packet(black_box(&reply));
                }
            });
            let answer = answer.expect("the line was a read");
            let mut read = None;
            host.feed(answer.as_slice(), |event| read = Some(event));
            debug_assert!(matches!(read, Some(HostEvent::Reply(_))));
            read
        });
    });
    group.finish();
}

/// One line each way, through the stream decoders.
fn lines(criterion: &mut Criterion) {
    let command = table::Command::Distance(-28_800);
    let answer = table::Answer::State { position_steps: -28_800, moving: true };
    let (command_line, answer_line) = (command.encode(), answer.encode());

    let mut group = criterion.benchmark_group("table/line");
    group.throughput(Throughput::Elements(1));
    group.bench_function("encode command", |bencher| {
        bencher.iter(|| black_box(command).encode());
    });
    let mut commands = table::CommandDecoder::default();
    group.bench_function("decode command", |bencher| {
        bencher.iter(|| {
            commands.feed(black_box(command_line.as_slice()), |command| _ = black_box(command));
        });
    });
    group.bench_function("encode answer", |bencher| {
        bencher.iter(|| black_box(answer).encode());
    });
    let mut answers = table::AnswerDecoder::default();
    group.bench_function("decode answer", |bencher| {
        bencher.iter(|| {
            answers.feed(black_box(answer_line.as_slice()), |answer| _ = black_box(answer));
        });
    });
    group.finish();
}

/// Length of a frame on its bus, stuff bits included: classic with eight bytes, and FD with 64.
fn lengths(criterion: &mut Criterion) {
    let id = ExtendedId::new(0x1ABC_0123).expect("29 bits");
    let bytes: [u8; 64] = std::array::from_fn(|place| (place * place) as u8);
    let classic = CanFrame::new(id, &bytes[..8]).expect("eight bytes");
    let flags = FdFlags { bit_rate_switch: true, error_state: false };
    let fd = CanFrame::fd(id, flags, &bytes).expect("64 bytes");
    let mut group = criterion.benchmark_group("can/bits");
    group.throughput(Throughput::Elements(1));
    for (name, frame) in [("classic, 8 bytes", classic), ("FD, 64 bytes", fd)] {
        group.bench_function(name, |bencher| bencher.iter(|| black_box(&frame).bits()));
    }
    group.finish();
}

/// Extended frames of eight bytes with a timestamp: the longest lines.
fn adapter(criterion: &mut Criterion) {
    const FRAMES: usize = 100;
    let frame = |index: usize| {
        let id = ExtendedId::new(0x1ABC_0000 + index as u32).expect("29 bits");
        CanFrame::full(id, [index as u8; 8])
    };
    let answers: Vec<_> = (0..FRAMES)
        .map(|index| {
            let timestamp_ms = Some(index as u16);
            slcan::Answer::Frame(slcan::ReceivedFrame { frame: frame(index), timestamp_ms })
        })
        .collect();
    let join = |packets: Vec<wire::packet::Packet>| -> Vec<u8> {
        packets.iter().flat_map(|packet| packet.as_slice().to_vec()).collect()
    };
    let from_adapter = join(answers.iter().map(slcan::Answer::encode).collect());
    let from_host =
        join((0..FRAMES).map(|index| slcan::Command::Transmit(frame(index)).encode()).collect());

    let mut group = criterion.benchmark_group("slcan/frame");
    group.throughput(Throughput::Elements(FRAMES as u64));
    group.bench_function("encode", |bencher| {
        bencher.iter(|| {
            for answer in &answers {
                black_box(black_box(answer).encode());
            }
        });
    });
    let mut decoder = slcan::AnswerDecoder::default();
    group.bench_function("decode", |bencher| {
        bencher.iter(|| decoder.feed(black_box(&from_adapter), |answer| _ = black_box(answer)));
    });
    let mut adapter = slcan::Adapter::default();
    adapter.receive(b"S8\rO\r", |_| Ok(()));
    group.bench_function("through an adapter, to the bus", |bencher| {
        bencher.iter(|| {
            // Line by line: its queue of acknowledgements is short.
            for line in black_box(&from_host).chunks(from_host.len() / FRAMES) {
                adapter.receive(line, |frame| {
                    black_box(frame);
                    Ok(())
                });
                while let Some(packet) = adapter.transmit() {
                    black_box(packet);
                }
            }
        });
    });
    group.bench_function("through an adapter, from the bus", |bencher| {
        bencher.iter(|| {
            for index in 0..FRAMES {
                adapter.receive_frame(Timestamp::ZERO, black_box(frame(index)));
                black_box(adapter.transmit());
            }
        });
    });
    group.finish();
}

criterion_group!(gyros, navigator, ecore2000, dsp3000_ascii, dsp3000_binary);
criterion_group!(base, can, serial);
criterion_group!(tables, lines);
criterion_group!(adapters, adapter, lengths);
criterion_main!(gyros, base, tables, adapters);
