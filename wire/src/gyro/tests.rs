//! Properties that hold for every format.

use super::test_support::decoded;
use super::{
    Counters, GyroDecoder, GyroEncoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream,
    OutputMode, Sequence, dsp3000_ascii, dsp3000_binary, quantised,
};
use crate::units::{Angle, AngularRate, Temperature};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use std::vec::Vec;

const MODES: [OutputMode; 3] = [OutputMode::Rate, OutputMode::Increment, OutputMode::Integrated];

/// Number of frames at the start of a stream that serve only to acquire lock.
fn frames_to_lock(format: GyroFormat) -> usize {
    match format {
        GyroFormat::Dsp3000Binary => usize::from(dsp3000_binary::LOCK_FRAMES) - 1,
        _ => 0,
    }
}

fn frame_bytes(format: GyroFormat) -> u64 {
    match format {
        GyroFormat::Navigator | GyroFormat::Ecore2000 => 8,
        GyroFormat::Dsp3000Ascii => dsp3000_ascii::LINE_BYTES as u64,
        GyroFormat::Dsp3000Binary => dsp3000_binary::FRAME_BYTES as u64,
    }
}

/// Half a step on the wire, plus a margin for rounding of doubles.
fn half_step(stream: GyroStream) -> f64 {
    let step = match (stream.format, stream.mode) {
        (format, OutputMode::Rate) => format.facts().rate_step.rad_per_s(),
        (GyroFormat::Dsp3000Ascii, _) => dsp3000_ascii::ANGLE_STEP.rad(),
        (_, _) => dsp3000_binary::ANGLE_STEP.rad(),
    };
    0.5 * step * (1.0 + 1e-6)
}

fn streams() -> impl Strategy<Value = GyroStream> {
    (select(&GyroFormat::ALL[..]), select(&MODES[..]), any::<bool>())
        .prop_map(|(format, mode, reversed)| GyroStream { format, mode, reversed })
        .prop_filter("carried", |stream| stream.format.carries(stream.mode))
}

/// Outputs that every format carries without clipping.
fn output(mode: OutputMode, of_range: f64) -> GyroOutput {
    match mode {
        OutputMode::Rate => GyroOutput::Rate(AngularRate::from_deg_per_s(59.9 * of_range)),
        OutputMode::Increment => GyroOutput::Increment(Angle::from_deg(59.9 * of_range)),
        OutputMode::Integrated => GyroOutput::Integrated(Angle::from_deg(359.9 * of_range)),
    }
}

prop_compose! {
    fn samples(mode: OutputMode, count: core::ops::Range<usize>)(
        first in any::<u8>(),
        fields in prop::collection::vec(
            (-1.0f64..1.0, any::<(bool, bool, bool)>(), prop::option::of(-40.0f64..80.0)),
            count,
        ),
    ) -> Vec<GyroSample> {
        let sample = |(index, (of_range, (failed, warming_up, over_range), celsius)): (usize, _)| {
            let celsius: Option<f64> = celsius;
            GyroSample {
                output: output(mode, of_range),
                valid: true,
                status: GyroStatus { built_in_test_failed: failed, warming_up, over_range },
                temperature: celsius.map(Temperature::from_celsius),
                sequence: Some(Sequence { value: first.wrapping_add(index as u8), modulus: 256 }),
            }
        };
        fields.into_iter().enumerate().map(sample).collect()
    }
}

fn stream_and_samples(
    count: core::ops::Range<usize>,
) -> impl Strategy<Value = (GyroStream, Vec<GyroSample>)> {
    streams().prop_flat_map(move |stream| (Just(stream), samples(stream.mode, count.clone())))
}

fn encoded(stream: GyroStream, samples: &[GyroSample]) -> Vec<u8> {
    let encoder = GyroEncoder::new(stream);
    samples.iter().flat_map(|sample| encoder.encode(sample).as_slice().to_vec()).collect()
}

/// Feeds `bytes` in pieces that end at `cuts`.
fn fed(stream: GyroStream, bytes: &[u8], cuts: &[Index]) -> (Vec<GyroSample>, GyroDecoder) {
    let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
    cuts.push(bytes.len());
    cuts.sort_unstable();
    let mut decoder = GyroDecoder::new(stream);
    let mut samples = Vec::new();
    let mut start = 0;
    for end in cuts {
        decoder.feed(&bytes[start..end], |sample| samples.push(sample));
        start = end;
    }
    (samples, decoder)
}

/// Distance of two outputs of one kind, in SI; angles since reset modulo one turn.
fn difference(a: GyroOutput, b: GyroOutput) -> f64 {
    match (a, b) {
        (GyroOutput::Rate(a), GyroOutput::Rate(b)) => (a - b).rad_per_s().abs(),
        (GyroOutput::Increment(a), GyroOutput::Increment(b)) => (a - b).rad().abs(),
        (GyroOutput::Integrated(a), GyroOutput::Integrated(b)) => (a - b).wrapped().rad().abs(),
        _ => f64::INFINITY,
    }
}

/// Garbage of several kinds: noise, text, and pieces of good frames.
fn garbage(stream: GyroStream) -> impl Strategy<Value = Vec<u8>> {
    let frames = samples(stream.mode, 0..20).prop_map(move |samples| encoded(stream, &samples));
    let piece = (frames, any::<Index>(), any::<Index>()).prop_map(|(bytes, from, to)| {
        let (from, to) = (from.index(bytes.len() + 1), to.index(bytes.len() + 1));
        bytes[from.min(to)..from.max(to)].to_vec()
    });
    let text = prop::collection::vec(select(&b" -.0123456789\r\n"[..]), 0..60);
    let noise = prop::collection::vec(any::<u8>(), 0..200);
    prop::collection::vec(prop_oneof![piece, text, noise], 0..5).prop_map(|parts| parts.concat())
}

/// Ranges of 16 bits, 26 bits and an `i32`.
const BOUNDS: [(i32, i32); 3] =
    [(-32_768, 32_767), (-33_554_432, 33_554_431), (i32::MIN, i32::MAX)];

proptest! {
    #[test]
    fn steps_are_rounded_to_the_nearest_and_clipped(
        steps in prop_oneof![
            any::<f64>(),
            -4e4f64..4e4,
            // Half of them are ties.
            (-80_000i32..80_000).prop_map(|halves| f64::from(halves) / 2.0),
        ],
        (lowest, highest) in select(&BOUNDS[..]),
    ) {
        // The conversion saturates.
        let nearest = (libm::rint(steps) as i32).clamp(lowest, highest);
        prop_assert_eq!(quantised(steps, lowest, highest), (!steps.is_nan()).then_some(nearest));
    }
}

proptest! {
    #[test]
    fn samples_come_back_within_half_a_step((stream, sent) in stream_and_samples(10..30)) {
        let (received, _) = fed(stream, &encoded(stream, &sent), &[]);
        let sent = &sent[frames_to_lock(stream.format)..];
        prop_assert_eq!(received.len(), sent.len());
        for (sent, received) in sent.iter().zip(&received) {
            prop_assert!(difference(sent.output, received.output) <= half_step(stream));
            prop_assert!(received.valid);
            if stream.format == GyroFormat::Navigator {
                prop_assert_eq!(received.status, sent.status);
                prop_assert_eq!(received.sequence, sent.sequence);
                let celsius = |sample: &GyroSample| sample.temperature.map(Temperature::celsius);
                match (celsius(sent), celsius(received)) {
                    (None, None) => {}
                    (Some(a), Some(b)) => prop_assert!((a - b).abs() <= 0.005 + 1e-9),
                    other => prop_assert!(false, "{other:?}"),
                }
            }
        }
    }

    #[test]
    fn what_was_decoded_encodes_to_the_same_bytes((stream, sent) in stream_and_samples(10..30)) {
        let bytes = encoded(stream, &sent);
        let (received, _) = fed(stream, &bytes, &[]);
        let skipped = frames_to_lock(stream.format) * frame_bytes(stream.format) as usize;
        prop_assert_eq!(encoded(stream, &received), &bytes[skipped..]);
    }

    #[test]
    fn any_bytes_in_any_division_give_the_same_samples(
        (stream, bytes) in streams().prop_flat_map(|stream| (Just(stream), garbage(stream))),
        cuts in prop::collection::vec(any::<Index>(), 0..20),
    ) {
        let (whole, one) = fed(stream, &bytes, &[]);
        let (divided, other) = fed(stream, &bytes, &cuts);
        prop_assert_eq!(whole, divided);
        prop_assert_eq!(one.counters(), other.counters());
        prop_assert_eq!(one.bytes_pending(), other.bytes_pending());
    }

    #[test]
    fn every_byte_is_accounted_for(
        (stream, bytes) in streams().prop_flat_map(|stream| (Just(stream), garbage(stream))),
    ) {
        let (samples, decoder) = fed(stream, &bytes, &[]);
        let Counters { frames, bytes_discarded, .. } = decoder.counters();
        prop_assert_eq!(frames, samples.len() as u64);
        let in_frames = frames * frame_bytes(stream.format);
        let pending = decoder.bytes_pending() as u64;
        prop_assert_eq!(in_frames + bytes_discarded + pending, bytes.len() as u64);
        prop_assert!(pending <= frame_bytes(stream.format));
    }

    #[test]
    fn a_good_frame_follows_any_garbage_in_time(
        (stream, garbage, sent) in streams().prop_flat_map(|stream| {
            (Just(stream), garbage(stream), samples(stream.mode, 30..31))
        }),
    ) {
        let bytes = encoded(stream, &sent);
        let in_time = &bytes[..stream.format.facts().resync_bytes_max];
        let mut decoder = fed(stream, &garbage, &[]).1;
        let mut received = Vec::new();
        decoder.feed(in_time, |sample| received.push(sample));
        let good = |received: &GyroSample| {
            let again = encoded(stream, &[*received]);
            bytes.chunks(again.len()).any(|frame| frame == again)
        };
        prop_assert!(received.iter().any(good), "{received:?}");
    }

    #[test]
    fn a_reversed_gyro_only_changes_the_sign((stream, sent) in stream_and_samples(10..20)) {
        let forward = GyroStream { reversed: false, ..stream };
        let backward = GyroStream { reversed: true, ..stream };
        let (as_sent, _) = fed(forward, &encoded(forward, &sent), &[]);
        let (mirrored, _) = fed(forward, &encoded(backward, &sent), &[]);
        prop_assert_eq!(as_sent.len(), mirrored.len());
        for (a, b) in as_sent.iter().zip(&mirrored) {
            prop_assert!(difference(super::negated(a.output), b.output) <= 2.0 * half_step(stream));
        }
    }

    #[test]
    fn lost_samples_show_in_the_sequence_across_its_end(
        value: u8,
        lost in 0u16..600,
        modulus in 2u16..=256,
    ) {
        let earlier = Sequence { value: (u16::from(value) % modulus) as u8, modulus };
        let later = (u16::from(earlier.value) + 1 + lost) % modulus;
        let later = Sequence { value: later as u8, modulus };
        prop_assert_eq!(later.lost_since(earlier), lost % modulus);
    }

    #[test]
    fn no_sequence_at_all_panics(a: u8, b: u8, modulus: u16) {
        let _ = Sequence { value: a, modulus }.lost_since(Sequence { value: b, modulus: 1 });
    }
}

#[test]
fn a_sample_that_is_no_number_is_not_valid_where_that_can_be_said() {
    for mode in MODES {
        let nan = match mode {
            OutputMode::Rate => GyroOutput::Rate(AngularRate::from_rad_per_s(f64::NAN)),
            OutputMode::Increment => GyroOutput::Increment(Angle::from_rad(f64::NAN)),
            OutputMode::Integrated => GyroOutput::Integrated(Angle::from_rad(f64::NAN)),
        };
        for format in [GyroFormat::Dsp3000Ascii, GyroFormat::Dsp3000Binary] {
            let stream = GyroStream { format, mode, reversed: false };
            let sent: Vec<GyroSample> = (0..10)
                .map(|value| GyroSample {
                    output: nan,
                    sequence: Some(Sequence { value, modulus: 4 }),
                    ..super::test_support::rate_sample(0.0)
                })
                .collect();
            let received = decoded(format, mode, &encoded(stream, &sent));
            let last = received.last().expect("ten frames make lock in every format");
            assert!(!last.valid);
            assert_eq!(last.output, output(mode, 0.0));
        }
    }
}
