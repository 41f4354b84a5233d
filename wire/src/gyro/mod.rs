//! Byte streams of fibre-optic gyros: one sample type, four formats.
//!
//! | format | line | rate | fields | source |
//! |---|---|---|---|---|
//! | [`navigator`] | 9600 8N1 | 100 Hz | rate, temperature, status, sequence | our reconstruction, not claimed authentic |
//! | [`ecore2000`] | 9600 8N1 | 100 Hz | rate | published decoder of the KVH E-Core 2000 |
//! | [`dsp3000_ascii`] | 38400 8N1 | 100 Hz | rate, increment or integrated angle; validity | KVH DSP-3000 manual |
//! | [`dsp3000_binary`] | 115200 8N1 | 1000 Hz | the same, and a 2-bit sequence | KVH DSP-3000 manual |
//!
//! [`GyroEncoder`] turns samples into bytes, [`GyroDecoder`] bytes into samples. A decoder never panics, counts the
//! bytes it discards ([`Counters`]) and finds the next good frame within [`FormatFacts::resync_bytes_max`] bytes. The
//! host's commands to a DSP-3000 are in [`dsp3000_command`]. To add a format, write the file of its codec and a line
//! of `formats!`.

pub mod dsp3000_ascii;
pub mod dsp3000_binary;
pub mod dsp3000_command;
pub mod ecore2000;
mod kvh_frame;
pub mod navigator;
mod tally;
#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;

use crate::packet::Packet;
use crate::serial::SerialSettings;
use crate::time::Span;
use crate::units::{Angle, AngularRate, Temperature};
use serde::{Deserialize, Serialize};

/// Output of a gyro: a rate, the angle since its last output, or the angle since reset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum GyroOutput {
    /// Mean rate since the last output.
    Rate(AngularRate),
    /// Angle turned since the last output.
    Increment(Angle),
    /// Angle turned since power-up or reset, modulo one turn.
    Integrated(Angle),
}

/// Status reported by the gyro. All clear if the stream has no such field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GyroStatus {
    /// The built-in test found a fault.
    pub built_in_test_failed: bool,
    /// Not yet at a steady temperature.
    pub warming_up: bool,
    /// The rate exceeds the range: the data are wrong.
    pub over_range: bool,
}

/// A sequence number that shows lost samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sequence {
    /// The number of this sample.
    pub value: u8,
    /// Modulus of the number; at least 2.
    pub modulus: u16,
}

impl Sequence {
    /// Samples lost between `earlier` and `self`, modulo the counter: a repeated number reads as a loss of all numbers
    /// but one.
    #[inline]
    pub fn lost_since(self, earlier: Self) -> u16 {
        let modulus = i32::from(self.modulus.max(1));
        let lost = i32::from(self.value) - i32::from(earlier.value) - 1;
        // Below the modulus, which is a `u16`.
        lost.rem_euclid(modulus) as u16
    }
}

/// One output of a gyro, as its stream carries it. Positive is counter-clockwise for a gyro mounted
/// with its axis up and [`GyroStream::reversed`] unset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GyroSample {
    /// Rate, increment or angle.
    pub output: GyroOutput,
    /// The stream's own validity bit; true in formats without one (the Navigator then fails the built-in test). It stays true
    /// beyond the range (KVH DSP-3000 manual).
    pub valid: bool,
    /// Status bits.
    pub status: GyroStatus,
    /// Temperature of the coil's sensor, if the stream carries one.
    pub temperature: Option<Temperature>,
    /// Sequence number, if the stream carries one.
    pub sequence: Option<Sequence>,
}

/// Output mode of the DSP-3000; the two other gyros send rate only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputMode {
    /// Mean rate since the last output (command `R`).
    #[default]
    Rate,
    /// Incremental angle (command `A`).
    Increment,
    /// Integrated angle modulo one turn (command `P`).
    Integrated,
}

/// Properties of a format; each codec has its own as `FORMAT`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormatFacts {
    /// Its name in files and on the command line.
    pub name: &'static str,
    /// Short description.
    pub title: &'static str,
    /// The settings of the line.
    pub serial: SerialSettings,
    /// Nominal time between two outputs.
    pub period: Span,
    /// Length of one output on the wire, bytes.
    pub frame_bytes: usize,
    /// The step between two neighbouring rates.
    pub rate_step: AngularRate,
    /// The step between two neighbouring angles; `None` for a stream that carries rates only.
    pub angle_step: Option<Angle>,
    /// Modulus of the sequence number; `None` for a stream without one.
    pub sequence_modulus: Option<u16>,
    /// The gyro takes commands ([`dsp3000_command`]).
    pub takes_commands: bool,
    /// After any bytes at all, a decoder delivers one of the good frames within this many bytes.
    pub resync_bytes_max: usize,
}

/// One line per format: its name here, and the file of its codec.
macro_rules! formats {
    ($($format:ident = $codec:ident,)*) => {
        /// The stream formats.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum GyroFormat {
            $(#[doc = concat!("See [`", stringify!($codec), "`].")] $format,)*
        }

        impl GyroFormat {
            /// All formats.
            pub const ALL: [Self; [$(stringify!($format)),*].len()] = [$(Self::$format),*];

            /// Properties of the format.
            pub const fn facts(self) -> FormatFacts {
                match self {
                    $(Self::$format => $codec::FORMAT,)*
                }
            }

            // The sample stays in registers.
            #[inline(always)]
            fn encode(self, sample: &GyroSample, packet: &mut Packet) {
                match self {
                    $(Self::$format => packet.set(&$codec::encode(sample)),)*
                }
            }
        }

        #[derive(Debug, Clone)]
        enum FormatDecoder {
            $($format($codec::Decoder),)*
        }

        impl FormatDecoder {
            const fn new(format: GyroFormat, mode: OutputMode) -> Self {
                match format {
                    $(GyroFormat::$format => Self::$format($codec::Decoder::new(mode)),)*
                }
            }

            #[inline]
            fn feed(&mut self, bytes: &[u8], deliver: &mut impl FnMut(GyroSample)) {
                match self {
                    $(Self::$format(decoder) => decoder.feed(bytes, deliver),)*
                }
            }

            const fn counters(&self) -> Counters {
                match self {
                    $(Self::$format(decoder) => decoder.counters(),)*
                }
            }

            const fn bytes_pending(&self) -> usize {
                match self {
                    $(Self::$format(decoder) => decoder.bytes_pending(),)*
                }
            }
        }
    };
}

formats! {
    Navigator = navigator,
    Ecore2000 = ecore2000,
    Dsp3000Ascii = dsp3000_ascii,
    Dsp3000Binary = dsp3000_binary,
}

impl GyroFormat {
    /// The format with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.facts().name == name)
    }

    /// The settings of the line.
    pub const fn serial(self) -> SerialSettings {
        self.facts().serial
    }

    /// Nominal time between two outputs.
    pub const fn period(self) -> Span {
        self.facts().period
    }

    /// True if the format can carry this output.
    pub const fn carries(self, mode: OutputMode) -> bool {
        matches!(mode, OutputMode::Rate) || self.facts().angle_step.is_some()
    }
}

/// Configuration of a stream: format, output mode, mounting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GyroStream {
    /// The format on the wire.
    pub format: GyroFormat,
    /// Output mode of the gyro.
    #[serde(default)]
    pub mode: OutputMode,
    /// The manufacturer's positive direction is clockwise, or the axis points down.
    #[serde(default)]
    pub reversed: bool,
}

/// Counters of a decoder; all saturate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Good frames.
    pub frames: u64,
    /// Frames with a wrong checksum or parity.
    pub checksum_errors: u64,
    /// Complete frames or lines without a usable value.
    pub malformed: u64,
    /// Bytes that belong to no good frame. The bytes of good frames, these, and those still held by the decoder add up
    /// to all received bytes.
    pub bytes_discarded: u64,
    /// Number of times that lock was regained after a loss.
    pub resyncs: u64,
}

/// Encodes samples of one stream.
#[derive(Debug, Clone, Copy)]
pub struct GyroEncoder {
    stream: GyroStream,
}

impl GyroEncoder {
    /// An encoder for `stream`.
    pub const fn new(stream: GyroStream) -> Self {
        Self { stream }
    }

    /// The bytes of one sample. Values out of range are clipped; fields that the format lacks are omitted. A NaN, or
    /// an output that the format does not carry ([`GyroFormat::carries`]), is sent as zero with the validity bit
    /// clear; on the Navigator as zero with the built-in test failed; on the E-Core 2000, which has neither, just as
    /// zero.
    pub fn encode(&self, sample: &GyroSample) -> Packet {
        let mut packet = Packet::new();
        self.encode_to(sample, &mut packet);
        packet
    }

    /// Writes these bytes to `packet`, in place of what it held: a copy of a packet that was just written costs as much
    /// as encoding it.
    // The sample stays in registers: one that was just written to memory is not read again at once.
    #[inline(always)]
    pub fn encode_to(&self, sample: &GyroSample, packet: &mut Packet) {
        let output = if self.stream.reversed { negated(sample.output) } else { sample.output };
        self.stream.format.encode(&GyroSample { output, ..*sample }, packet);
    }
}

/// Decodes samples of one stream.
#[derive(Debug, Clone)]
pub struct GyroDecoder {
    reversed: bool,
    format: FormatDecoder,
}

impl GyroDecoder {
    /// A decoder for `stream`, out of lock.
    pub const fn new(stream: GyroStream) -> Self {
        let format = FormatDecoder::new(stream.format, stream.mode);
        Self { reversed: stream.reversed, format }
    }

    /// Takes bytes in pieces of any length and passes each completed sample to `deliver`.
    #[inline]
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(GyroSample)) {
        let reversed = self.reversed;
        let mut deliver = |mut sample: GyroSample| {
            if reversed {
                sample.output = negated(sample.output);
            }
            deliver(sample);
        };
        self.format.feed(bytes, &mut deliver);
    }

    /// The counters so far.
    pub const fn counters(&self) -> Counters {
        self.format.counters()
    }

    /// Received bytes that may still become part of a frame; at most one frame's.
    pub const fn bytes_pending(&self) -> usize {
        self.format.bytes_pending()
    }
}

/// `steps` rounded to the nearest whole number (ties to even) in `lowest..=highest`; `None` for a NaN.
#[inline]
fn quantised(steps: f64, lowest: i32, highest: i32) -> Option<i32> {
    /// 1.5 x 2^52: at this size neighbouring doubles are one apart, so that adding it rounds to a whole number, in
    /// two's complement in its low bits.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    if steps.is_nan() {
        return None;
    }
    let sum = steps.clamp(f64::from(lowest), f64::from(highest)) + ROUNDER;
    Some(sum.to_bits() as i32)
}

#[inline]
fn negated(output: GyroOutput) -> GyroOutput {
    match output {
        GyroOutput::Rate(rate) => GyroOutput::Rate(-rate),
        GyroOutput::Increment(angle) => GyroOutput::Increment(-angle),
        GyroOutput::Integrated(angle) => GyroOutput::Integrated(-angle),
    }
}
