//! The KVH DSP-3000 stream, 1000 Hz binary interface (part 02-1222-07).
//!
//! A frame is one 32-bit word, most significant byte first (KVH DSP-3000 Technical Manual 54-0215
//! Rev. C, section 3.1):
//!
//! | bits | field |
//! |---|---|
//! | 31 | 1: valid; 0: the built-in test failed or the contents are invalid |
//! | 30, 29 | synchronisation: counts modulo 4 from frame to frame (assumption) |
//! | 28, 27 | 0: rate, 1: increment, 2: integrated angle |
//! | 26 | parity: the word has an odd number of ones |
//! | 25 to 0 | two's complement, in [`RATE_STEP`] or [`ANGLE_STEP`] |
//!
//! Nothing marks the start of a frame. The decoder searches every byte offset for [`LOCK_FRAMES`] frames in a row with
//! correct parity and a counter that increments by one (assumption), delivers from the last of them on, and loses lock
//! at the first error (assumption). An encoder must therefore number the samples: without [`GyroSample::sequence`] no
//! decoder locks.
//!
//! Parity detects an odd number of changed bits in a frame, the counter a change of its own bits. An even number of
//! changed bits among the others goes unnoticed.

use super::tally::Tally;
use super::{
    Counters, FormatFacts, GyroOutput, GyroSample, GyroStatus, OutputMode, Sequence, quantised,
};
use crate::serial::SerialSettings;
use crate::time::Span;
use crate::units::{Angle, AngularRate};

/// One step of a rate: 60 micro-deg/s (manual, section 3.1.2).
pub const RATE_STEP: AngularRate = AngularRate::from_deg_per_s(60e-6);

/// One step of an angle: 6 micro-deg (manual, section 3.1.2, for increments; assumption for
/// integrated angles, which then need +-30,000,000 of the +-33,554,432 steps there are).
pub const ANGLE_STEP: Angle = Angle::from_deg(6e-6);

/// Modulus of the counter (assumption: the field has two bits).
pub const SEQUENCE_MODULUS: u16 = 4;

/// Number of good frames in a row to acquire lock (assumption).
pub const LOCK_FRAMES: u8 = 10;

/// Bytes of a frame.
pub const FRAME_BYTES: usize = 4;

/// Garbage can leave the decoder in lock at a wrong offset, or about to lock there. In good frames a window at a wrong
/// offset passes by chance one time in eight (parity one half, counter one quarter) if the low bits are noise. The
/// bound allows for ten of them, one that ends the garbage, the one that fails, and then the frames that acquire lock.
pub const RESYNC_BYTES_MAX: usize = (CHANCE_FRAMES_MAX + 2 + LOCK_FRAMES as usize) * FRAME_BYTES;

/// Windows at a wrong offset that pass in a row: the chance of more than ten is 10^-9.
const CHANCE_FRAMES_MAX: usize = 10;

/// Properties of the format.
pub const FORMAT: FormatFacts = FormatFacts {
    name: "dsp3000-binary",
    title: "KVH DSP-3000, binary, 115200 baud",
    serial: SerialSettings::new_8n1(115_200),
    period: Span::from_millis(1),
    frame_bytes: FRAME_BYTES,
    rate_step: RATE_STEP,
    angle_step: Some(ANGLE_STEP),
    sequence_modulus: Some(SEQUENCE_MODULUS),
    takes_commands: false,
    resync_bytes_max: RESYNC_BYTES_MAX,
};

const STEPS_PER_RAD_PER_S: f64 = 1.0 / RATE_STEP.rad_per_s();
const STEPS_PER_RAD: f64 = 1.0 / ANGLE_STEP.rad();

const VALID_BIT: u32 = 31;
const SEQUENCE_SHIFT: u32 = 29;
const TYPE_SHIFT: u32 = 27;
const PARITY_BIT: u32 = 26;
const CONTENT_BITS: u32 = 26;
const CONTENT_MAX: i32 = (1 << (CONTENT_BITS - 1)) - 1;
const CONTENT_MIN: i32 = -CONTENT_MAX - 1;
const CONTENT_MASK: u32 = (1 << CONTENT_BITS) - 1;
const TWO_BITS: u32 = 0b11;

const TYPE_RATE: u32 = 0;
const TYPE_INCREMENT: u32 = 1;
const TYPE_INTEGRATED: u32 = 2;

/// The frame of one sample. A rate or an increment is clipped to 26 bits; an angle is sent in [-180, 180] deg. The
/// sequence is sent modulo 4, or as zero if missing.
#[inline]
pub fn encode(sample: &GyroSample) -> [u8; FRAME_BYTES] {
    let (kind, steps) = match sample.output {
        GyroOutput::Rate(rate) => (TYPE_RATE, rate.rad_per_s() * STEPS_PER_RAD_PER_S),
        GyroOutput::Increment(angle) => (TYPE_INCREMENT, angle.rad() * STEPS_PER_RAD),
        GyroOutput::Integrated(angle) => (TYPE_INTEGRATED, angle.wrapped().rad() * STEPS_PER_RAD),
    };
    let content = quantised(steps, CONTENT_MIN, CONTENT_MAX);
    let valid = sample.valid && content.is_some();
    let sequence = sample.sequence.map_or(0, |sequence| u32::from(sequence.value) & TWO_BITS);
    let word = u32::from(valid) << VALID_BIT
        | sequence << SEQUENCE_SHIFT
        | kind << TYPE_SHIFT
        | (content.unwrap_or(0) as u32 & CONTENT_MASK);
    let parity = u32::from(!Word(word).has_odd_parity());
    let word = word | parity << PARITY_BIT;
    word.to_be_bytes()
}

/// A received frame.
#[derive(Debug, Clone, Copy)]
struct Word(u32);

impl Word {
    #[inline]
    fn has_odd_parity(self) -> bool {
        self.0.count_ones() % 2 == 1
    }

    #[inline]
    fn sequence(self) -> u8 {
        (self.0 >> SEQUENCE_SHIFT & TWO_BITS) as u8
    }

    /// The sample; `None` for an undefined type.
    #[inline]
    fn sample(self) -> Option<GyroSample> {
        const SIGN_SHIFT: u32 = u32::BITS - CONTENT_BITS;
        let content = f64::from((self.0 << SIGN_SHIFT) as i32 >> SIGN_SHIFT);
        let output = match self.0 >> TYPE_SHIFT & TWO_BITS {
            TYPE_RATE => GyroOutput::Rate(RATE_STEP * content),
            TYPE_INCREMENT => GyroOutput::Increment(ANGLE_STEP * content),
            TYPE_INTEGRATED => GyroOutput::Integrated(ANGLE_STEP * content),
            _ => return None,
        };
        Some(GyroSample {
            output,
            valid: self.0 >> VALID_BIT != 0,
            status: GyroStatus::default(),
            temperature: None,
            sequence: Some(Sequence { value: self.sequence(), modulus: SEQUENCE_MODULUS }),
        })
    }
}

/// The number that follows `sequence`.
const fn next(sequence: u8) -> u8 {
    (sequence + 1) % SEQUENCE_MODULUS as u8
}

/// Good frames in a row at one byte offset.
#[derive(Debug, Clone, Copy)]
struct Run {
    frames: u8,
    /// The counter expected in the next frame, after at least one.
    expected: u8,
}

const NO_RUN: Run = Run { frames: 0, expected: 0 };

/// Bytes to samples.
#[derive(Debug, Clone)]
pub struct Decoder {
    tally: Tally,
    /// The latest bytes, the newest in the low bits: up to a whole frame out of lock, less than one in lock.
    window: u32,
    window_bytes: usize,
    /// In lock: the counter expected in the next frame.
    expected: u8,
    /// Out of lock: the runs at the four byte offsets, and the offset that the next byte completes.
    runs: [Run; FRAME_BYTES],
    offset: usize,
}

impl Decoder {
    /// A decoder without input. The mode is ignored: the frames show what they carry.
    pub const fn new(_: OutputMode) -> Self {
        Self {
            tally: Tally::new(),
            window: 0,
            window_bytes: 0,
            expected: 0,
            runs: [NO_RUN; FRAME_BYTES],
            offset: 0,
        }
    }

    /// Takes bytes in pieces of any length and passes each completed sample to `deliver`.
    #[inline]
    pub fn feed(&mut self, mut bytes: &[u8], deliver: &mut impl FnMut(GyroSample)) {
        loop {
            // The usual case: whole frames in lock, evaluated in place.
            while self.tally.is_locked() && self.window_bytes == 0 {
                let Some((frame, rest)) = bytes.split_first_chunk::<FRAME_BYTES>() else {
                    break;
                };
                bytes = rest;
                self.judge(Word(u32::from_be_bytes(*frame)), deliver);
            }
            let Some((&byte, rest)) = bytes.split_first() else {
                return;
            };
            bytes = rest;
            self.push(byte, deliver);
        }
    }

    /// The counters so far. Frames and errors count in lock only.
    pub const fn counters(&self) -> Counters {
        self.tally.counters()
    }

    /// Bytes that may still become part of a frame.
    pub const fn bytes_pending(&self) -> usize {
        self.window_bytes
    }

    fn push(&mut self, byte: u8, deliver: &mut impl FnMut(GyroSample)) {
        if self.window_bytes == FRAME_BYTES {
            self.tally.discard(1);
        } else {
            self.window_bytes += 1;
        }
        self.window = self.window << 8 | u32::from(byte);
        if self.tally.is_locked() {
            if self.window_bytes == FRAME_BYTES {
                self.window_bytes = 0;
                self.judge(Word(self.window), deliver);
            }
        } else {
            self.offset = (self.offset + 1) % FRAME_BYTES;
            if self.window_bytes == FRAME_BYTES {
                self.search(deliver);
            }
        }
    }

    /// In lock: evaluates the next frame.
    #[inline]
    fn judge(&mut self, word: Word, deliver: &mut impl FnMut(GyroSample)) {
        if word.has_odd_parity() && word.sequence() == self.expected {
            self.expected = next(self.expected);
            match word.sample() {
                Some(sample) => {
                    self.tally.good_frame();
                    deliver(sample);
                }
                None => {
                    self.tally.malformed();
                    self.tally.discard(FRAME_BYTES);
                }
            }
        } else {
            self.lose_lock(word, deliver);
        }
    }

    /// Restarts the search with the bytes that failed: a good frame may begin among them.
    #[cold]
    fn lose_lock(&mut self, word: Word, deliver: &mut impl FnMut(GyroSample)) {
        if !word.has_odd_parity() {
            self.tally.checksum_error();
        }
        self.tally.lose_lock();
        self.runs = [NO_RUN; FRAME_BYTES];
        self.offset = 0;
        self.window = word.0;
        self.window_bytes = FRAME_BYTES;
        self.search(deliver);
    }

    /// Out of lock: adds the window to the run at its offset, and locks there if the run is long enough.
    fn search(&mut self, deliver: &mut impl FnMut(GyroSample)) {
        let word = Word(self.window);
        let run = &mut self.runs[self.offset];
        let Some(sample) = word.sample().filter(|_| word.has_odd_parity()) else {
            *run = NO_RUN;
            return;
        };
        let goes_on = run.frames > 0 && word.sequence() == run.expected;
        run.frames = if goes_on { run.frames + 1 } else { 1 };
        run.expected = next(word.sequence());
        if run.frames >= LOCK_FRAMES {
            self.expected = run.expected;
            self.window_bytes = 0;
            self.tally.good_frame();
            deliver(sample);
        }
    }
}

#[cfg(test)]
mod tests;
