//! PEAK TRC, as PCAN-View, PCAN-Explorer and python-can write it.
//!
//! ```text
//! ;$FILEVERSION=2.1
//! ;$STARTTIME=44548.6028595139
//! ;$COLUMNS=N,O,T,B,I,d,R,L,D
//! ;   a comment
//!       1     17535.400 DT 1  00000100 Tx -  8    00 00 00 00 00 00 00 00
//!       2     17540.300 ST 1         - Rx -  4    00 00 00 08
//!       3     17700.300 RR 1      0123 Rx -  3
//! ```
//!
//! | version | columns |
//! |---|---|
//! | 1.0, which has no `$FILEVERSION` | number, time, identifier, length, data |
//! | 1.1 | number, time, type, identifier, length, data |
//! | 1.2 | number, time, bus, type, identifier, length, data |
//! | 1.3 | number, time, bus, type, identifier, reserved, length, data |
//! | 2.0, 2.1 | those in `$COLUMNS` |
//!
//! * Times are milliseconds since the start of the trace. The start is in days since 1899-12-30, a floating point
//!   number in most programs: it is taken to the microsecond, and as UTC since the file names no zone. Version 1.0 has
//!   a comment with a date; one that is not understood counts as 1970.
//! * Buses are numbers from 1. Number 1 is `can0` here, like channel 1 of an ASC file.
//! * An identifier of more than four digits is an extended one.
//! * Column `L` is a data length code, `l` a length. Some programs write a length into `L`: for a CAN FD frame, whose
//!   code differs from its length, the value that matches the data counts.
//! * An error frame has no details: it becomes [`ErrorFrame::BUS_ERROR`].
//! * Warnings, hardware states, error counters, events and J1939 messages of more than eight bytes are skipped and
//!   counted.
//!
//! Source: PEAK CAN TRC File Format (PEAK-System, 2020-07-27).
//!
//! [`ErrorFrame::BUS_ERROR`]: super::ErrorFrame::BUS_ERROR

mod head;
mod message;
mod read;
mod write;

pub(crate) use read::Reader;
pub(crate) use write::Writer;

/// Nanoseconds of a day, the unit of the start.
const NANOS_A_DAY: u64 = 86_400_000_000_000;
/// Days from 1899-12-30, from which the start counts, to 1970.
const DAYS_TO_1970: u64 = 25_569;
