//! Numbers as digits: printing, and finding their end in a text.

use std::fmt::Write as _;
use wire::packet::{BYTES_MAX, Packet};

/// More decimals exceed the precision of a double.
const DECIMALS_MAX: usize = 17;

/// Default maximum of printed decimals.
const DECIMALS_UNSAID: usize = 9;

/// Default number of decimals before an exponent, as in printf.
const MANTISSA_DECIMALS_UNSAID: usize = 6;

/// `E-308`.
const EXPONENT_LONGEST: usize = 5;

/// Above this a double has no decimals.
const WHOLE_FROM: f64 = 1e15;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Match {
    /// The first bytes, this many, are the line.
    Whole(usize),
    /// They may become the line.
    Partial,
    /// The first bytes, this many, are the line, but for its checksum.
    WrongChecksum(usize),
    /// They cannot become the line.
    No,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Format {
    plus: bool,
    zeros: bool,
    pub(super) width: usize,
    decimals: Option<usize>,
    /// `E` or `e`: with an exponent, as `1.20E+03`. This is the form NR3 of IEEE 488.2.
    exponent: Option<char>,
}

impl Format {
    pub(super) fn parse(text: &str) -> Option<Self> {
        let exponent = text.chars().last().filter(|last| matches!(last, 'E' | 'e'));
        let text = text.strip_suffix(['E', 'e']).unwrap_or(text);
        let (plus, text) = text.strip_prefix('+').map_or((false, text), |rest| (true, rest));
        let (zeros, text) = text.strip_prefix('0').map_or((false, text), |rest| (true, rest));
        let (width, decimals) = match text.split_once('.') {
            Some((width, decimals)) => (width, Some(decimals.parse().ok()?)),
            None => (text, None),
        };
        let width = if width.is_empty() { 0 } else { width.parse().ok()? };
        let fits = width <= BYTES_MAX && decimals.is_none_or(|n| n <= DECIMALS_MAX);
        fits.then_some(Self { plus, zeros, width, decimals, exponent })
    }

    /// The number that the printed one stands for.
    pub(crate) fn rounded(self, number: f64) -> f64 {
        let mut text = Packet::new();
        let is_whole = self.print(number, &mut text);
        let digits = std::str::from_utf8(text.as_slice()).unwrap_or_default();
        let printed = digits.trim_start().parse().ok();
        printed.filter(|_| is_whole).unwrap_or(number)
    }

    pub(super) const fn has_exponent(self) -> bool {
        self.exponent.is_some()
    }

    /// Printing changes a number by at most half of this. Zero with an exponent: the steps are as large as the number is.
    pub(crate) fn resolution(self) -> f64 {
        if self.has_exponent() {
            return 0.0;
        }
        libm::exp10(-(self.decimals.unwrap_or(DECIMALS_UNSAID) as f64))
    }

    /// Maximum length of the number in bytes.
    pub(super) fn longest(self, number: f64) -> usize {
        if self.has_exponent() {
            let decimals = self.decimals.unwrap_or(MANTISSA_DECIMALS_UNSAID);
            let sign = usize::from(self.plus || number < 0.0);
            return (sign + "1.".len() + decimals + EXPONENT_LONGEST).max(self.width);
        }
        let decimals = self.decimals.unwrap_or(DECIMALS_UNSAID);
        let digits = match self.plus {
            true => format!("{number:+.decimals$}"),
            false => format!("{number:.decimals$}"),
        };
        digits.len().max(self.width)
    }

    /// Appends `number`; `false` if the packet is full.
    pub(super) fn print(self, number: f64, to: &mut Packet) -> bool {
        let width = self.width;
        if let Some(letter) = self.exponent {
            return self.print_with_exponent(number, letter, to).is_some();
        }
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

    fn print_with_exponent(self, number: f64, letter: char, to: &mut Packet) -> Option<()> {
        let decimals = self.decimals.unwrap_or(MANTISSA_DECIMALS_UNSAID);
        let text = format!("{:.decimals$e}", number.abs());
        let (mantissa, exponent) = text.split_once('e')?;
        let exponent: i32 = exponent.parse().ok()?;
        let digits = format!("{mantissa}{letter}{exponent:+03}");
        let sign = match (number < 0.0, self.plus) {
            (true, _) => "-",
            (false, true) => "+",
            (false, false) => "",
        };
        let before = self.width.saturating_sub(sign.len() + digits.len());
        match self.zeros {
            true => write!(to, "{sign}{:0>before$}{digits}", "").ok(),
            false => write!(to, "{:before$}{sign}{digits}", "").ok(),
        }
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

#[cfg(test)]
mod tests {
    use super::{Format, Match, number_length};
    use wire::packet::Packet;

    /// The answers NR3 of an instrument (IEEE 488.2).
    #[test]
    fn numbers_have_an_exponent() {
        for (format, number, expected) in [
            ("+.5E", 12.0, "+1.20000E+01"),
            (".2E", -0.001_234, "-1.23E-03"),
            ("+.1e", 0.0, "+0.0e+00"),
            (".0E", 9.96e120, "1E+121"),
            ("E", 1.5, "1.500000E+00"),
            ("012.2E", -1.5, "-0001.50E+00"),
            ("12.2E", -1.5, "   -1.50E+00"),
        ] {
            let format = Format::parse(format).unwrap();
            let mut packet = Packet::new();
            assert!(format.print(number, &mut packet));
            let text = std::str::from_utf8(packet.as_slice()).unwrap();
            assert_eq!(text, expected);
            assert!(format.longest(number) >= text.len(), "{text}");
            assert_eq!(format.rounded(number), text.trim_start().parse::<f64>().unwrap());
            let line = format!("{text}\n");
            let whole = Match::Whole(text.len());
            assert_eq!(number_length(line.as_bytes(), format.width > 0), whole);
        }
        // A sign has its place only where it can stand.
        for (format, number, length) in [(".1", 5.0, 3), ("+.1", 5.0, 4), (".1", -5.0, 4)] {
            assert_eq!(Format::parse(format).unwrap().longest(number), length, "{format}");
        }
        for wrong in ["E.2", ".2EE", ".E"] {
            assert_eq!(Format::parse(wrong), None, "{wrong}");
        }
    }
}
