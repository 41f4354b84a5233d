//! Numbers as digits: printing, and finding their end in a text.

use std::fmt::Write as _;
use wire::packet::{BYTES_MAX, Packet};

/// More decimals exceed the precision of a double.
const DECIMALS_MAX: usize = 17;

/// Default maximum of printed decimals.
const DECIMALS_UNSAID: usize = 9;

/// Above this a double has no decimals.
const WHOLE_FROM: f64 = 1e15;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Match {
    /// The first bytes, this many, are the line.
    Whole(usize),
    /// They may become the line.
    Partial,
    /// They are the line, but for its checksum.
    WrongChecksum,
    /// They cannot become the line.
    No,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Format {
    plus: bool,
    zeros: bool,
    pub(super) width: usize,
    decimals: Option<usize>,
}

impl Format {
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (plus, text) = text.strip_prefix('+').map_or((false, text), |rest| (true, rest));
        let (zeros, text) = text.strip_prefix('0').map_or((false, text), |rest| (true, rest));
        let (width, decimals) = match text.split_once('.') {
            Some((width, decimals)) => (width, Some(decimals.parse().ok()?)),
            None => (text, None),
        };
        let width = if width.is_empty() { 0 } else { width.parse().ok()? };
        let fits = width <= BYTES_MAX && decimals.is_none_or(|n| n <= DECIMALS_MAX);
        fits.then_some(Self { plus, zeros, width, decimals })
    }

    /// The number that the printed one stands for.
    pub(crate) fn rounded(self, number: f64) -> f64 {
        let mut text = Packet::new();
        let is_whole = self.print(number, &mut text);
        let digits = std::str::from_utf8(text.as_slice()).unwrap_or_default();
        let printed = digits.trim_start().parse().ok();
        printed.filter(|_| is_whole).unwrap_or(number)
    }

    /// Printing changes a number by at most half of this.
    pub(crate) fn resolution(self) -> f64 {
        libm::exp10(-(self.decimals.unwrap_or(DECIMALS_UNSAID) as f64))
    }

    /// Maximum length of the number in bytes.
    pub(super) fn longest(self, number: f64) -> usize {
        let decimals = self.decimals.unwrap_or(DECIMALS_UNSAID);
        format!("{number:+.decimals$}").len().max(self.width)
    }

    /// Appends `number`; `false` if the packet is full.
    pub(super) fn print(self, number: f64, to: &mut Packet) -> bool {
        let width = self.width;
        let number = match self.decimals {
            None if number.abs() < WHOLE_FROM => {
                let unit = libm::exp10(DECIMALS_UNSAID as f64);
                libm::round(number * unit) / unit
            }
            _ => number,
        };
        match (self.decimals, self.plus, self.zeros) {
            (Some(n), false, false) => write!(to, "{number:width$.n$}"),
            (Some(n), false, true) => write!(to, "{number:0width$.n$}"),
            (Some(n), true, false) => write!(to, "{number:+width$.n$}"),
            (Some(n), true, true) => write!(to, "{number:+0width$.n$}"),
            (None, false, false) => write!(to, "{number:width$}"),
            (None, false, true) => write!(to, "{number:0width$}"),
            (None, true, false) => write!(to, "{number:+width$}"),
            (None, true, true) => write!(to, "{number:+0width$}"),
        }
        .is_ok()
    }
}

/// Length of the number at the start of `data`. A number at the end of the data may continue.
pub(super) fn number_length(data: &[u8], padded: bool) -> Match {
    let count = |from: usize, test: fn(&u8) -> bool| {
        data[from..].iter().take_while(|byte| test(byte)).count()
    };
    let sign = |at: usize| usize::from(matches!(data.get(at), Some(b'+' | b'-')));
    let mut at = if padded { count(0, |byte| *byte == b' ') } else { 0 };
    at += sign(at);
    let before = count(at, u8::is_ascii_digit);
    at += before;
    let mut digits = before;
    if data.get(at) == Some(&b'.') {
        let behind = count(at + 1, u8::is_ascii_digit);
        at += 1 + behind;
        digits += behind;
    }
    if at == data.len() {
        return Match::Partial;
    }
    if digits == 0 {
        return Match::No;
    }
    if matches!(data[at], b'e' | b'E') {
        let mantissa = at;
        at += 1 + sign(at + 1);
        let exponent = count(at, u8::is_ascii_digit);
        at += exponent;
        if at == data.len() {
            return Match::Partial;
        }
        if exponent == 0 {
            return Match::Whole(mantissa);
        }
    }
    Match::Whole(at)
}
