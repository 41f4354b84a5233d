//! ASAM MDF 4.1, bus logging: frames of CAN buses as asammdf, CSS Electronics' and Vector's loggers write them.
//!
//! A file is blocks with links to one another; all numbers have the byte order of the little end. A data group has
//! records of one channel group (sorted) or of several (unsorted, each with the number of its group before it). The
//! channels of a group say where in a record a value is.
//!
//! | group | a record here |
//! |---|---|
//! | `CAN_DataFrame` | time 8, `BusChannel` 1, `ID` 4, `IDE` 1, `DLC` 1, `DataLength` 1, `Dir` 1, `EDL` 1, `BRS` 1, `ESI` 1, `DataBytes` 64 |
//! | `CAN_RemoteFrame` | time 8, `BusChannel` 1, `ID` 4, `IDE` 1, `DLC` 1, `DataLength` 1, `Dir` 1 |
//! | `CAN_ErrorFrame` | time 8, `BusChannel` 1 |
//!
//! Written are sorted groups, compressed by deflate: `HL`, `DL` and `DZ` blocks. Times are whole nanoseconds since the begin
//! of the measurement, with a conversion to seconds.
//!
//! Read are sorted and unsorted groups in `DT`, `DZ` (deflate, transposed or not), `DL` and `HL` blocks; data of fixed and of
//! variable length (`SD`, or a group of its own); files of loggers that lost power before they finished them. Groups go by
//! their channels' names; what is none of those above is passed over. Entries of several groups come in the order of their
//! times, those of one group in the order of the file.
//!
//! * `BusChannel` counts from 1: number 1 is `can0` here, as in an ASC file. The number 0, which python-can writes for its
//!   first, is the channel `can`, as it must not be taken for another; without a number it is `can0`.
//! * Of an error frame nothing is known but that it was: it becomes [`ErrorFrame::BUS_ERROR`].
//!
//! [`channels`] are measured values in files of the same blocks.
//!
//! Source: ASAM MDF 4.1.1 and its associated standard for bus logging, as far as asammdf's `v4_blocks.py` and
//! `v4_constants.py` show them.
//!
//! [`ErrorFrame::BUS_ERROR`]: super::ErrorFrame::BUS_ERROR

mod blocks;
mod chain;
pub mod channels;
mod field;
mod frames;
mod groups;
mod head;
mod laid;
mod opening;
mod output;
mod read;
mod stream;
mod variable;
mod write;

pub(crate) use read::Reader;
pub use write::Writer;

/// The begin of a file, and of one that was not finished.
const FILE_MARK: &[u8; 8] = b"MDF     ";
const UNFINISHED_MARK: &[u8; 8] = b"UnFinMF ";
/// Bytes before the first block, the header.
const IDENTIFICATION_BYTES: usize = 64;
/// Mark, reserved, length and number of links of a block.
const BLOCK_HEAD_BYTES: usize = 24;

/// Flags of a channel group: records of variable length; events of a bus, and as they are.
const CG_VARIABLE: u16 = 1;
const CG_BUS_EVENT: u16 = 1 << 1;
const CG_PLAIN: u16 = 1 << 2;

/// Kinds of channels.
const CN_FIXED: u8 = 0;
const CN_VARIABLE: u8 = 1;
const CN_MASTER: u8 = 2;
const CN_VIRTUAL_MASTER: u8 = 3;
const CN_SYNC: u8 = 4;
const CN_MOST: u8 = 5;
const CN_VIRTUAL: u8 = 6;

/// The groups of frames, by the first part of their channels' names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Data,
    Remote,
    Error,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Data, Self::Remote, Self::Error];

    const fn name(self) -> &'static str {
        match self {
            Self::Data => "CAN_DataFrame",
            Self::Remote => "CAN_RemoteFrame",
            Self::Error => "CAN_ErrorFrame",
        }
    }
}
