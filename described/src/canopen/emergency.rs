//! Emergencies: error codes while a condition holds (CiA 301, 7.2.7).

use super::objects::Objects;

/// An awaited heartbeat did not come.
pub(super) const HEARTBEAT: u16 = 0x8130;
/// A PDO was too short for its mapping.
pub(super) const PDO_LENGTH: u16 = 0x8210;
/// Bits of the error register.
const GENERIC: u8 = 0x01;

/// The bit of the error register for a class of error codes (CiA 301, tables 26 and 49).
const fn bit(code: u16) -> u8 {
    match code >> 12 {
        0x2 => 0x02,
        0x3 => 0x04,
        0x4 => 0x08,
        0x8 => 0x10,
        0xF if code >> 8 == 0xFF => 0x80,
        _ => GENERIC,
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct Errors {
    present: Vec<u16>,
}

impl Errors {
    /// An error appears; returns the message, unless it is there already.
    pub(super) fn raise(&mut self, code: u16, objects: &mut Objects) -> Option<[u8; 8]> {
        if self.present.contains(&code) {
            return None;
        }
        self.present.push(code);
        objects.remember_error(code);
        Some(self.message(code, objects))
    }

    /// An error has gone; returns the message.
    pub(super) fn clear(&mut self, code: u16, objects: &mut Objects) -> Option<[u8; 8]> {
        let place = self.present.iter().position(|known| *known == code)?;
        self.present.remove(place);
        Some(self.message(0, objects))
    }

    fn message(&self, code: u16, objects: &mut Objects) -> [u8; 8] {
        let bits = self.present.iter().fold(0, |bits, code| bits | GENERIC | bit(*code));
        objects.set_error_register(bits);
        let [low, high] = code.to_le_bytes();
        [low, high, bits, 0, 0, 0, 0, 0]
    }
}
