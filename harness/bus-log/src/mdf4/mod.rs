//! ASAM MDF 4.1, bus logging: frames of CAN buses as written by asammdf and by the loggers of CSS Electronics and
//! Vector.
//!
//! A file consists of blocks with links to each other; all numbers are little-endian. A data group has records of one
//! channel group (sorted) or of several (unsorted, each after the number of its group). The channels of a group define
//! the places of values in a record.
//!
//! | group | record as written here |
//! |---|---|
//! | `CAN_DataFrame` | time 8, `BusChannel` 1, `ID` 4, `IDE` 1, `DLC` 1, `DataLength` 1, `Dir` 1, `EDL` 1, `BRS` 1, `ESI` 1, `DataBytes` 64 |
//! | `CAN_RemoteFrame` | time 8, `BusChannel` 1, `ID` 4, `IDE` 1, `DLC` 1, `DataLength` 1, `Dir` 1 |
//! | `CAN_ErrorFrame` | time 8, `BusChannel` 1 |
//!
//! The writer makes sorted groups, compressed by deflate: `HL`, `DL` and `DZ` blocks. Times are whole nanoseconds since
//! the start of the measurement, with a conversion to seconds.
//!
//! Of a file that was cut, what its groups have before the cut is read; the entries of a group that had not been written
//! then are missing among them.
//!
//! The reader handles sorted and unsorted groups in `DT`, `DZ` (deflate, transposed or not), `DL` and `HL` blocks; data
//! of fixed and of variable length (`SD`, or a separate group); files of loggers that lost power before they finished
//! them. Groups are recognized by the names of their channels; others are skipped. Entries of several groups are merged
//! in the order of their times, those of one group keep the order of the file.
//!
//! * `BusChannel` counts from 1: number 1 is `can0` here, as in an ASC file. The number 0, which python-can writes for
//!   its first channel, becomes the channel `can`, to keep it distinct; without a number it is `can0`.
//! * An error frame has no details: it becomes [`ErrorFrame::BUS_ERROR`].
//!
//! [`channels`] reads and writes measured values in files of the same blocks.
//!
//! Source: ASAM MDF 4.1.1 and its associated standard for bus logging, as far as they show in asammdf's `v4_blocks.py`
//! and `v4_constants.py`.
//!
//! [`ErrorFrame::BUS_ERROR`]: super::ErrorFrame::BUS_ERROR

mod blocks;
mod buffered;
mod chain;
pub mod channels;
mod field;
mod frames;
mod groups;
mod head;
mod laid;
mod lost;
mod output;
mod read;
mod stream;
mod unsorted;
mod variable;
mod walk;
mod write;

pub(crate) use read::Reader;
pub(crate) use write::Writer;

/// Start of a file, finished and unfinished.
const FILE_MARK: &[u8; 8] = b"MDF     ";
const UNFINISHED_MARK: &[u8; 8] = b"UnFinMF ";
/// Bytes before the first block, the header.
const IDENTIFICATION_BYTES: usize = 64;
/// Mark, reserved, length and number of links of a block.
const BLOCK_HEAD_BYTES: usize = 24;

/// Flags of a channel group: records of variable length; bus events; plain bus events.
const CG_VARIABLE: u16 = 1;
const CG_BUS_EVENT: u16 = 1 << 1;
const CG_PLAIN: u16 = 1 << 2;
/// Flag of a channel group whose time is in another one: column-oriented storage of MDF 4.2.
const CG_REMOTE_MASTER: u16 = 1 << 3;

const CN_FIXED: u8 = 0;
const CN_VARIABLE: u8 = 1;
const CN_MASTER: u8 = 2;
const CN_VIRTUAL_MASTER: u8 = 3;
const CN_SYNC: u8 = 4;
const CN_MOST: u8 = 5;
const CN_VIRTUAL: u8 = 6;

wire::tabled! {
    /// The groups of frames.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Kind {
        Data = "CAN_DataFrame",
        Remote = "CAN_RemoteFrame",
        Error = "CAN_ErrorFrame",
    }
    /// The first part of their channels' names.
    fn name() -> &'static str
}
