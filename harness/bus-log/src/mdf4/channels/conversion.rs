//! Converts the number in a record to the value of a channel (`CC` blocks).

use super::super::super::error::LogError;
use super::super::blocks::Source;

/// Most levels of nested conversions.
const DEPTH_MAX: u32 = 4;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Conversion {
    /// None (0).
    Same,
    /// Linear (1): offset and factor.
    Linear(f64, f64),
    /// Rational (2): P1 to P6.
    Rational([f64; 6]),
    /// Value to value, with interpolation (4) or to the nearest (5).
    Table { pairs: Vec<(f64, f64)>, interpolates: bool },
    /// Range to value (6): both ends and the value of each range, and the default.
    Ranges { ranges: Vec<[f64; 3]>, ends: Ends, default: f64 },
    /// Value to text (7) and range to text (8): both ends and the meaning, and the default.
    Texts { texts: Vec<(f64, f64, Meaning)>, ends: Ends, default: Box<Meaning> },
}

/// To which range an upper end belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    /// To this range: ranges of whole numbers.
    Within,
    /// To the next range: ranges of real numbers.
    Beyond,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Meaning {
    Text(String),
    Number(Conversion),
}

impl Conversion {
    /// Reads the conversion at that address; zero means none.
    pub(super) fn read(
        source: &mut Source<'_>,
        address: u64,
        ends: Ends,
    ) -> Result<Self, LogError> {
        Self::nested(source, address, ends, DEPTH_MAX)
    }

    fn nested(
        source: &mut Source<'_>,
        address: u64,
        ends: Ends,
        depth: u32,
    ) -> Result<Self, LogError> {
        if address == 0 {
            return Ok(Self::Same);
        }
        let block = source.block(address, "##CC")?;
        let (links, data) = source.whole(&block)?;
        let values = data.get(24..).unwrap_or_default().as_chunks().0;
        let values: Vec<f64> = values.iter().map(|value| f64::from_le_bytes(*value)).collect();
        let count = usize::from(block.u16(6));
        let references = links.get(4..).unwrap_or_default();
        let kind = block.u8(0);
        let Some(values) = values.get(..count) else {
            return source.bad(address, "as many values as a conversion says", format!("{count}"));
        };
        Ok(match (kind, values) {
            (0, _) => Self::Same,
            (1, [offset, factor, ..]) => Self::Linear(*offset, *factor),
            (2, [a, b, c, d, e, f, ..]) => Self::Rational([*a, *b, *c, *d, *e, *f]),
            (4 | 5, [_, _, ..]) => {
                let pairs: Vec<_> = values.as_chunks().0.iter().map(|[x, y]| (*x, *y)).collect();
                if !pairs.is_sorted_by(|one, other| one.0 < other.0) {
                    return source.bad(address, "a table whose values ascend", "another");
                }
                Self::Table { pairs, interpolates: kind == 4 }
            }
            (6, [ranges @ .., default]) => {
                Self::Ranges { ranges: ranges.as_chunks().0.to_vec(), ends, default: *default }
            }
            (7 | 8, _) => {
                let ranges: Vec<[f64; 2]> = match kind {
                    7 => values.iter().map(|value| [*value; 2]).collect(),
                    _ => values.as_chunks().0.to_vec(),
                };
                if references.len() < ranges.len() {
                    return source.bad(
                        address,
                        "a text for each value",
                        format!("{}", references.len()),
                    );
                }
                let mut texts = Vec::new();
                for ([low, high], reference) in ranges.iter().zip(references) {
                    texts.push((*low, *high, Meaning::read(source, *reference, ends, depth)?));
                }
                let default = references.get(texts.len()).copied().unwrap_or(0);
                let default = Box::new(Meaning::read(source, default, ends, depth)?);
                Self::Texts { texts, ends, default }
            }
            (kind, values) => {
                let found = format!("kind {kind} with {} values", values.len());
                let expected = "a linear or rational conversion, or a table";
                return source.bad(address, expected, &found);
            }
        })
    }

    /// The value as a number. A number that stands for a text is not changed.
    pub(super) fn number(&self, raw: f64) -> f64 {
        match self {
            Self::Same => raw,
            Self::Linear(offset, factor) => offset + factor * raw,
            Self::Rational([a, b, c, d, e, f]) => {
                (a * raw * raw + b * raw + c) / (d * raw * raw + e * raw + f)
            }
            Self::Table { pairs, interpolates } => in_table(pairs, *interpolates, raw),
            Self::Ranges { ranges, ends, default } => {
                let is_in = |range: &&[f64; 3]| ends.holds(raw, range[0], range[1]);
                ranges.iter().find(is_in).map_or(*default, |range| range[2])
            }
            Self::Texts { .. } => match self.meaning(raw) {
                Some(Meaning::Number(conversion)) => conversion.number(raw),
                _ => raw,
            },
        }
    }

    pub(super) fn text(&self, raw: f64) -> Option<&str> {
        match self.meaning(raw)? {
            Meaning::Text(text) => Some(text),
            Meaning::Number(conversion) => conversion.text(raw),
        }
    }

    fn meaning(&self, raw: f64) -> Option<&Meaning> {
        let Self::Texts { texts, ends, default } = self else { return None };
        let found = texts.iter().find(|(low, high, _)| ends.holds(raw, *low, *high));
        Some(found.map_or(default, |(_, _, meaning)| meaning))
    }
}

impl Meaning {
    fn read(
        source: &mut Source<'_>,
        address: u64,
        ends: Ends,
        depth: u32,
    ) -> Result<Self, LogError> {
        if address == 0 {
            return Ok(Self::Number(Conversion::Same));
        }
        if source.any_block(address)?.mark() != b"##CC" {
            return source.text(address).map(Self::Text);
        }
        let Some(depth) = depth.checked_sub(1) else {
            return source.bad(address, "conversions that lead to an end", b"more of them");
        };
        Conversion::nested(source, address, ends, depth).map(Self::Number)
    }
}

impl Ends {
    fn holds(self, raw: f64, low: f64, high: f64) -> bool {
        raw == low || (low < raw && (raw < high || (self == Self::Within && raw == high)))
    }
}

/// Values beyond the table map to its ends; halfway between two entries the lower one is nearest.
fn in_table(pairs: &[(f64, f64)], interpolates: bool, raw: f64) -> f64 {
    let above = pairs.partition_point(|(x, _)| *x <= raw);
    let (below, above) = (above.checked_sub(1).and_then(|at| pairs.get(at)), pairs.get(above));
    match (below, above) {
        (Some((x, y)), Some((next_x, next_y))) if interpolates => {
            y + (next_y - y) * (raw - x) / (next_x - x)
        }
        (Some((x, y)), Some((next_x, next_y))) => {
            if raw - x > next_x - raw {
                *next_y
            } else {
                *y
            }
        }
        (Some((_, y)), None) | (None, Some((_, y))) => *y,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::{Conversion, Ends, Meaning};

    #[test]
    fn each_kind_gives_its_numbers() {
        let pairs = vec![(0.0, 10.0), (2.0, 20.0), (4.0, 0.0)];
        let table = |interpolates| Conversion::Table { pairs: pairs.clone(), interpolates };
        let at = |conversion: &Conversion, raws: [f64; 5]| raws.map(|raw| conversion.number(raw));
        let raws = [-1.0, 0.5, 1.0, 3.5, 9.0];
        assert_eq!(at(&table(true), raws), [10.0, 12.5, 15.0, 5.0, 0.0]);
        assert_eq!(at(&table(false), raws), [10.0, 10.0, 10.0, 0.0, 0.0]);
        assert_eq!(Conversion::Linear(-40.0, 0.5).number(100.0), 10.0);
        // 1 / x, and (2 x + 4) / 2.
        assert_eq!(Conversion::Rational([0.0, 0.0, 1.0, 0.0, 1.0, 0.0]).number(4.0), 0.25);
        assert_eq!(Conversion::Rational([0.0, 2.0, 4.0, 0.0, 0.0, 2.0]).number(3.0), 5.0);
        let ranges = vec![[0.0, 1.0, 7.0], [1.0, 2.0, 8.0]];
        let ranges = |ends| Conversion::Ranges { ranges: ranges.clone(), ends, default: -1.0 };
        let raws = [0.0, 1.0, 1.2, 2.0, 2.5];
        assert_eq!(at(&ranges(Ends::Beyond), raws), [7.0, 8.0, 8.0, -1.0, -1.0]);
        assert_eq!(at(&ranges(Ends::Within), raws), [7.0, 7.0, 8.0, 8.0, -1.0]);
    }

    #[test]
    fn names_of_values_are_texts_and_stay_numbers() {
        let text = |text: &str| Meaning::Text(text.to_owned());
        let names = vec![(0.0, 0.0, text("off")), (1.0, 1.0, text("on"))];
        let rest = Meaning::Number(Conversion::Linear(0.0, 2.0));
        let default = Box::new(rest);
        let named = Conversion::Texts { texts: names, ends: Ends::Within, default };
        assert_eq!([0.0, 1.0, 2.0].map(|raw| named.text(raw)), [Some("off"), Some("on"), None]);
        assert_eq!([0.0, 1.0, 2.0].map(|raw| named.number(raw)), [0.0, 1.0, 4.0]);
    }
}
