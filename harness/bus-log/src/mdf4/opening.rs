//! Reads the start of a file: identification and header.

use super::super::error::LogError;
use super::blocks::{Block, Source};
use super::{FILE_MARK, IDENTIFICATION_BYTES, UNFINISHED_MARK};

/// Unfinished parts that do not matter here: counts of records, the length of the last data block, and the bytes of a
/// variable-length group.
const UNFINISHED: u16 = 0x2f;

pub(super) struct Opened {
    /// Whether its writer did not finish it.
    pub(super) is_unfinished: bool,
    pub(super) header: Block,
}

pub(super) fn open(source: &mut Source<'_>) -> Result<Opened, LogError> {
    let mut head = [0; IDENTIFICATION_BYTES];
    source.at(0, &mut head)?;
    let is_finished = head.starts_with(FILE_MARK);
    let version = u16::from_le_bytes([head[28], head[29]]);
    let unfinished = u16::from_le_bytes([head[60], head[61]]);
    if !is_finished && !head.starts_with(UNFINISHED_MARK) {
        return source.bad(
            0,
            "`MDF` and its version",
            String::from_utf8_lossy(&head[..8]).as_bytes(),
        );
    }
    if !(400..500).contains(&version) {
        return source.bad(0, "version 4 of MDF", format!("version {version}"));
    }
    if !is_finished && unfinished & !UNFINISHED != 0 {
        return source.bad(
            0,
            "a file that its logger finished",
            format!("flags {unfinished:#06x}"),
        );
    }
    let header = source.block(IDENTIFICATION_BYTES as u64, "##HD")?;
    Ok(Opened { is_unfinished: !is_finished, header })
}
