use super::super::OutputMode;
use super::super::test_support::{hex_table, rate_sample};
use super::{Decoder, FRAME_BYTES, LOCK_FRAMES, encode};
use crate::gyro::{GyroOutput, GyroSample, Sequence};
use crate::units::{Angle, AngularRate};
use insta::assert_snapshot;
use proptest::prelude::*;
use std::vec::Vec;

const LOCK: usize = LOCK_FRAMES as usize;

fn numbered(index: usize, output: GyroOutput) -> GyroSample {
    let sequence = Sequence { value: (index % 4) as u8, modulus: 4 };
    GyroSample { output, sequence: Some(sequence), ..rate_sample(0.0) }
}

fn rates(deg_per_s: &[f64]) -> Vec<u8> {
    let numbered = |(index, &rate)| {
        encode(&numbered(index, GyroOutput::Rate(AngularRate::from_deg_per_s(rate))))
    };
    deg_per_s.iter().enumerate().map(numbered).flat_map(|p| p.as_slice().to_vec()).collect()
}

/// `count` frames of slowly growing rate.
fn ramp(count: usize) -> Vec<u8> {
    rates(&(0..count).map(|i| 0.01 * i as f64).collect::<Vec<_>>())
}

fn delivered(decoder: &mut Decoder, bytes: &[u8]) -> Vec<GyroSample> {
    let mut samples = Vec::new();
    decoder.feed(bytes, &mut |sample| samples.push(sample));
    samples
}

#[test]
fn known_frames() {
    // +30 deg/s by hand: 500,000 steps = 0x007a120 with seven ones; with the valid bit eight, so that the parity bit
    // is set.
    let sequence = |value| Some(Sequence { value, modulus: 256 });
    let angle = |deg| GyroSample {
        output: GyroOutput::Integrated(Angle::from_deg(deg)),
        ..rate_sample(0.0)
    };
    assert_snapshot!(hex_table(encode, &[
        ("0 deg/s", rate_sample(0.0)),
        ("+30 deg/s", rate_sample(30.0)),
        ("-30 deg/s", rate_sample(-30.0)),
        ("number 5 of 256", GyroSample { sequence: sequence(5), ..rate_sample(0.0) }),
        ("270 deg", angle(270.0)),
        ("clipped", rate_sample(1e9)),
        ("not a number", rate_sample(f64::NAN)),
    ]), @r"
    0 deg/s               80 00 00 00
    +30 deg/s             84 07 a1 20
    -30 deg/s             87 f8 5e e0
    number 5 of 256       a4 00 00 00
    270 deg               93 1b 1e 40
    clipped               85 ff ff ff
    not a number          04 00 00 00
    ");
}

#[test]
fn the_tenth_good_frame_locks_and_is_delivered() {
    let mut decoder = Decoder::new(OutputMode::Rate);
    let bytes = ramp(LOCK + 3);
    assert!(delivered(&mut decoder, &bytes[..LOCK * FRAME_BYTES - 1]).is_empty());
    assert_eq!(delivered(&mut decoder, &bytes[LOCK * FRAME_BYTES - 1..]).len(), 4);
    let counters = decoder.counters();
    assert_eq!((counters.frames, counters.resyncs), (4, 0));
    assert_eq!(counters.bytes_discarded, 9 * 4);
}

#[test]
fn one_miss_loses_lock_until_ten_more_are_good() {
    let mut decoder = Decoder::new(OutputMode::Rate);
    let mut bytes = ramp(40);
    bytes[20 * FRAME_BYTES + 2] ^= 1;
    assert_eq!(delivered(&mut decoder, &bytes).len(), (20 - 9) + (19 - 9));
    let counters = decoder.counters();
    assert_eq!((counters.checksum_errors, counters.resyncs), (1, 1));
}

#[test]
fn a_lost_frame_shows_in_the_counter() {
    let mut decoder = Decoder::new(OutputMode::Rate);
    let mut bytes = ramp(40);
    bytes.drain(20 * FRAME_BYTES..21 * FRAME_BYTES);
    // The frame after the gap is the first of the ten.
    assert_eq!(delivered(&mut decoder, &bytes).len(), (20 - 9) + (19 - 9));
    let counters = decoder.counters();
    assert_eq!((counters.checksum_errors, counters.resyncs), (0, 1));
}

#[test]
fn a_rate_that_never_changes_is_found_at_the_right_offset() {
    let bytes = rates(&[0.0; 40]);
    for cut in 0..FRAME_BYTES {
        let samples = delivered(&mut Decoder::new(OutputMode::Rate), &bytes[cut..]);
        assert_eq!(samples.len(), 40 - 9 - usize::from(cut > 0));
        assert!(samples.iter().all(|s| s.output == GyroOutput::Rate(AngularRate::ZERO)));
    }
}

#[test]
fn a_type_that_is_not_defined_is_malformed_and_keeps_lock() {
    let mut decoder = Decoder::new(OutputMode::Rate);
    let mut bytes = ramp(30);
    // Both type bits: an even change, which parity cannot see.
    bytes[20 * FRAME_BYTES] ^= 0b0001_1000;
    assert_eq!(delivered(&mut decoder, &bytes).len(), 30 - 9 - 1);
    let counters = decoder.counters();
    assert_eq!((counters.malformed, counters.checksum_errors, counters.resyncs), (1, 0, 0));
}

#[test]
fn without_numbers_there_is_no_lock() {
    let frame = encode(&rate_sample(1.0));
    let mut decoder = Decoder::new(OutputMode::Rate);
    for _ in 0..100 {
        assert!(delivered(&mut decoder, frame.as_slice()).is_empty());
    }
}

proptest! {
    #[test]
    fn a_changed_byte_is_caught_by_parity_or_counter(
        at in 10 * FRAME_BYTES..30 * FRAME_BYTES,
        change in 1u8..,
    ) {
        let good = ramp(30);
        let mut bad = good.clone();
        bad[at] ^= change;
        let samples = delivered(&mut Decoder::new(OutputMode::Rate), &bad);
        let originals = delivered(&mut Decoder::new(OutputMode::Rate), &good);

        let in_counter = at % FRAME_BYTES == 0 && change & 0b0110_0000 != 0;
        if change.count_ones() % 2 == 1 || in_counter {
            prop_assert!(samples.iter().all(|sample| originals.contains(sample)));
        } else {
            // The error is undetectable: lock is kept.
            prop_assert!(samples.len() >= originals.len() - 1);
        }
    }

    #[test]
    fn the_rate_is_within_half_a_step_of_what_was_sent(deg_per_s in -2_000.0f64..2_000.0) {
        let samples = delivered(&mut Decoder::new(OutputMode::Rate), &rates(&[deg_per_s; LOCK]));
        prop_assert_eq!(samples.len(), 1);
        match samples[0].output {
            GyroOutput::Rate(rate) => {
                prop_assert!((rate.deg_per_s() - deg_per_s).abs() <= 30e-6 * (1.0 + 1e-6));
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }
}
