//! From a measured rate to the content of an output.

use super::GyroEmulator;
use wire::gyro::{GyroOutput, GyroSample, GyroStatus, OutputMode, Sequence};
use wire::units::{Angle, AngularRate, Temperature};

impl GyroEmulator {
    /// The next output of a gyro without faults, for the rate `wanted` in rad/s.
    #[inline(always)]
    pub(super) fn sound(&mut self, wanted: f64, interval_s: f64) -> GyroSample {
        let over_range = wanted.abs() > self.range;
        let measured = wanted.clamp(-self.range, self.range);
        self.sample(measured, interval_s, over_range)
    }

    /// The next output, for a measured rate in rad/s.
    #[inline(always)]
    pub(super) fn sample(&mut self, rate: f64, interval_s: f64, over_range: bool) -> GyroSample {
        let increment = rate * interval_s;
        self.integrated += increment;
        let output = match self.mode {
            OutputMode::Rate => GyroOutput::Rate(AngularRate::from_rad_per_s(rate)),
            OutputMode::Increment => GyroOutput::Increment(Angle::from_rad(increment)),
            OutputMode::Integrated => {
                GyroOutput::Integrated(Angle::from_rad(self.integrated).wrapped())
            }
        };
        let sequence = self.sequence;
        self.sequence = sequence.map(following);
        GyroSample {
            output,
            // It stays good beyond the range: KVH DSP-3000 manual.
            valid: true,
            status: GyroStatus {
                built_in_test_failed: false,
                warming_up: self.warming_up,
                over_range,
            },
            temperature: Some(Temperature::from_celsius(self.thermal.reading())),
            sequence,
        }
    }
}

/// The next sequence number.
fn following(Sequence { value, modulus }: Sequence) -> Sequence {
    let next = u16::from(value) + 1;
    // Below the modulus, which is 256 at most.
    Sequence { value: if next < modulus { next as u8 } else { 0 }, modulus }
}
