//! Records in blocks with a check, so that no bit of a file changes unnoticed.
//!
//! Behind the [`header`](super::header) a file holds records, each a length and a payload
//! (`encoding.rs`). A length of zero is a mark:
//!
//! | bytes | what |
//! |---|---|
//! | 1 | 0: no record follows |
//! | 1 | 0: the next block follows; 1: this was the last |
//! | 4 | check of the block, this mark included, little-endian |
//! | 8 | `TRAILER`, behind the last block; the end of the file |
//!
//! A check is the CRC-32C of the check before, four zeros for the first, and of the bytes since then: a block that is missing or
//! stands in another place is noticed by the next. Where a block ends depends on its length alone and never on a clock: the same run has the same file.

use crc::{CRC_32_ISCSI, Crc, Table};

/// A block ends with the record that makes it so long. Whoever kills a run leaves at most so much without a check.
pub const BLOCK_BYTES: usize = 16 * 1024;

/// In a mark: another block follows.
pub(super) const NEXT: u8 = 0;

/// In a mark: this was the last block.
pub(super) const END: u8 = 1;

/// The last bytes of a record that was ended. A length that is damaged may lead past them, so that they are looked for at the
/// end of the file and not where the records seem to end.
pub(super) const TRAILER: [u8; 8] = *b"\x89hilend\n";

/// Bytes of a check.
pub(super) const CHECK_BYTES: usize = 4;

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);

/// The check of everything so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Check(u32);

impl Check {
    /// With these bytes behind what was there before.
    pub fn of(self, bytes: &[u8]) -> Self {
        let mut digest = CRC.digest();
        digest.update(&self.bytes());
        digest.update(bytes);
        Self(digest.finalize())
    }

    /// As it stands in a file.
    pub const fn bytes(self) -> [u8; CHECK_BYTES] {
        self.0.to_le_bytes()
    }
}
