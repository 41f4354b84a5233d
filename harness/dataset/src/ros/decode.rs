//! Values of a serialised message.
//!
//! Source: wiki.ros.org/msg (ROS 1: little endian, without padding) and OMG DDS-XTypes 1.3, section 7.4 (ROS 2: CDR).

use super::super::channels::Cell;
use super::definition::{Count, Definition, Kind, Number};

/// A requested value.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Want {
    /// The way to it; see [`Definition::path`].
    pub path: Vec<u32>,
    /// Index of its cell.
    pub slot: usize,
}

/// How messages are serialised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ros1,
    /// After an encapsulation header.
    Cdr,
}

/// Puts the requested values, in order of their paths, into `cells`. Elements that an array does not have leave theirs as
/// they are.
pub(super) fn decode(
    definition: &Definition,
    encoding: Encoding,
    data: &[u8],
    wants: &[Want],
    cells: &mut [Cell],
) -> Result<(), String> {
    let (data, little, padded) = match encoding {
        Encoding::Ros1 => (data, true, false),
        Encoding::Cdr => match data {
            [0, order @ (0 | 1), _, _, data @ ..] => (data, *order == 1, true),
            [0, kind, _, _, ..] => {
                return Err(format!("found the encapsulation {kind}, expected CDR (0 or 1)"));
            }
            _ => return Err("found no encapsulation header, expected CDR".to_owned()),
        },
    };
    let mut reader = Reader { definition, data, at: 0, little, padded, cells };
    reader.value(Kind::Message(definition.root()), wants, 0)?;
    match data.len().saturating_sub(reader.at) {
        // CDR may end with padding.
        left if left > 0 && encoding == Encoding::Ros1 => {
            Err(format!("{left} bytes follow the last field of the message"))
        }
        _ => Ok(()),
    }
}

struct Reader<'a> {
    definition: &'a Definition,
    data: &'a [u8],
    at: usize,
    little: bool,
    /// Whether numbers are at multiples of their size.
    padded: bool,
    cells: &'a mut [Cell],
}

impl Reader<'_> {
    /// Reads a value. `wants` are those in it, and `depth` is the length of the way to it.
    fn value(&mut self, kind: Kind, wants: &[Want], depth: usize) -> Result<(), String> {
        let cell = match kind {
            Kind::Number(number) => self.number(number)?,
            Kind::Stamp(seconds, nanoseconds) => {
                self.number(seconds)? + self.number(nanoseconds)? / 1e9
            }
            Kind::Text => return self.text(wants),
            Kind::Message(index) => {
                let message = self.definition.message(index);
                self.check(message.bytes_min)?;
                if message.bytes_min == 0 {
                    return Ok(());
                }
                for (field, number) in message.fields.iter().zip(0..) {
                    let inside = narrow(wants, depth, number);
                    match field.count {
                        Count::One => self.value(field.kind, inside, depth + 1)?,
                        Count::Fixed(count) => {
                            self.array(field.kind, count, inside, depth + 1)?;
                        }
                        Count::Any => {
                            let count = self.length()?;
                            self.array(field.kind, count, inside, depth + 1)?;
                        }
                    }
                }
                return Ok(());
            }
        };
        for want in wants.iter().filter(|_| cell.is_finite()) {
            self.cells[want.slot] = Cell::Number(cell);
        }
        Ok(())
    }

    fn array(
        &mut self,
        kind: Kind,
        count: u32,
        wants: &[Want],
        depth: usize,
    ) -> Result<(), String> {
        let least = self.definition.bytes_min(kind);
        self.check(least.saturating_mul(count.into()))?;
        match kind {
            _ if least == 0 || count == 0 => {}
            // Images and point clouds are long.
            Kind::Number(number) => {
                self.align(number.bytes());
                let begin = self.at;
                for want in wants {
                    let element = want.path[depth];
                    if element < count {
                        self.at = begin + element as usize * number.bytes();
                        self.value(kind, std::slice::from_ref(want), depth + 1)?;
                    }
                }
                self.at = begin;
                self.skip(count as usize * number.bytes())?;
            }
            _ => {
                for element in 0..count {
                    self.value(kind, narrow(wants, depth, element), depth + 1)?;
                }
            }
        }
        Ok(())
    }

    fn text(&mut self, wants: &[Want]) -> Result<(), String> {
        let length = self.length()? as usize;
        let begin = self.at;
        self.skip(length)?;
        if !wants.is_empty() {
            // In CDR, a zero ends it.
            let text = String::from_utf8_lossy(&self.data[begin..self.at]);
            let text = text.trim_end_matches('\0');
            for want in wants {
                self.cells[want.slot] = Cell::Text(text.to_owned());
            }
        }
        Ok(())
    }

    fn length(&mut self) -> Result<u32, String> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn number(&mut self, number: Number) -> Result<f64, String> {
        Ok(match number {
            Number::Bool => f64::from(u8::from(self.bytes::<1>()? != [0])),
            Number::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Number::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Number::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Number::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Number::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Number::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Number::I64 => i64::from_le_bytes(self.bytes()?) as f64,
            Number::U64 => u64::from_le_bytes(self.bytes()?) as f64,
            Number::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Number::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    /// The bytes of a number, the lowest first.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.align(N);
        let found = self.data.get(self.at..).and_then(<[u8]>::first_chunk);
        let mut bytes: [u8; N] = *found.ok_or_else(|| self.short(N as u64))?;
        self.at += N;
        if !self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn align(&mut self, bytes: usize) {
        if self.padded {
            self.at = self.at.next_multiple_of(bytes);
        }
    }

    fn skip(&mut self, bytes: usize) -> Result<(), String> {
        self.check(bytes as u64)?;
        self.at += bytes;
        Ok(())
    }

    /// Whether so many bytes can follow.
    fn check(&self, bytes: u64) -> Result<(), String> {
        let left = self.data.len().saturating_sub(self.at) as u64;
        if bytes > left { Err(self.short(bytes)) } else { Ok(()) }
    }

    fn short(&self, bytes: u64) -> String {
        let (at, length) = (self.at, self.data.len());
        format!("expected {bytes} bytes at byte {at} of a message of {length}")
    }
}

/// Those whose way goes on with `number`.
fn narrow(wants: &[Want], depth: usize, number: u32) -> &[Want] {
    let begin = wants.partition_point(|want| want.path[depth] < number);
    let rest = &wants[begin..];
    &rest[..rest.partition_point(|want| want.path[depth] == number)]
}

#[cfg(test)]
mod tests {
    use super::super::definition::Definition;
    use super::{Cell, Encoding, Want, decode};

    const TEXT: &str = "uint8 flag # a comment\n\
        float64 wide\n\
        string<=8 name\n\
        uint8 LIMIT=3\n\
        int16[<=4] some 1\n\
        Pair[2] pairs\n\
        builtin_interfaces/Time at\n\
        ================================================================================\n\
        MSG: p/Pair\n\
        bool b\n\
        float32 x\n";

    fn values(data: &[u8], encoding: Encoding, names: &[&str]) -> Result<Vec<Option<f64>>, String> {
        let definition = Definition::parse("p/msg/Whole", TEXT, true)?;
        let way =
            |(slot, name): (usize, &&str)| Want { path: definition.path(name).unwrap().0, slot };
        let mut wants: Vec<Want> = names.iter().enumerate().map(way).collect();
        wants.sort();
        let mut cells = vec![Cell::Missing; names.len()];
        decode(&definition, encoding, data, &wants, &mut cells)?;
        let number = |cell: &Cell| match cell {
            Cell::Number(number) => Some(*number),
            _ => None,
        };
        Ok(cells.iter().map(number).collect())
    }

    /// Big endian: the numbers lie at multiples of their size, counted after the encapsulation header.
    const CDR: &[u8] = &[
        0, 0, 0, 0, // encapsulation
        7, 0, 0, 0, 0, 0, 0, 0, // flag
        0x3f, 0xf8, 0, 0, 0, 0, 0, 0, // wide: 1.5
        0, 0, 0, 2, b'n', 0, 0, 0, // name
        0, 0, 0, 1, 0xff, 0xfe, // some: -2
        1, 0, 0x40, 0, 0, 0, // pairs[0]: true, 2.0
        0, 0, 0, 0, 0xbf, 0, 0, 0, // pairs[1]: false, -0.5
        0, 0, 0, 9, 0x1d, 0xcd, 0x65, 0, // at: 9 s and 500,000,000 ns
    ];

    const NAMES: [&str; 7] =
        ["flag", "wide", "some[0]", "some[1]", "pairs[0].x", "pairs[1].x", "at"];
    const FOUND: [Option<f64>; 7] =
        [Some(7.0), Some(1.5), Some(-2.0), None, Some(2.0), Some(-0.5), Some(9.5)];

    #[test]
    fn cdr_is_read_in_both_byte_orders() {
        assert_eq!(values(CDR, Encoding::Cdr, &NAMES).unwrap(), FOUND);
        let mut little = CDR.to_vec();
        little[1] = 1;
        for (begin, bytes) in
            [(12, 8), (20, 4), (28, 4), (32, 2), (36, 4), (44, 4), (48, 4), (52, 4)]
        {
            little[begin..begin + bytes].reverse();
        }
        assert_eq!(values(&little, Encoding::Cdr, &NAMES).unwrap(), FOUND);
        for length in 0..CDR.len() {
            assert!(values(&CDR[..length], Encoding::Cdr, &NAMES).is_err(), "{length} bytes");
        }
        let told = values(&[0, 7, 0, 0, 0], Encoding::Cdr, &NAMES).unwrap_err();
        assert_eq!(told, "found the encapsulation 7, expected CDR (0 or 1)");
    }

    #[test]
    fn a_name_leads_to_one_number() {
        let definition = Definition::parse("p/Whole", TEXT, true).unwrap();
        for none in ["", "pairs", "pairs[2].x", "pairs[0]", "flag[0]", "some", "wide.x", "LIMIT"] {
            assert_eq!(definition.path(none), None, "{none}");
        }
        assert!(definition.path("name").is_some());
    }

    #[test]
    fn definitions_that_cannot_be_read_say_why() {
        let told = |text: &str| Definition::parse("p/A", text, true).unwrap_err();
        assert_eq!(told("p/B b"), "its definition lacks p/B");
        assert_eq!(told("wstring w"), "its definition has a wstring, which is not read");
        assert_eq!(told("A a"), "its definition has more than 32 messages in each other");
        assert!(told("float64").contains("expected a type and a name"));
    }

    #[test]
    fn arrays_of_nothing_cost_no_time() {
        let rule = "=".repeat(80);
        let text =
            format!("B[4000000000] b\n{rule}\nMSG: p/B\nC[4000000000] c\n{rule}\nMSG: p/C\n");
        let empty = Definition::parse("p/A", &text, false).unwrap();
        assert_eq!(decode(&empty, Encoding::Ros1, &[], &[], &mut []), Ok(()));
        let dummies = Definition::parse("p/A", &text, true).unwrap();
        assert!(decode(&dummies, Encoding::Cdr, &[0, 1, 0, 0, 0], &[], &mut []).is_err());
    }
}
