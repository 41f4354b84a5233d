//! Helpers shared by the tests of several formats.

use super::{GyroDecoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream, OutputMode};
use crate::units::AngularRate;
use std::format;
use std::string::String;
use std::vec::Vec;

/// A valid sample with only a rate.
pub(super) fn rate_sample(deg_per_s: f64) -> GyroSample {
    GyroSample {
        output: GyroOutput::Rate(AngularRate::from_deg_per_s(deg_per_s)),
        valid: true,
        status: GyroStatus::default(),
        temperature: None,
        sequence: None,
    }
}

/// Samples that a fresh decoder reads from `bytes`.
pub(super) fn decoded(format: GyroFormat, mode: OutputMode, bytes: &[u8]) -> Vec<GyroSample> {
    let mut samples = Vec::new();
    let mut decoder = GyroDecoder::new(GyroStream { format, mode, reversed: false });
    decoder.feed(bytes, |sample| samples.push(sample));
    samples
}

/// One line per sample: its name and its frame in hexadecimal.
pub(super) fn hex_table<const N: usize>(
    encode: fn(&GyroSample) -> [u8; N],
    rows: &[(&str, GyroSample)],
) -> String {
    let row = |(name, sample): &(&str, GyroSample)| {
        let bytes: Vec<String> = encode(sample).iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{name:<22}{}\n", bytes.join(" "))
    };
    rows.iter().map(row).collect()
}
