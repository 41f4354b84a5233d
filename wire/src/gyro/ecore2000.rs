//! The KVH E-Core 2000 stream, +-60 deg/s unit: a rate in each 8-byte frame, and nothing else.
//!
//! The top bit is set on the first byte only; the other 56 bits are seven data bytes, of which the first is the
//! two's-complement negative of the sum of the other six. The last two are the rate, signed and big-endian. The
//! meaning of the four between is not published: they are sent as zero and ignored on receipt.
//!
//! Source: two public decoders (`gyroread.c`, University of California, 2002, for the +-60 deg/s unit;
//! `gyroComponent.cpp`, Heudiasyc, 2006, for the +-30 deg/s unit, whose step is half as large).
//!
//! There is no validity bit and no status: a sample without a rate is sent as zero.

use super::kvh_frame::{self, Payload};
use super::{FormatFacts, GyroOutput, GyroSample, GyroStatus, quantised};
use crate::serial::SerialSettings;
use crate::time::Span;
use crate::units::AngularRate;

/// Full range of the unit (`gyroread.c`: "60 degree/second max rate unit").
pub const RATE_RANGE: AngularRate = AngularRate::from_deg_per_s(60.0);

/// One step of the rate: the range over 2^15, which `gyroread.c` rounds to 0.00183 deg/s.
pub const RATE_STEP: AngularRate =
    AngularRate::from_rad_per_s(RATE_RANGE.rad_per_s() / STEPS_PER_RANGE);

/// A good frame is delivered whatever bytes precede it.
pub const RESYNC_BYTES_MAX: usize = kvh_frame::RESYNC_BYTES_MAX;

/// Properties of the format.
pub const FORMAT: FormatFacts = FormatFacts {
    name: "ecore2000",
    title: "KVH E-Core 2000, 9600 baud",
    serial: SerialSettings::new_8n1(9_600),
    period: Span::from_millis(10),
    frame_bytes: kvh_frame::FRAME_BYTES,
    rate_step: RATE_STEP,
    angle_step: None,
    sequence_modulus: None,
    takes_commands: false,
    resync_bytes_max: RESYNC_BYTES_MAX,
};

const STEPS_PER_RANGE: f64 = 32_768.0;
const STEPS_PER_RAD_PER_S: f64 = 1.0 / RATE_STEP.rad_per_s();

/// The frame of one sample. The rate is clipped to 16 bits.
#[inline]
pub fn encode(sample: &GyroSample) -> [u8; kvh_frame::FRAME_BYTES] {
    let rate = match sample.output {
        GyroOutput::Rate(rate) => {
            quantised(rate.rad_per_s() * STEPS_PER_RAD_PER_S, i16::MIN.into(), i16::MAX.into())
        }
        GyroOutput::Increment(_) | GyroOutput::Integrated(_) => None,
    };
    let [high, low] = (rate.unwrap_or(0) as i16).to_be_bytes();
    kvh_frame::encode(Payload::from_bytes([0, 0, 0, 0, high, low]))
}

#[inline]
fn decode(payload: Payload) -> GyroSample {
    let [_, _, _, _, high, low] = payload.to_bytes();
    GyroSample {
        output: GyroOutput::Rate(RATE_STEP * f64::from(i16::from_be_bytes([high, low]))),
        valid: true,
        status: GyroStatus::default(),
        temperature: None,
        sequence: None,
    }
}

kvh_frame::decoder!();

#[cfg(test)]
mod tests {
    use super::super::kvh_frame::{self, Payload};
    use super::super::test_support::{decoded, hex_table, rate_sample};
    use super::{RATE_STEP, encode};
    use crate::gyro::{GyroFormat, GyroOutput, OutputMode};
    use insta::assert_snapshot;

    #[test]
    fn known_frames() {
        // +30 deg/s by hand: 0x4000 steps, checksum 0xc0; c0 00 00 00 00 40 00 in groups of seven
        // bits is 60 00 00 00 00 01 00 00.
        assert_snapshot!(hex_table(encode, &[
            ("0 deg/s", rate_sample(0.0)),
            ("+30 deg/s", rate_sample(30.0)),
            ("-30 deg/s", rate_sample(-30.0)),
            ("clipped", rate_sample(-1e9)),
            ("not a number", rate_sample(f64::NAN)),
        ]), @r"
        0 deg/s               80 00 00 00 00 00 00 00
        +30 deg/s             e0 00 00 00 00 01 00 00
        -30 deg/s             a0 00 00 00 00 03 00 00
        clipped               c0 00 00 00 00 02 00 00
        not a number          80 00 00 00 00 00 00 00
        ");
    }

    #[test]
    fn the_step_is_the_published_one() {
        assert!((RATE_STEP.deg_per_s() - 0.00183).abs() < 0.000_005);
    }

    #[test]
    fn bytes_of_unknown_meaning_are_ignored() {
        let frame = kvh_frame::encode(Payload::from_bytes([0xde, 0xad, 0xbe, 0xef, 0x40, 0x00]));
        let samples = decoded(GyroFormat::Ecore2000, OutputMode::Rate, frame.as_slice());
        match samples[..] {
            [sample] => match sample.output {
                GyroOutput::Rate(rate) => assert!((rate.deg_per_s() - 30.0).abs() < 1e-9),
                other => panic!("{other:?}"),
            },
            ref other => panic!("{other:?}"),
        }
    }
}
