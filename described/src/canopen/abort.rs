//! Abort codes of SDO transfers.

use crate::codes::codes;
use std::fmt;

/// Why an SDO transfer was aborted (CiA 301, 7.2.4.3.17).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Abort(pub u32);

impl Abort {
    codes! { pub Self(u32);
        TOGGLE = 0x0503_0000, "toggle bit not alternated";
        TIMEOUT = 0x0504_0000, "SDO protocol timed out";
        COMMAND = 0x0504_0001, "client/server command specifier not valid or unknown";
        _ = 0x0504_0002, "invalid block size";
        _ = 0x0504_0003, "invalid sequence number";
        _ = 0x0504_0004, "CRC error";
        MEMORY = 0x0504_0005, "out of memory";
        ACCESS = 0x0601_0000, "unsupported access to an object";
        WRITE_ONLY = 0x0601_0001, "attempt to read a write only object";
        READ_ONLY = 0x0601_0002, "attempt to write a read only object";
        NOT_EMPTY = 0x0601_0003,
            "sub-index cannot be written, sub-index 0 must be 0 for write access";
        NO_OBJECT = 0x0602_0000, "object does not exist in the object dictionary";
        NOT_MAPPABLE = 0x0604_0041, "object cannot be mapped to the PDO";
        PDO_LENGTH = 0x0604_0042,
            "number and length of the objects to be mapped would exceed PDO length";
        _ = 0x0604_0043, "general parameter incompatibility";
        _ = 0x0604_0047, "general internal incompatibility in the device";
        _ = 0x0606_0000, "access failed due to a hardware error";
        _ = 0x0607_0010, "data type or length of service parameter does not match";
        TOO_LONG = 0x0607_0012, "data type does not match, length of service parameter too high";
        TOO_SHORT = 0x0607_0013, "data type does not match, length of service parameter too low";
        NO_SUB = 0x0609_0011, "sub-index does not exist";
        RANGE = 0x0609_0030, "invalid value for parameter";
        TOO_HIGH = 0x0609_0031, "value of parameter written too high";
        TOO_LOW = 0x0609_0032, "value of parameter written too low";
        _ = 0x0609_0036, "maximum value is less than minimum value";
        _ = 0x060A_0023, "resource not available: SDO connection";
        _ = 0x0800_0000, "general error";
        _ = 0x0800_0020, "data cannot be transferred or stored to the application";
        _ = 0x0800_0021,
            "data cannot be transferred or stored to the application because of local control";
        _ = 0x0800_0022,
            "data cannot be transferred or stored to the application because of the present device state";
        _ = 0x0800_0023,
            "object dictionary dynamic generation fails or no object dictionary is present";
        NO_DATA = 0x0800_0024, "no data available";
    }

    /// What the code means, in the standard's wording; `None` for a code that the standard does not list.
    pub const fn meaning(self) -> Option<&'static str> {
        Self::text(self.0)
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
