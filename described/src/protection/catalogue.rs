//! Checksums by name.

use crate::error::Mistake;
use crate::hint;
use crate::place::Place;
use crc::{Algorithm, Crc, NoTable};

/// A checksum algorithm.
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
        find(CRC_8, name)
            .map(Self::Crc8)
            .or_else(|| find(CRC_16, name).map(Self::Crc16))
            .or_else(|| find(CRC_32, name).map(Self::Crc32))
    }

    /// The checksum whose name is at `place`.
    pub(crate) fn at(name: &str, place: &Place) -> Result<Self, Mistake> {
        Self::named(name).ok_or_else(|| {
            let known: Vec<_> = Self::names().collect();
            Mistake::new(place.clone(), format!("no checksum `{name}`"))
                .help(hint::proposal(name, &known))
        })
    }

    /// All names known to [`Checksum::named`].
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        ["sum8", "xor8"]
            .into_iter()
            .chain(CRC_8.iter().map(|(name, _)| *name))
            .chain(CRC_16.iter().map(|(name, _)| *name))
            .chain(CRC_32.iter().map(|(name, _)| *name))
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

type Catalogue<W> = &'static [(&'static str, &'static Algorithm<W>)];

fn find<W: crc::Width>(catalogue: Catalogue<W>, name: &str) -> Option<&'static Algorithm<W>> {
    catalogue.iter().find(|(known, _)| *known == name).map(|(_, algorithm)| *algorithm)
}

// The names are those of the catalogue of parametrised CRC algorithms (reveng.sourceforge.io).
#[rustfmt::skip]
const CRC_8: Catalogue<u8> = &[
    ("crc8-autosar", &crc::CRC_8_AUTOSAR),
    ("crc8-bluetooth", &crc::CRC_8_BLUETOOTH),
    ("crc8-cdma2000", &crc::CRC_8_CDMA2000),
    ("crc8-darc", &crc::CRC_8_DARC),
    ("crc8-dvb-s2", &crc::CRC_8_DVB_S2),
    ("crc8-gsm-a", &crc::CRC_8_GSM_A),
    ("crc8-gsm-b", &crc::CRC_8_GSM_B),
    ("crc8-hitag", &crc::CRC_8_HITAG),
    ("crc8-i-432-1", &crc::CRC_8_I_432_1),
    ("crc8-i-code", &crc::CRC_8_I_CODE),
    ("crc8-lte", &crc::CRC_8_LTE),
    ("crc8-maxim-dow", &crc::CRC_8_MAXIM_DOW),
    ("crc8-mifare-mad", &crc::CRC_8_MIFARE_MAD),
    ("crc8-nrsc-5", &crc::CRC_8_NRSC_5),
    ("crc8-opensafety", &crc::CRC_8_OPENSAFETY),
    ("crc8-rohc", &crc::CRC_8_ROHC),
    ("crc8-sae-j1850", &crc::CRC_8_SAE_J1850),
    ("crc8-smbus", &crc::CRC_8_SMBUS),
    ("crc8-tech-3250", &crc::CRC_8_TECH_3250),
    ("crc8-wcdma", &crc::CRC_8_WCDMA),
];

#[rustfmt::skip]
const CRC_16: Catalogue<u16> = &[
    ("crc16-arc", &crc::CRC_16_ARC),
    ("crc16-cdma2000", &crc::CRC_16_CDMA2000),
    ("crc16-cms", &crc::CRC_16_CMS),
    ("crc16-dds-110", &crc::CRC_16_DDS_110),
    ("crc16-dect-r", &crc::CRC_16_DECT_R),
    ("crc16-dect-x", &crc::CRC_16_DECT_X),
    ("crc16-dnp", &crc::CRC_16_DNP),
    ("crc16-en-13757", &crc::CRC_16_EN_13757),
    ("crc16-genibus", &crc::CRC_16_GENIBUS),
    ("crc16-gsm", &crc::CRC_16_GSM),
    ("crc16-ibm-3740", &crc::CRC_16_IBM_3740),
    ("crc16-ibm-sdlc", &crc::CRC_16_IBM_SDLC),
    ("crc16-iso-iec-14443-3-a", &crc::CRC_16_ISO_IEC_14443_3_A),
    ("crc16-kermit", &crc::CRC_16_KERMIT),
    ("crc16-lj1200", &crc::CRC_16_LJ1200),
    ("crc16-m17", &crc::CRC_16_M17),
    ("crc16-maxim-dow", &crc::CRC_16_MAXIM_DOW),
    ("crc16-mcrf4xx", &crc::CRC_16_MCRF4XX),
    ("crc16-modbus", &crc::CRC_16_MODBUS),
    ("crc16-nrsc-5", &crc::CRC_16_NRSC_5),
    ("crc16-opensafety-a", &crc::CRC_16_OPENSAFETY_A),
    ("crc16-opensafety-b", &crc::CRC_16_OPENSAFETY_B),
    ("crc16-profibus", &crc::CRC_16_PROFIBUS),
    ("crc16-riello", &crc::CRC_16_RIELLO),
    ("crc16-spi-fujitsu", &crc::CRC_16_SPI_FUJITSU),
    ("crc16-t10-dif", &crc::CRC_16_T10_DIF),
    ("crc16-teledisk", &crc::CRC_16_TELEDISK),
    ("crc16-tms37157", &crc::CRC_16_TMS37157),
    ("crc16-umts", &crc::CRC_16_UMTS),
    ("crc16-usb", &crc::CRC_16_USB),
    ("crc16-xmodem", &crc::CRC_16_XMODEM),
];

#[rustfmt::skip]
const CRC_32: Catalogue<u32> = &[
    ("crc32-aixm", &crc::CRC_32_AIXM),
    ("crc32-autosar", &crc::CRC_32_AUTOSAR),
    ("crc32-base91-d", &crc::CRC_32_BASE91_D),
    ("crc32-bzip2", &crc::CRC_32_BZIP2),
    ("crc32-cd-rom-edc", &crc::CRC_32_CD_ROM_EDC),
    ("crc32-cksum", &crc::CRC_32_CKSUM),
    ("crc32-iscsi", &crc::CRC_32_ISCSI),
    ("crc32-iso-hdlc", &crc::CRC_32_ISO_HDLC),
    ("crc32-jamcrc", &crc::CRC_32_JAMCRC),
    ("crc32-mef", &crc::CRC_32_MEF),
    ("crc32-mpeg-2", &crc::CRC_32_MPEG_2),
    ("crc32-xfer", &crc::CRC_32_XFER),
];

#[cfg(test)]
mod tests {
    use super::{CRC_8, CRC_16, CRC_32, Checksum};

    #[test]
    fn every_crc_has_the_check_value_of_the_catalogue() {
        let value = |name: &str| Checksum::named(name).unwrap().value(b"123456789");
        for (name, algorithm) in CRC_8 {
            assert_eq!(value(name), u32::from(algorithm.check), "{name}");
        }
        for (name, algorithm) in CRC_16 {
            assert_eq!(value(name), u32::from(algorithm.check), "{name}");
        }
        for (name, algorithm) in CRC_32 {
            assert_eq!(value(name), algorithm.check, "{name}");
        }
        assert_eq!(Checksum::names().count(), CRC_8.len() + CRC_16.len() + CRC_32.len() + 2);
    }

    #[test]
    fn sums_are_known_by_hand() {
        assert_eq!(Checksum::Sum8.value(&[0xff, 0x02]), 1);
        assert_eq!(Checksum::Xor8.value(&[0xff, 0x02]), 0xfd);
        assert_eq!(Checksum::named("crc17"), None);
    }
}
