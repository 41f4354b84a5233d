//! The blocks of a record file. Each ends with a checksum, so that every changed bit is detected.
//!
//! After the [`header`](super::header) the file holds records, each a length and a payload (`encoding.rs`). A length of
//! zero is a mark:
//!
//! | bytes | what |
//! |---|---|
//! | 1 | 0: not a record |
//! | 1 | 0: another block follows; 1: this was the last |
//! | 4 | checksum of the block including this mark, little-endian |
//! | 8 | `TRAILER`, after the last block; end of the file |
//!
//! A checksum is the CRC-32C of the previous checksum (four zero bytes for the first) and all bytes since then, so the
//! next checksum reveals a missing or misplaced block. Only its length decides where a block ends, never a clock: the
//! same run gives the same file.

use crc::{CRC_32_ISCSI, Crc, Table};

/// A block ends with the record that reaches this length. A killed run leaves at most this many bytes without a
/// checksum.
pub const BLOCK_BYTES: usize = 16 * 1024;

/// In a mark: another block follows.
pub(super) const NEXT: u8 = 0;

/// In a mark: this was the last block.
pub(super) const END: u8 = 1;

/// The last bytes of a complete record. They are looked for at the end of the file and not after the last record,
/// because a damaged length may point past them.
pub(super) const TRAILER: [u8; 8] = *b"\x89hilend\n";

/// Bytes of a checksum.
pub(super) const CHECK_BYTES: usize = 4;

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);

/// The checksum of everything so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Check(u32);

impl Check {
    /// The checksum after appending these bytes.
    pub fn of(self, bytes: &[u8]) -> Self {
        let mut digest = CRC.digest();
        digest.update(&self.bytes());
        digest.update(bytes);
        Self(digest.finalize())
    }

    /// Its bytes in a file.
    pub const fn bytes(self) -> [u8; CHECK_BYTES] {
        self.0.to_le_bytes()
    }
}
