//! What encoding and decoding cost, per sample.
//!
//! A 16-hour stream at 100 Hz holds 5.76 million samples.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use wire::gyro::{
    GyroDecoder, GyroEncoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream,
    OutputMode, Sequence,
};
use wire::units::{AngularRate, Temperature};

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
    // A decoder for the whole run: the frames of one pass go on where the last pass ended.
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

criterion_group!(gyros, navigator, ecore2000, dsp3000_ascii, dsp3000_binary);
criterion_main!(gyros);
