//! Lays out the blocks of a file, and the common start of all files.

use super::{BLOCK_HEAD_BYTES, FILE_MARK, IDENTIFICATION_BYTES, UNFINISHED_MARK};

const HEADER_BYTES: usize = 104;

/// Length of identification and header, which precede all other blocks.
pub(super) const BEGIN_BYTES: usize = IDENTIFICATION_BYTES + HEADER_BYTES;

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
