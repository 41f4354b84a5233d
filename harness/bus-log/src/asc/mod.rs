//! Vector ASC, as Vector's tools, `log2asc` and python-can write it.
//!
//! ```text
//! date Sat Sep 30 15:06:13.191 2017
//! base hex  timestamps absolute
//! no internal events logged
//! // a comment
//! Begin Triggerblock Sat Sep 30 15:06:13.191 2017
//!    0.000000 Start of measurement
//!    0.000271 1  6F9             Rx   d 8 05 0C 00 00 00 00 00 00  Length = 240015 BitCount = 124 ID = 1785
//!    1.300981 1  18EBFF00x       Tx   r 8
//!    2.501000 2  ErrorFrame
//!    2.515992 CANFD   1 Rx        300                                   1 0 9 12 01 02 ... 130000  130  303000 0
//! End TriggerBlock
//! ```
//!
//! * `base dec` makes identifiers, data and DLC of events decimal. Lengths in CANFD events always are.
//! * `timestamps relative`: each time counts from the previous event of any kind.
//! * Channels are numbers from 1. Number 1 is `can0` here, as in python-can and `asc2log`.
//! * An absolute time is the date of the measurement, taken as UTC since the file names no zone, plus the time of the
//!   event. The names of months may be in the languages of Europe, or numbers. A date that is not understood counts as
//!   1970, and the reader says so.
//! * An error frame has no details: it becomes [`ErrorFrame::BUS_ERROR`].
//! * CANFD events also carry classic frames: those with flags, and EDL not among them.
//! * Every other event (statistics, status, LIN, J1939) is skipped and counted.
//!
//! [`ErrorFrame::BUS_ERROR`]: super::ErrorFrame::BUS_ERROR

mod date;
mod event;
mod read;
mod write;

pub(crate) use read::Reader;
pub(crate) use write::Writer;

/// Flag of a CANFD event: extended data length, that is, a CAN FD frame.
const EDL: u32 = 1 << 12;
/// Bit rate switch.
const BRS: u32 = 1 << 13;
/// Error state indicator.
const ESI: u32 = 1 << 14;
/// Remote request.
const RTR: u32 = 1 << 4;
