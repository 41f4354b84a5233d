//! Lays out the blocks of a file, and the common start of all files.

use super::{BLOCK_HEAD_BYTES, CN_MASTER, FILE_MARK, IDENTIFICATION_BYTES, UNFINISHED_MARK};
use std::fmt::Write as _;

const HEADER_BYTES: usize = 104;

/// Length of identification and header, which precede all other blocks.
pub(super) const BEGIN_BYTES: usize = IDENTIFICATION_BYTES + HEADER_BYTES;

/// Data types of channels.
pub(super) const UNSIGNED: u8 = 0;
pub(super) const SIGNED: u8 = 2;
pub(super) const FLOAT: u8 = 4;
pub(super) const UTF8: u8 = 7;
pub(super) const BYTES: u8 = 10;

/// The records of a group.
pub(super) struct Records {
    pub(super) count: u64,
    pub(super) flags: u64,
    pub(super) bytes: u32,
    pub(super) invalid_bytes: u32,
}

/// The values of a channel, from byte `at` of a record on.
pub(super) struct Values {
    pub(super) kind: u8,
    pub(super) data_type: u8,
    pub(super) at: u32,
    pub(super) bytes: u32,
    pub(super) flags: u32,
    pub(super) invalid_bit: u32,
}

/// Blocks in file order, with the targets of links first.
pub(super) struct Blocks {
    /// Address of the first byte.
    place: u64,
    bytes: Vec<u8>,
}

impl Blocks {
    /// At the start of a file, with room for [`begin`].
    pub(super) fn behind_begin() -> Self {
        Self { place: 0, bytes: vec![0; BEGIN_BYTES] }
    }

    /// From that address of a file on.
    pub(super) const fn at(place: u64) -> Self {
        Self { place, bytes: Vec::new() }
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    pub(super) fn push(&mut self, mark: &[u8; 4], links: &[u64], data: &[u8]) -> u64 {
        let address = self.place + self.bytes.len() as u64;
        push_block(&mut self.bytes, *mark, links, data);
        address
    }

    /// Appends a text; returns its address, or zero, a null link, for an empty one.
    pub(super) fn text(&mut self, text: &str) -> u64 {
        // A zero byte ends a text.
        match text.split('\0').next().unwrap_or_default() {
            "" => 0,
            text => self.push(b"##TX", &[], format!("{text}\0").as_bytes()),
        }
    }

    /// Appends a group of channels with one kind of record, and the data group around it. `links` are its first
    /// channel, name, source and comment; `data` is the address of its records, zero if there are none.
    pub(super) fn group(&mut self, links: [u64; 4], records: Records, data: u64, next: u64) -> u64 {
        let Records { count, flags, bytes, invalid_bytes } = records;
        let [first, name, source, comment] = links;
        // Its records have no record number.
        let mut content = [0, count, flags].map(u64::to_le_bytes).concat();
        content.extend([bytes, invalid_bytes].map(u32::to_le_bytes).concat());
        let group = self.push(b"##CG", &[0, first, name, source, 0, comment], &content);
        self.push(b"##DG", &[next, group, data, 0], &[0; 8])
    }

    /// Appends a channel. `links` are the next channel, the components, the name, the source, the conversion, the data,
    /// the unit and the comment.
    pub(super) fn channel(&mut self, links: [u64; 8], values: Values) -> u64 {
        let Values { kind, data_type, at, bytes, flags, invalid_bit } = values;
        // The master channel is a time.
        let mut content = vec![kind, u8::from(kind == CN_MASTER), data_type, 0];
        content.extend([at, 8 * bytes, flags, invalid_bit].map(u32::to_le_bytes).concat());
        content.resize(72, 0);
        self.push(b"##CN", &links, &content)
    }

    /// Appends a conversion of that type, to what `references` refer to.
    pub(super) fn conversion(
        &mut self,
        kind: u8,
        unit: u64,
        references: &[u64],
        values: &[f64],
    ) -> u64 {
        let counts = [references.len() as u16, values.len() as u16].map(u16::to_le_bytes).concat();
        let mut content = [&[kind, 0, 0, 0], &counts[..], &[0; 16]].concat();
        content.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self.push(b"##CC", &[&[0, unit, 0, 0], references].concat(), &content)
    }

    /// Appends the file history. `began` is in nanoseconds since 1970: no clock is read here, so the file is as old as
    /// its contents.
    pub(super) fn history(&mut self, began: u64) -> u64 {
        let version = env!("CARGO_PKG_VERSION");
        let comment = self.push(
            b"##MD",
            &[],
            format!(
                "<FHcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX>written by hil</TX><tool_id>hil</tool_id>\
                 <tool_vendor>hil</tool_vendor><tool_version>{version}</tool_version></FHcomment>\0"
            )
            .as_bytes(),
        );
        self.push(b"##FH", &[0, comment], &[&began.to_le_bytes()[..], &[0; 8]].concat())
    }
}

/// Identification and header, [`BEGIN_BYTES`] long. `groups`, `history` and `comment` are the addresses of those
/// blocks; zero is a null link.
pub(super) fn begin(
    is_finished: bool,
    began: u64,
    groups: u64,
    history: u64,
    comment: u64,
) -> Vec<u8> {
    let mut bytes = vec![0; IDENTIFICATION_BYTES];
    let mark = if is_finished { FILE_MARK } else { UNFINISHED_MARK };
    bytes[..8].copy_from_slice(mark);
    bytes[8..24].copy_from_slice(b"4.10    hil     ");
    bytes[28..30].copy_from_slice(&410u16.to_le_bytes());
    // While unfinished: the counts of records are invalid.
    bytes[60] = u8::from(!is_finished);
    // Offsets of the time zone are valid, and zero.
    let data = [&began.to_le_bytes()[..], &[0; 4], &[2], &[0; 19]].concat();
    push_block(&mut bytes, *b"##HD", &[groups, history, 0, 0, 0, comment], &data);
    bytes
}

/// The comment of the header, with a terminating zero.
pub(super) fn comment<N: AsRef<str>>(facts: &[(N, String)]) -> String {
    let mut text =
        "<HDcomment xmlns=\"http://www.asam.net/mdf/v4\"><TX></TX><common_properties>".to_owned();
    for (name, value) in facts {
        // Writing to a string does not fail.
        let _ = write!(text, "<e name=\"{}\">{}</e>", escaped(name.as_ref()), escaped(value));
    }
    text + "</common_properties></HDcomment>\0"
}

/// Escapes text for XML 1.0. Characters that XML does not allow become spaces.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\r' | '\t' => escaped.push(character),
            other if other.is_control() || matches!(other, '\u{fffe}' | '\u{ffff}') => {
                escaped.push(' ')
            }
            other => escaped.push(other),
        }
    }
    escaped
}

/// Appends a block to `out`, padded to a multiple of eight bytes.
pub(super) fn push_block(out: &mut Vec<u8>, mark: [u8; 4], links: &[u64], data: &[u8]) {
    let length = BLOCK_HEAD_BYTES + 8 * links.len() + data.len();
    out.extend(mark);
    out.extend([0; 4]);
    out.extend((length as u64).to_le_bytes());
    out.extend((links.len() as u64).to_le_bytes());
    out.extend(links.iter().flat_map(|link| link.to_le_bytes()));
    out.extend_from_slice(data);
    out.resize(out.len().next_multiple_of(8), 0);
}
