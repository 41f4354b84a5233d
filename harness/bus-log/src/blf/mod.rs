//! Vector BLF, as Vector's tools and python-can write it.
//!
//! | bytes | contents |
//! |---|---|
//! | 144 | head: `LOGG`, its length, program, sizes, objects, begin and end of the measurement as `SYSTEMTIME` |
//! | … | containers: an object of type 10 with data, mostly compressed by zlib |
//!
//! The containers together hold a stream of objects; one may begin in a container and end in the next. An object is
//! `LOBJ`, the length and version of its head, its own length, its type, flags and a time. All numbers are
//! little-endian.
//!
//! | type | object | read | written |
//! |---|---|---|---|
//! | 1 | `CAN_MESSAGE` | yes | classic frames |
//! | 86 | `CAN_MESSAGE2` | yes | |
//! | 100 | `CAN_FD_MESSAGE` | yes | CAN FD frames |
//! | 101 | `CAN_FD_MESSAGE_64` | yes | |
//! | 2, 73, 104 | `CAN_ERROR`, `CAN_ERROR_EXT`, `CAN_FD_ERROR_64` | yes | 73 |
//! | 65 | `APP_TEXT`, a comment | skipped | which channel is which number |
//!
//! * Times are in units of 10 us or 1 ns, as the flags say, since the start of the measurement, which is taken as UTC
//!   since the file names no zone. A file without a start counts from 1970.
//! * Channels are numbers from 1. Number 1 is `can0` here, as in python-can.
//! * An error frame has no details: it becomes [`ErrorFrame::BUS_ERROR`].
//! * Other objects, and frames that are still to be sent (`TxRq`), are skipped and counted.
//!
//! Source: Vector has published no description. The layout is that of python-can's `can/io/blf.py`, which follows
//! Tobias Lorenz' Vector BLF, and of the files in python-can's tests.
//!
//! [`ErrorFrame::BUS_ERROR`]: super::ErrorFrame::BUS_ERROR

mod containers;
mod date;
mod object;
mod read;
mod write;

pub(crate) use read::Reader;
pub(crate) use write::Writer;

const FILE_MARK: &[u8; 4] = b"LOGG";
const OBJECT_MARK: &[u8; 4] = b"LOBJ";
const FILE_HEAD_BYTES: usize = 144;
/// Offset of the length of the file in its head.
const FILE_LENGTH_AT: usize = 16;
/// Offset of the start of the measurement in the head of a file; its end follows.
const BEGAN_AT: usize = 40;
/// Common start of all objects: mark, lengths, version and type.
const OBJECT_BASE_BYTES: usize = 16;
/// The base with flags and a time, in the first version.
const OBJECT_HEAD_BYTES: usize = 32;
/// Method and length of a container, after its base.
const CONTAINER_HEAD_BYTES: usize = 16;

const CAN_MESSAGE: u32 = 1;
const CAN_ERROR: u32 = 2;
const LOG_CONTAINER: u32 = 10;
const APP_TEXT: u32 = 65;
const CAN_ERROR_EXT: u32 = 73;
const CAN_MESSAGE2: u32 = 86;
const CAN_FD_MESSAGE: u32 = 100;
const CAN_FD_MESSAGE_64: u32 = 101;
const CAN_FD_ERROR_64: u32 = 104;

/// Compression methods of containers.
const STORED: u16 = 0;
const ZLIB: u16 = 2;

/// Object flag: time in units of 10 us.
const TEN_MICROS: u32 = 1;
/// Object flag: time in nanoseconds.
const NANOS: u32 = 2;

const EXTENDED: u32 = 1 << 31;
const SENT: u8 = 1;
/// Frame flag: remote request.
const REMOTE: u8 = 1 << 7;
/// Flags of a `CAN_FD_MESSAGE`: CAN FD frame; bit rate switch; error-passive sender.
const EDL: u8 = 1;
const BRS: u8 = 1 << 1;
const ESI: u8 = 1 << 2;
