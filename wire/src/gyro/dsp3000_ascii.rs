//! The KVH DSP-3000 stream, 100 Hz ASCII interface (part 02-1222-01).
//!
//! A line holds a decimal number and a validity flag: `(-)xxx.xxxxxx y` CR LF, where y is 1 for valid data and 0 for a
//! fault (KVH DSP-3000 Technical Manual 54-0215 Rev. C, section 2.1). The number is a rate in deg/s, an increment in
//! deg or an angle in deg modulo 360. The line does not show which, so the caller sets the mode, and a wrong mode goes
//! unnoticed.
//!
//! Public drivers record lines of exactly 21 bytes, the number right-aligned in 15 columns, three spaces, the flag, CR
//! LF (`libdsp3000`, EPFL, 2006; parser tests of the ROS package `kvh`, 2016). The encoder sends these. The decoder
//! accepts them, and lines as printed in the manual, with three digits before the point and one space after the
//! number.
//!
//! Lines carry no checksum. Both forms fix the number of digits, so the decoder detects a lost, doubled or non-digit
//! byte, but not a digit changed to another digit or a minus changed to a space. A sender with other spacing, in
//! lines of at most [`LINE_BYTES`], is accepted if its columns are fixed, which shows in [`FORM_LINES`] such lines
//! without any other good line between them. From then on a lost byte moves the columns and is detected as well.

use super::tally::Tally;
use super::{Counters, FormatFacts, GyroOutput, GyroSample, GyroStatus, OutputMode, quantised};
use crate::serial::SerialSettings;
use crate::time::Span;
use crate::units::{Angle, AngularRate};

/// One step of a rate: the sixth decimal of deg/s.
pub const RATE_STEP: AngularRate = AngularRate::from_deg_per_s(1.0 / STEPS_PER_UNIT);

/// One step of an angle: the sixth decimal of deg.
pub const ANGLE_STEP: Angle = Angle::from_deg(1.0 / STEPS_PER_UNIT);

/// Garbage without a line end costs the line that it runs into; the next one is delivered.
pub const RESYNC_BYTES_MAX: usize = 2 * LINE_BYTES;

/// Length of a line in the recordings of public drivers.
pub const LINE_BYTES: usize = 21;

/// Properties of the format.
pub const FORMAT: FormatFacts = FormatFacts {
    name: "dsp3000-ascii",
    title: "KVH DSP-3000, text, 38400 baud",
    serial: SerialSettings::new_8n1(38_400),
    period: Span::from_millis(10),
    frame_bytes: LINE_BYTES,
    rate_step: RATE_STEP,
    angle_step: Some(ANGLE_STEP),
    sequence_modulus: None,
    takes_commands: true,
    resync_bytes_max: RESYNC_BYTES_MAX,
};

/// Lines of a spacing of its own after which it is accepted. A line that lost a byte looks like one; so many in a row
/// do not.
pub const FORM_LINES: u32 = 10;

const STEPS_PER_UNIT: f64 = 1e6;
const STEPS_PER_RAD: f64 = 1.0 / ANGLE_STEP.rad();
/// The largest number that three digits and six decimals hold, in steps.
const STEPS_MAX: i32 = 999_999_999;
const STEPS_PER_TURN: i32 = 360_000_000;

const NUMBER_COLUMNS: usize = 15;
const GAP: &[u8] = b"   ";
const LINE_END: &[u8] = b"\r\n";
const DECIMALS: usize = 6;
const INTEGER_DIGITS_MAX: usize = 3;

/// The line of one sample. A rate or an increment is clipped to +-999.999999; an angle is sent in
/// [0, 360) deg.
pub fn encode(sample: &GyroSample) -> [u8; LINE_BYTES] {
    let steps = match sample.output {
        GyroOutput::Rate(rate) => {
            quantised(rate.rad_per_s() * STEPS_PER_RAD, -STEPS_MAX, STEPS_MAX)
        }
        GyroOutput::Increment(angle) => {
            quantised(angle.rad() * STEPS_PER_RAD, -STEPS_MAX, STEPS_MAX)
        }
        GyroOutput::Integrated(angle) => {
            quantised(angle.wrapped().rad() * STEPS_PER_RAD, -STEPS_PER_TURN, STEPS_PER_TURN)
                .map(|steps| steps.rem_euclid(STEPS_PER_TURN))
        }
    };
    let valid = sample.valid && steps.is_some();

    let mut line = [b' '; LINE_BYTES];
    let (number, rest) = line.split_at_mut(NUMBER_COLUMNS);
    write_number(number, steps.unwrap_or(0));
    rest[GAP.len()] = if valid { b'1' } else { b'0' };
    rest[GAP.len() + 1..].copy_from_slice(LINE_END);
    line
}

/// Writes `steps` millionths right-aligned: at least one digit before the point, six after it.
fn write_number(columns: &mut [u8], steps: i32) {
    const POINT: usize = NUMBER_COLUMNS - DECIMALS - 1;
    let mut rest = steps.unsigned_abs();
    let mut column = NUMBER_COLUMNS;
    while rest > 0 || column >= POINT {
        column -= 1;
        if column == POINT {
            columns[column] = b'.';
        } else {
            columns[column] = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
    }
    if steps < 0 {
        columns[column - 1] = b'-';
    }
}

/// Bytes to samples.
#[derive(Debug, Clone)]
pub struct Decoder {
    mode: OutputMode,
    tally: Tally,
    /// An incomplete line.
    line: [u8; LINE_BYTES],
    line_bytes: usize,
    /// The line is longer than any good one: everything up to its end is discarded.
    too_long: bool,
    spacing: Spacing,
}

/// Columns of a line: its length, and the end of its number.
type Form = (usize, usize);

#[derive(Debug, Clone, Default)]
struct Spacing {
    accepted: Option<Form>,
    /// The form of the last lines, and their number.
    seen: Form,
    lines: u32,
}

impl Spacing {
    const NONE: Self = Self { accepted: None, seen: (0, 0), lines: 0 };

    /// Whether a line of this form is one of the sender.
    fn accepts(&mut self, form: Form) -> bool {
        if self.accepted == Some(form) {
            self.lines = 0;
            return true;
        }
        self.lines = if self.seen == form { self.lines + 1 } else { 1 };
        self.seen = form;
        if self.lines < FORM_LINES {
            return false;
        }
        self.accepted = Some(form);
        true
    }
}

impl Decoder {
    /// A decoder of a gyro set to `mode`.
    pub const fn new(mode: OutputMode) -> Self {
        Self {
            mode,
            tally: Tally::new(),
            line: [0; LINE_BYTES],
            line_bytes: 0,
            too_long: false,
            spacing: Spacing::NONE,
        }
    }

    /// Takes bytes in pieces of any length and passes each completed sample to `deliver`.
    pub fn feed(&mut self, mut bytes: &[u8], deliver: &mut impl FnMut(GyroSample)) {
        loop {
            if self.line_bytes == 0 && !self.too_long {
                // The usual case: whole lines, parsed in place.
                while let Some((line, rest)) = bytes.split_first_chunk::<LINE_BYTES>() {
                    let Some(reading) = read_columns(line) else {
                        break;
                    };
                    bytes = rest;
                    self.spacing.lines = 0;
                    self.judge(Some(reading), LINE_BYTES, deliver);
                }
            }
            let Some((&byte, rest)) = bytes.split_first() else {
                return;
            };
            bytes = rest;
            self.push(byte, deliver);
        }
    }

    /// The counters so far. A line without a usable number counts as malformed.
    pub const fn counters(&self) -> Counters {
        self.tally.counters()
    }

    /// Bytes of an incomplete line.
    pub const fn bytes_pending(&self) -> usize {
        self.line_bytes
    }

    fn push(&mut self, byte: u8, deliver: &mut impl FnMut(GyroSample)) {
        if !self.too_long {
            match self.line.get_mut(self.line_bytes) {
                Some(room) => {
                    *room = byte;
                    self.line_bytes += 1;
                }
                None => {
                    self.tally.discard(self.line_bytes);
                    self.line_bytes = 0;
                    self.too_long = true;
                }
            }
        }
        if self.too_long {
            self.tally.discard(1);
        }
        if byte == b'\n' {
            let reading = self.read_line();
            self.judge(reading, self.line_bytes, deliver);
            self.line_bytes = 0;
            self.too_long = false;
        }
    }

    /// Parses the line, its end included, in one of the two forms or in that of the sender.
    fn read_line(&mut self) -> Option<Reading> {
        let line = self.line.get(..self.line_bytes)?;
        if let Some(reading) = read_known(line) {
            self.spacing.lines = 0;
            return Some(reading);
        }
        let (form, reading) = read_spaced(line)?;
        self.spacing.accepts(form).then_some(reading)
    }

    /// Evaluates a complete line; an overlong one has no bytes left to discard.
    fn judge(
        &mut self,
        reading: Option<Reading>,
        line_bytes: usize,
        deliver: &mut impl FnMut(GyroSample),
    ) {
        let output = reading.and_then(|reading| reading.output(self.mode));
        match (output, reading) {
            (Some(output), Some(Reading { valid, .. })) => {
                self.tally.good_frame();
                deliver(GyroSample {
                    output,
                    valid,
                    status: GyroStatus::default(),
                    temperature: None,
                    sequence: None,
                });
            }
            _ => {
                self.tally.malformed();
                self.tally.discard(line_bytes);
                self.tally.lose_lock();
            }
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Reading {
    steps: i32,
    valid: bool,
}

impl Reading {
    /// The value in the unit of `mode`; `None` for an angle of more than one turn.
    fn output(self, mode: OutputMode) -> Option<GyroOutput> {
        // The division gives the double nearest to the decimal number.
        let value = f64::from(self.steps) / STEPS_PER_UNIT;
        match mode {
            OutputMode::Rate => Some(GyroOutput::Rate(AngularRate::from_deg_per_s(value))),
            OutputMode::Increment => Some(GyroOutput::Increment(Angle::from_deg(value))),
            OutputMode::Integrated => (self.steps.abs() <= STEPS_PER_TURN)
                .then_some(GyroOutput::Integrated(Angle::from_deg(value))),
        }
    }
}

/// Parses a line, its end included, in either form.
fn read_known(line: &[u8]) -> Option<Reading> {
    if let Ok(columns) = line.try_into() {
        return read_columns(columns);
    }
    let line = line.strip_suffix(LINE_END)?;
    let (&flag, line) = line.split_last()?;
    let number = line.strip_suffix(b" ")?;
    let digits = number.strip_prefix(b"-").unwrap_or(number);
    (digits.len() == INTEGER_DIGITS_MAX + 1 + DECIMALS).then_some(())?;
    Some(Reading { steps: read_number(number)?, valid: read_flag(flag)? })
}

/// Parses a line with other spaces around its number, and returns its form.
fn read_spaced(line: &[u8]) -> Option<(Form, Reading)> {
    let (&flag, rest) = line.strip_suffix(LINE_END)?.split_last()?;
    let number = rest.trim_ascii_end();
    if number.len() == rest.len() {
        return None;
    }
    let reading =
        Reading { steps: read_number(number.trim_ascii_start())?, valid: read_flag(flag)? };
    Some(((line.len(), number.len()), reading))
}

fn read_columns(line: &[u8; LINE_BYTES]) -> Option<Reading> {
    let (number, rest) = line.split_at(NUMBER_COLUMNS);
    let (&flag, end) = rest.strip_prefix(GAP)?.split_first()?;
    (end == LINE_END).then_some(())?;
    let start = number.iter().position(|&byte| byte != b' ')?;
    Some(Reading { steps: read_number(&number[start..])?, valid: read_flag(flag)? })
}

/// Parses one to three digits, a point and six digits, with or without a minus, in steps.
fn read_number(number: &[u8]) -> Option<i32> {
    let digits = number.strip_prefix(b"-").unwrap_or(number);
    let (integer, fraction) = digits.split_at_checked(digits.len().checked_sub(DECIMALS)?)?;
    let (&point, integer) = integer.split_last()?;
    if point != b'.' || !(1..=INTEGER_DIGITS_MAX).contains(&integer.len()) {
        return None;
    }
    let mut steps = 0;
    for &byte in integer.iter().chain(fraction) {
        // At most nine digits: no overflow.
        steps = steps * 10 + char::from(byte).to_digit(10)? as i32;
    }
    Some(if digits.len() < number.len() { -steps } else { steps })
}

fn read_flag(flag: u8) -> Option<bool> {
    match flag {
        b'1' => Some(true),
        b'0' => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
