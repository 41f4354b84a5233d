//! AUTOSAR's end-to-end protection: profiles 1, 2, 4 and 5 of its "E2E Protocol Specification" (document 849).

use crate::bits::BitField;
use crate::file::ByteOrder;
use crc::{Crc, NoTable};

/// The counter of profile 1 never has the number 15.
pub(crate) const PROFILE_1_COUNTER_MAX: u64 = 14;

/// A profile and its data id. The counter is a [`super::Counter`] beside it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum E2e {
    /// CRC-8 of SAE J1850, in one byte anywhere.
    Profile1 { data_id: DataId, crc_at: usize },
    /// CRC-8 of the polynomial 0x2f in byte 0; one data id per counter number.
    Profile2 { data_ids: [u8; 16] },
    /// CRC-32 of the polynomial 0xf4acfb13; length and data id are sent. `at`: the first byte of the header.
    Profile4 { data_id: u32, at: usize },
    /// CRC-16 of CCITT. `at`: the first byte of the header.
    Profile5 { data_id: u16, at: usize },
}

/// Use of the data id in profile 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DataId {
    /// 1A: both bytes are in the CRC.
    Both(u16),
    /// 1B: the low byte for even counter numbers, the high one for odd ones.
    Alternating(u16),
    /// 1C: the low byte is in the CRC, and the low nibble of the high byte is sent, from this bit on.
    Nibble(u16, usize),
}

/// The CRC of several parts.
macro_rules! crc_of {
    ($word:ty, $algorithm:ident, $parts:expr) => {{
        let crc = Crc::<$word, NoTable>::new(&crc::$algorithm);
        let mut digest = crc.digest();
        $parts.iter().for_each(|part: &&[u8]| digest.update(part));
        digest.finalize().into()
    }};
}

impl E2e {
    /// Fills in the fields beside counter and CRC.
    pub(super) fn prepare(&self, data: &mut [u8]) {
        for (field, number) in self.header(data.len()).into_iter().flatten() {
            field.set(data, number);
        }
    }

    /// True if the fields of [`E2e::prepare`] have their values.
    pub(super) fn is_prepared(&self, data: &[u8]) -> bool {
        let mut header = self.header(data.len()).into_iter().flatten();
        header.all(|(field, number)| field.get(data) == number)
    }

    /// Fields that are equal in all messages of a length, with their values.
    fn header(&self, length: usize) -> [Option<(BitField, u64)>; 2] {
        let big = |byte: usize, bits: u64| {
            BitField::new(ByteOrder::Big, 8 * byte as u64 + 7, bits, length)
        };
        match self {
            Self::Profile1 { data_id: DataId::Nibble(id, bit), .. } => {
                let nibble = BitField::new(ByteOrder::Little, *bit as u64, 4, length);
                [nibble.map(|field| (field, u64::from(id >> 8))), None]
            }
            Self::Profile1 { .. } | Self::Profile2 { .. } | Self::Profile5 { .. } => [None, None],
            Self::Profile4 { data_id, at } => [
                big(*at, 16).map(|field| (field, length as u64)),
                big(at + 4, 32).map(|field| (field, u64::from(*data_id))),
            ],
        }
    }

    /// The position of the CRC in a message of this length.
    pub(crate) fn crc_field(&self, length: usize) -> Option<BitField> {
        match self {
            Self::Profile1 { crc_at, .. } => {
                BitField::new(ByteOrder::Little, 8 * *crc_at as u64, 8, length)
            }
            Self::Profile2 { .. } => BitField::new(ByteOrder::Little, 0, 8, length),
            Self::Profile4 { at, .. } => {
                BitField::new(ByteOrder::Big, 8 * (at + 8) as u64 + 7, 32, length)
            }
            Self::Profile5 { at, .. } => {
                BitField::new(ByteOrder::Little, 8 * *at as u64, 16, length)
            }
        }
    }

    pub(super) fn crc(&self, data: &[u8], counter: u64) -> u64 {
        match self {
            Self::Profile1 { data_id, crc_at } => {
                let id = match data_id {
                    DataId::Both(id) => &id.to_le_bytes()[..],
                    DataId::Alternating(id) => &[id.to_le_bytes()[usize::from(counter % 2 == 1)]],
                    DataId::Nibble(id, _) => &[id.to_le_bytes()[0], 0],
                };
                let (before, behind) = around(data, *crc_at, 1);
                // The polynomial of SAE J1850. AUTOSAR's routine starts at 0xff and inverts at the end, and the
                // profile's calls cancel both: the catalogue lists this variant under GSM.
                crc_of!(u8, CRC_8_GSM_A, [id, before, behind])
            }
            Self::Profile2 { data_ids } => {
                let (_, behind) = around(data, 0, 1);
                crc_of!(u8, CRC_8_AUTOSAR, [behind, &[data_ids[(counter % 16) as usize]]])
            }
            Self::Profile4 { at, .. } => {
                let (before, behind) = around(data, at + 8, 4);
                crc_of!(u32, CRC_32_AUTOSAR, [before, behind])
            }
            Self::Profile5 { data_id, at } => {
                let (before, behind) = around(data, *at, 2);
                crc_of!(u16, CRC_16_IBM_3740, [before, behind, &data_id.to_le_bytes()])
            }
        }
    }
}

/// The bytes before and after `length` bytes from byte `at` on.
fn around(data: &[u8], at: usize, length: usize) -> (&[u8], &[u8]) {
    (data.get(..at).unwrap_or(data), data.get(at + length..).unwrap_or_default())
}
