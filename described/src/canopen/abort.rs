//! Abort codes of SDO transfers.

use std::fmt;

/// Why an SDO transfer was aborted (CiA 301, 7.2.4.3.17).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Abort(pub u32);

impl Abort {
    pub(super) const TOGGLE: Self = Self(0x0503_0000);
    /// The other side does not answer.
    pub const TIMEOUT: Self = Self(0x0504_0000);
    pub(super) const COMMAND: Self = Self(0x0504_0001);
    pub(super) const MEMORY: Self = Self(0x0504_0005);
    pub(super) const ACCESS: Self = Self(0x0601_0000);
    pub(super) const WRITE_ONLY: Self = Self(0x0601_0001);
    pub(super) const READ_ONLY: Self = Self(0x0601_0002);
    pub(super) const NOT_EMPTY: Self = Self(0x0601_0003);
    pub(super) const NO_OBJECT: Self = Self(0x0602_0000);
    pub(super) const NOT_MAPPABLE: Self = Self(0x0604_0041);
    pub(super) const PDO_LENGTH: Self = Self(0x0604_0042);
    pub(super) const TOO_LONG: Self = Self(0x0607_0012);
    pub(super) const TOO_SHORT: Self = Self(0x0607_0013);
    pub(super) const NO_SUB: Self = Self(0x0609_0011);
    pub(super) const RANGE: Self = Self(0x0609_0030);
    pub(super) const TOO_HIGH: Self = Self(0x0609_0031);
    pub(super) const TOO_LOW: Self = Self(0x0609_0032);

    /// What the code means, in the standard's wording; `None` for a code that the standard does not list.
    pub const fn meaning(self) -> Option<&'static str> {
        Some(match self.0 {
            0x0503_0000 => "toggle bit not alternated",
            0x0504_0000 => "SDO protocol timed out",
            0x0504_0001 => "client/server command specifier not valid or unknown",
            0x0504_0002 => "invalid block size",
            0x0504_0003 => "invalid sequence number",
            0x0504_0004 => "CRC error",
            0x0504_0005 => "out of memory",
            0x0601_0000 => "unsupported access to an object",
            0x0601_0001 => "attempt to read a write only object",
            0x0601_0002 => "attempt to write a read only object",
            0x0601_0003 => "sub-index cannot be written, sub-index 0 must be 0 for write access",
            0x0602_0000 => "object does not exist in the object dictionary",
            0x0604_0041 => "object cannot be mapped to the PDO",
            0x0604_0042 => "number and length of the objects to be mapped would exceed PDO length",
            0x0604_0043 => "general parameter incompatibility",
            0x0604_0047 => "general internal incompatibility in the device",
            0x0606_0000 => "access failed due to a hardware error",
            0x0607_0010 => "data type or length of service parameter does not match",
            0x0607_0012 => "data type does not match, length of service parameter too high",
            0x0607_0013 => "data type does not match, length of service parameter too low",
            0x0609_0011 => "sub-index does not exist",
            0x0609_0030 => "invalid value for parameter",
            0x0609_0031 => "value of parameter written too high",
            0x0609_0032 => "value of parameter written too low",
            0x0609_0036 => "maximum value is less than minimum value",
            0x060A_0023 => "resource not available: SDO connection",
            0x0800_0000 => "general error",
            0x0800_0020 => "data cannot be transferred or stored to the application",
            0x0800_0021 => {
                "data cannot be transferred or stored to the application because of local control"
            }
            0x0800_0022 => {
                "data cannot be transferred or stored to the application because of the present device state"
            }
            0x0800_0023 => {
                "object dictionary dynamic generation fails or no object dictionary is present"
            }
            0x0800_0024 => "no data available",
            _ => return None,
        })
    }
}

/// `0602 0000h (object does not exist in the object dictionary)`.
impl fmt::Display for Abort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (high, low) = (self.0 >> 16, self.0 & 0xFFFF);
        let meaning = self.meaning().unwrap_or("a code of the manufacturer");
        write!(f, "{high:04X} {low:04X}h ({meaning})")
    }
}
