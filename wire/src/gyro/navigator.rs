//! The Navigator stream: rate, temperature, status and sequence in one 8-byte frame.
//!
//! The original format is not published. This is our reconstruction, not claimed authentic, modelled on the gyro's
//! successor: the frame of the KVH E-Core 2000 with the top bit set on its first byte only and a checksum as the first
//! of seven data bytes. The rate is where the public decoders of the E-Core 2000 read it, in the last two bytes; the
//! four that they leave undecoded carry the rest.
//!
//! | payload byte | field | encoding |
//! |---|---|---|
//! | 0, 1 | temperature | signed, big-endian, [`TEMPERATURE_STEP`]; `0x8000`: not measured |
//! | 2 | status | bit 0: built-in test failed, bit 1: warming up, bit 2: over range; others zero |
//! | 3 | sequence | counts modulo 256 |
//! | 4, 5 | rate | signed, big-endian, [`RATE_STEP`] |
//!
//! There is no validity bit. A sample that is invalid, or has no rate, is sent with the built-in test failed.

use super::kvh_frame::{self, Payload};
use super::{FormatFacts, GyroOutput, GyroSample, GyroStatus, Sequence, quantised};
use crate::serial::SerialSettings;
use crate::time::Span;
use crate::units::{AngularRate, Temperature};

/// Full range of the gyro (paper, data sheet: +-100 deg/s).
pub const RATE_RANGE: AngularRate = AngularRate::from_deg_per_s(100.0);

/// One step of the rate: the range over 2^15, 0.00305 deg/s (after the E-Core 2000, whose +-60 deg/s
/// unit has 0.00183 deg/s).
pub const RATE_STEP: AngularRate =
    AngularRate::from_rad_per_s(RATE_RANGE.rad_per_s() / STEPS_PER_RANGE);

/// One step of the temperature (assumption: 0.01 degC).
pub const TEMPERATURE_STEP: Temperature = Temperature::from_celsius(0.01);

/// Modulus of the sequence (assumption).
pub const SEQUENCE_MODULUS: u16 = 256;

/// A good frame is delivered whatever bytes precede it.
pub const RESYNC_BYTES_MAX: usize = kvh_frame::RESYNC_BYTES_MAX;

/// Properties of the format.
pub const FORMAT: FormatFacts = FormatFacts {
    name: "navigator",
    title: "Autogyro Navigator, 9600 baud",
    serial: SerialSettings::new_8n1(9_600),
    period: Span::from_millis(10),
    frame_bytes: kvh_frame::FRAME_BYTES,
    rate_step: RATE_STEP,
    angle_step: None,
    sequence_modulus: Some(SEQUENCE_MODULUS),
    takes_commands: false,
    resync_bytes_max: RESYNC_BYTES_MAX,
};

const STEPS_PER_RANGE: f64 = 32_768.0;
const STEPS_PER_RAD_PER_S: f64 = 1.0 / RATE_STEP.rad_per_s();
const STEPS_PER_CELSIUS: f64 = 1.0 / TEMPERATURE_STEP.celsius();
const NOT_MEASURED: i16 = i16::MIN;

const BUILT_IN_TEST_FAILED: u8 = 1 << 0;
const WARMING_UP: u8 = 1 << 1;
const OVER_RANGE: u8 = 1 << 2;

/// The frame of one sample. Rate and temperature are clipped to 16 bits; a missing sequence is sent as zero.
#[inline]
pub fn encode(sample: &GyroSample) -> [u8; kvh_frame::FRAME_BYTES] {
    let rate = match sample.output {
        GyroOutput::Rate(rate) => {
            quantised(rate.rad_per_s() * STEPS_PER_RAD_PER_S, i16::MIN.into(), i16::MAX.into())
        }
        GyroOutput::Increment(_) | GyroOutput::Integrated(_) => None,
    };
    let temperature = sample.temperature.and_then(|t| {
        quantised(t.celsius() * STEPS_PER_CELSIUS, (NOT_MEASURED + 1).into(), i16::MAX.into())
    });

    let status = sample.status;
    let failed = status.built_in_test_failed || !sample.valid || rate.is_none();
    let [rate_high, rate_low] = (rate.unwrap_or(0) as i16).to_be_bytes();
    let [temperature_high, temperature_low] =
        temperature.map_or(NOT_MEASURED, |steps| steps as i16).to_be_bytes();
    kvh_frame::encode(Payload::from_bytes([
        temperature_high,
        temperature_low,
        if_set(failed, BUILT_IN_TEST_FAILED)
            | if_set(status.warming_up, WARMING_UP)
            | if_set(status.over_range, OVER_RANGE),
        sample.sequence.map_or(0, |sequence| sequence.value),
        rate_high,
        rate_low,
    ]))
}

#[inline]
const fn if_set(flag: bool, bit: u8) -> u8 {
    if flag { bit } else { 0 }
}

#[inline]
fn decode(payload: Payload) -> GyroSample {
    let [temperature_high, temperature_low, status, sequence, rate_high, rate_low] =
        payload.to_bytes();
    let rate = i16::from_be_bytes([rate_high, rate_low]);
    let temperature = i16::from_be_bytes([temperature_high, temperature_low]);
    GyroSample {
        output: GyroOutput::Rate(RATE_STEP * f64::from(rate)),
        valid: true,
        status: GyroStatus {
            built_in_test_failed: status & BUILT_IN_TEST_FAILED != 0,
            warming_up: status & WARMING_UP != 0,
            over_range: status & OVER_RANGE != 0,
        },
        temperature: (temperature != NOT_MEASURED)
            .then(|| TEMPERATURE_STEP * f64::from(temperature)),
        sequence: Some(Sequence { value: sequence, modulus: SEQUENCE_MODULUS }),
    }
}

kvh_frame::decoder!();

#[cfg(test)]
mod tests {
    use super::super::test_support::{decoded, hex_table, rate_sample};
    use super::{Decoder, encode};
    use crate::gyro::{GyroFormat, GyroOutput, GyroSample, GyroStatus, OutputMode, Sequence};
    use crate::units::{Angle, AngularRate, Temperature};
    use insta::assert_snapshot;

    fn sample(deg_per_s: f64) -> GyroSample {
        GyroSample {
            temperature: Some(Temperature::from_celsius(25.0)),
            sequence: Some(Sequence { value: 7, modulus: 256 }),
            ..rate_sample(deg_per_s)
        }
    }

    fn sent_and_received(sample: &GyroSample) -> GyroSample {
        decoded(GyroFormat::Navigator, OutputMode::Rate, encode(sample).as_slice())[0]
    }

    #[test]
    fn known_frames() {
        // +30 deg/s by hand: 9830 = 0x2666 steps; the payload 09 c4 00 07 26 66 sums to 0x60, so the checksum is 0xa0;
        // a0 09 c4 00 07 26 66 in groups of seven bits is 50 02 38 40 00 1c 4c 66.
        let warm_and_over = GyroSample {
            status: GyroStatus { warming_up: true, over_range: true, ..Default::default() },
            ..sample(250.0)
        };
        assert_snapshot!(hex_table(encode, &[
            ("0 deg/s", sample(0.0)),
            ("+30 deg/s", sample(30.0)),
            ("-30 deg/s", sample(-30.0)),
            ("no temperature", rate_sample(0.0)),
            ("clipped, warming up", warm_and_over),
            ("not a number", sample(f64::NAN)),
        ]), @r"
        0 deg/s               96 02 38 40 00 1c 00 00
        +30 deg/s             d0 02 38 40 00 1c 4c 66
        -30 deg/s             dc 42 38 40 00 1f 33 1a
        no temperature        c0 20 00 00 00 00 00 00
        clipped, warming up   d4 02 38 40 30 1d 7f 7f
        not a number          95 42 38 40 08 1c 00 00
        ");
    }

    #[test]
    fn values_beyond_sixteen_bits_are_clipped() {
        let rate = |deg_per_s| match sent_and_received(&sample(deg_per_s)).output {
            GyroOutput::Rate(rate) => rate.deg_per_s(),
            other => panic!("{other:?}"),
        };
        assert!((rate(1e6) - 100.0 * 32_767.0 / 32_768.0).abs() < 1e-9);
        assert!((rate(f64::NEG_INFINITY) + 100.0).abs() < 1e-9);

        let cold = GyroSample { temperature: Some(Temperature::from_celsius(-1e6)), ..sample(0.0) };
        let celsius = sent_and_received(&cold).temperature.unwrap().celsius();
        assert!((celsius + 327.67).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_usable_rate_fails_the_built_in_test() {
        let increment = GyroOutput::Increment(Angle::from_deg(1.0));
        for bad in [
            sample(f64::NAN),
            GyroSample { valid: false, ..sample(1.0) },
            GyroSample { output: increment, ..sample(0.0) },
        ] {
            assert!(sent_and_received(&bad).status.built_in_test_failed);
        }
        assert!(!sent_and_received(&sample(1.0)).status.built_in_test_failed);
        assert_eq!(
            sent_and_received(&sample(f64::NAN)).output,
            GyroOutput::Rate(AngularRate::ZERO)
        );
    }

    #[test]
    fn a_temperature_that_is_no_number_is_not_measured() {
        let bad =
            GyroSample { temperature: Some(Temperature::from_celsius(f64::NAN)), ..sample(0.0) };
        assert_eq!(sent_and_received(&bad).temperature, None);
    }

    #[test]
    fn lock_found_again_is_counted_once() {
        let frame = encode(&sample(1.0));
        let mut decoder = Decoder::new(OutputMode::Rate);
        let mut samples = 0;
        for bytes in [&[0x11, 0x22][..], frame.as_slice(), &[0x33; 5], frame.as_slice()] {
            decoder.feed(bytes, &mut |_| samples += 1);
        }
        decoder.feed(frame.as_slice(), &mut |_| samples += 1);
        let counters = decoder.counters();
        assert_eq!((samples, counters.frames, counters.resyncs), (3, 3, 1));
        assert_eq!((counters.bytes_discarded, counters.checksum_errors), (7, 0));
    }
}
