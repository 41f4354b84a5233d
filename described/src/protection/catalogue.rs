//! Checksums by name.

use crate::error::Read;
use crate::hint;
use crate::place::Place;
use crc::{Algorithm, Crc, NoTable};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Checksum {
    /// The sum of the bytes modulo 256.
    Sum8,
    /// Exclusive or of all bytes.
    Xor8,
    Crc8(&'static Algorithm<u8>),
    Crc16(&'static Algorithm<u16>),
    Crc32(&'static Algorithm<u32>),
}

impl Checksum {
    /// The checksum `name`: `sum8`, `xor8`, or a CRC of the catalogue (`crc16-modbus`).
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "sum8" => return Some(Self::Sum8),
            "xor8" => return Some(Self::Xor8),
            _ => {}
        }
        CRCS.iter().find(|(constant, _)| written(constant) == name).map(|(_, crc)| *crc)
    }

    /// The checksum whose name is at `place`.
    pub(crate) fn at(name: &str, place: &Place) -> Read<Self> {
        Self::named(name).ok_or_else(|| {
            let known: Vec<_> = Self::names().collect();
            place.mistake(format!("no checksum `{name}`")).help(hint::proposal(name, &known))
        })
    }

    /// All names known to [`Checksum::named`].
    pub(crate) fn names() -> impl Iterator<Item = String> {
        let sums = ["sum8", "xor8"].map(str::to_owned);
        sums.into_iter().chain(CRCS.iter().map(|(constant, _)| written(constant)))
    }

    /// Length in bytes.
    pub(crate) const fn length(self) -> usize {
        match self {
            Self::Sum8 | Self::Xor8 | Self::Crc8(_) => 1,
            Self::Crc16(_) => 2,
            Self::Crc32(_) => 4,
        }
    }

    /// The checksum of these bytes.
    pub(crate) fn value(self, data: &[u8]) -> u32 {
        match self {
            Self::Sum8 => u32::from(data.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte))),
            Self::Xor8 => u32::from(data.iter().fold(0, |sum, byte| sum ^ byte)),
            // Without tables: messages are short, and the layout stays small.
            Self::Crc8(algorithm) => u32::from(Crc::<u8, NoTable>::new(algorithm).checksum(data)),
            Self::Crc16(algorithm) => u32::from(Crc::<u16, NoTable>::new(algorithm).checksum(data)),
            Self::Crc32(algorithm) => Crc::<u32, NoTable>::new(algorithm).checksum(data),
        }
    }
}

/// The CRCs by their constants, which have the names of the catalogue of parametrised CRC algorithms
/// (reveng.sourceforge.io).
macro_rules! crcs {
    ($($kind:ident: $($name:ident)+;)+) => {
        const CRCS: &[(&str, Checksum)] =
            &[$($((stringify!($name), Checksum::$kind(&crc::$name)),)+)+];
    };
}

crcs! {
    Crc8: CRC_8_AUTOSAR CRC_8_BLUETOOTH CRC_8_CDMA2000 CRC_8_DARC CRC_8_DVB_S2 CRC_8_GSM_A
        CRC_8_GSM_B CRC_8_HITAG CRC_8_I_432_1 CRC_8_I_CODE CRC_8_LTE CRC_8_MAXIM_DOW
        CRC_8_MIFARE_MAD CRC_8_NRSC_5 CRC_8_OPENSAFETY CRC_8_ROHC CRC_8_SAE_J1850 CRC_8_SMBUS
        CRC_8_TECH_3250 CRC_8_WCDMA;
    Crc16: CRC_16_ARC CRC_16_CDMA2000 CRC_16_CMS CRC_16_DDS_110 CRC_16_DECT_R CRC_16_DECT_X
        CRC_16_DNP CRC_16_EN_13757 CRC_16_GENIBUS CRC_16_GSM CRC_16_IBM_3740 CRC_16_IBM_SDLC
        CRC_16_ISO_IEC_14443_3_A CRC_16_KERMIT CRC_16_LJ1200 CRC_16_M17 CRC_16_MAXIM_DOW
        CRC_16_MCRF4XX CRC_16_MODBUS CRC_16_NRSC_5 CRC_16_OPENSAFETY_A CRC_16_OPENSAFETY_B
        CRC_16_PROFIBUS CRC_16_RIELLO CRC_16_SPI_FUJITSU CRC_16_T10_DIF CRC_16_TELEDISK
        CRC_16_TMS37157 CRC_16_UMTS CRC_16_USB CRC_16_XMODEM;
    Crc32: CRC_32_AIXM CRC_32_AUTOSAR CRC_32_BASE91_D CRC_32_BZIP2 CRC_32_CD_ROM_EDC CRC_32_CKSUM
        CRC_32_ISCSI CRC_32_ISO_HDLC CRC_32_JAMCRC CRC_32_MEF CRC_32_MPEG_2 CRC_32_XFER;
}

/// The name in files: `crc16-ibm-sdlc` for `CRC_16_IBM_SDLC`.
fn written(constant: &str) -> String {
    constant.replacen('_', "", 1).replace('_', "-").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::{CRCS, Checksum, written};

    #[test]
    fn every_crc_has_the_check_value_of_the_catalogue() {
        let value = |name: &str| Checksum::named(name).unwrap().value(b"123456789");
        for (constant, crc) in CRCS {
            let check = match crc {
                Checksum::Crc8(algorithm) => u32::from(algorithm.check),
                Checksum::Crc16(algorithm) => u32::from(algorithm.check),
                Checksum::Crc32(algorithm) => algorithm.check,
                Checksum::Sum8 | Checksum::Xor8 => unreachable!("not in the catalogue"),
            };
            assert_eq!(value(&written(constant)), check, "{constant}");
        }
        for name in ["sum8", "crc8-sae-j1850", "crc16-iso-iec-14443-3-a", "crc32-iso-hdlc"] {
            assert!(Checksum::names().any(|known| known == name), "{name}");
        }
        assert_eq!(Checksum::names().count(), 65);
    }

    #[test]
    fn sums_are_known_by_hand() {
        assert_eq!(Checksum::Sum8.value(&[0xff, 0x02]), 1);
        assert_eq!(Checksum::Xor8.value(&[0xff, 0x02]), 0xfd);
        assert_eq!(Checksum::named("crc17"), None);
    }
}
