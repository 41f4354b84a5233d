//! Times and windows.

use super::Parser;
use super::lexer::{Token, unit_word};
use crate::formula::Interval;
use crate::mistake::Mistake;

/// The longest window. Assumption: an hour is longer than any response that a test waits for, and its events fit in
/// memory.
pub(super) const HORIZON_MAX: i64 = 3_600_000_000_000;

const UNITS: [(&str, f64); 8] = [
    ("ns", 1.0),
    ("us", 1e3),
    ("µs", 1e3),
    ("μs", 1e3),
    ("ms", 1e6),
    ("s", 1e9),
    ("min", 6e10),
    ("h", 3.6e12),
];

/// Tolerance for a time in nanoseconds to count as a whole number: rounding error of floating point.
const ROUNDING: f64 = 1e-3;

impl Parser<'_> {
    /// `[20 ms, 100 ms]`.
    pub(super) fn window(&mut self) -> Result<Interval, Mistake> {
        let start = self.at.start;
        self.expect("[")?;
        let from = self.time()?;
        self.expect(",")?;
        let to = self.time()?;
        self.expect("]")?;
        if to < from {
            let mistake = Mistake::new(start..self.end, "the window ends before it begins");
            return Err(mistake.help("the nearer end comes first, in the past too"));
        }
        Ok(Interval { from, to: Some(to) })
    }

    /// `100 ms` after `within` or `for`.
    pub(super) fn length(&mut self, word: &str) -> Result<Interval, Mistake> {
        if self.is_symbol("[") {
            let (_, long) = if word == "within" { (word, "eventually") } else { (word, "always") };
            let mistake = self.unexpected("a time");
            return Err(mistake.help(format!("write `{word} 100 ms: ...` or `{long} [a, b]: ...`")));
        }
        let start = self.at.start;
        let to = self.time()?;
        if to == 0 {
            let mistake = Mistake::new(start..self.end, format!("`{word}` no time at all"));
            return Err(mistake.help("leave it out, or say how long"));
        }
        Ok(Interval { from: 0, to: Some(to) })
    }

    fn time(&mut self) -> Result<i64, Mistake> {
        let start = self.at.start;
        if self.is_symbol("-") {
            let mistake = Mistake::new(self.at.clone(), "a time is not negative");
            return Err(mistake.help("`once` and `historically` look back"));
        }
        let Token::Number(number) = self.next else {
            return Err(self.unexpected("a time").help("such as `100 ms`"));
        };
        let unit = unit_word(self.text, self.at.end);
        let Some(unit_at) = unit else {
            let at = self.at.clone();
            self.advance()?;
            if number == 0.0 {
                return Ok(0);
            }
            let said = self.said(&at);
            return Err(Mistake::new(at, "a time has a unit").help(format!("such as `{said} ms`")));
        };
        let word = self.said(&unit_at);
        let Some((_, nanos)) = UNITS.iter().find(|(unit, _)| *unit == word) else {
            let mistake = Mistake::new(unit_at, format!("`{word}` is no unit of time"));
            return Err(mistake.help("times are in ns, us, ms, s, min or h"));
        };
        self.at = unit_at;
        self.advance()?;
        let nanos = number * nanos;
        let at = start..self.end;
        if nanos > HORIZON_MAX as f64 {
            return Err(Mistake::new(at, "longer than an hour").help("the longest is `1 h`"));
        }
        let is_lost = nanos.round() == 0.0 && number != 0.0;
        if is_lost || (nanos - nanos.round()).abs() > ROUNDING {
            let mistake = Mistake::new(at, "finer than a nanosecond, which no clock here tells");
            return Err(mistake.help("write a whole number of nanoseconds"));
        }
        Ok(nanos.round() as i64)
    }
}
